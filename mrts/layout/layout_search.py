# SPDX-License-Identifier: MIT
"""Layouts tried and improved: what a program promises counts only as far as the cell then does it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import MrtsError
from mrts.cell.cell import Cell
from mrts.cell.generation import symbolic_functions
from mrts.layout.layout_numbers import LayoutNumbers
from mrts.layout.layout_program import LayoutAnswer, LayoutProgram, LayoutStart
from mrts.motion.object_motion import ObjectMotion
from mrts.scaling.result import ScalingResult
from mrts.scaling.scale import scale
from mrts.studies.study import Study

COARSE = 25
"""Samples of the first program; samples that turn out to bind are added."""

ROUNDS = 6
"""Most programs from one start."""

KEPT_PROMISE = 1e-4
"""Share by which c²⁺ of all samples may be less than that of the program's: then no sample between is missing."""

BROKEN_PROMISE = 1e-2
"""Share above which it is not samples: the arms took other joint positions than the program's."""

NO_GAIN = 1e-9
"""Share of c²⁺ that is no reason to move an arm: rounding."""

POSTURE_DIGITS = 4
"""Decimals of a posture that is written to keep the program's joint positions; it only says near which to start."""


@dataclass(frozen=True, eq=False)
class Playable:
    """A layout that the cell can play.

    Attributes:
        values: Of the numbers of the layout, Shape (P,); None of the cell as its file has it, where none give that.
        keys: Keys and values of its cell file.
        result: What `mrts.scale` finds of the given samples.
        postures: By robot, where they are not the study's [rad or m]; None where they are.
        slope: ∂ ln c²⁺/∂values, Shape (P,), where a program ended there; else None.
    """

    values: Array | None
    keys: dict[str, Any]
    result: ScalingResult
    postures: dict[str, list[float]] | None = None
    slope: Array | None = None

    @property
    def c2(self) -> float:
        """c²⁺ at the given samples; infinity if nothing limits it."""
        assert self.result.range.upper is not None  # noqa: S101 (checked where it is made)
        return self.result.range.upper.c2


class LayoutSearch:
    """Tries layouts of a study and improves them.

    Args:
        study: The study.
        numbers: Its numbers.
        motion: Motion of the object.
        cell: The cell of the study.
        over: Says whether to come to the end.
    """

    def __init__(
        self,
        study: Study,
        numbers: LayoutNumbers,
        motion: ObjectMotion,
        cell: Cell,
        over: Callable[[], bool],
    ) -> None:
        self.study, self.numbers, self.motion, self.over = study, numbers, motion, over
        self.functions = symbolic_functions(study.cell, study.folder.absolute())
        self.machines = cell.functions.manifest.machines

    def tried(self, values: Array, postures: dict[str, list[float]] | None = None) -> Playable | str:
        """What the cell can do in a layout, or why it can do nothing.

        Args:
            values: Of the numbers, Shape (P,).
            postures: By robot, instead of the study's [rad or m].
        """
        keys = self.study.descriptions(values)[0]
        for robot in keys["robots"]:
            robot["posture"] = (postures or {}).get(robot["name"], robot["posture"])
        found = self.of_keys(keys, values)
        return found if isinstance(found, str) else replace(found, postures=postures)

    def of_keys(self, keys: dict[str, Any], values: Array | None) -> Playable | str:
        """What the cell of a description can do, or why it can do nothing.

        Args:
            keys: Keys and values of its cell file.
            values: Of the numbers that give them, Shape (P,); None if none do.
        """
        asked = self.study.question
        try:
            cell = Cell.from_description(keys, folder=self.study.folder).with_limits(*self.study.limits)
            parted = set(self.machines) - set(cell.functions.manifest.machines)
            if parted:
                first, second = min(parted)
                return (
                    f"robots '{first}' and '{second}' are arms of one machine: their bases move together. Let one knob "
                    "move both."
                )
            result = scale(cell, self.motion, load=asked.load, reserve=asked.reserve, between=None)
        except MrtsError as error:
            return str(error)
        if result.trajectory is None:
            return f"{result.status.value}: {result.explanation()}"
        return Playable(values, keys, result)

    def improve(self, start: Playable, found: list[Playable]) -> None:
        """Search from a layout; whatever the cell can play on the way joins those that were found.

        Args:
            start: The layout.
            found: All that were found.
        """
        samples = _coarse_samples(start)
        best = start
        for _ in range(ROUNDS):
            if self.over() or not np.isfinite(best.c2):
                return
            answer = self._solved(best, samples)
            reached = self._reached(best, answer)
            if reached is None:
                return
            found.append(reached)
            best = max(best, reached, key=lambda playable: playable.c2)
            short = reached.result.range.samples.upper < answer.c2 * (1 - KEPT_PROMISE)
            more = np.setdiff1d(np.flatnonzero(short), samples)
            if not more.size:
                return
            samples = np.union1d(samples, more)

    def settled(self, best: Playable) -> Playable:
        """The same with every number that gains nothing where the cell file has it.

        Args:
            best: The best layout.
        """
        values, _ = self.numbers.nearest_given()
        for place, value in enumerate(values):
            assert best.values is not None  # noqa: S101 (a layout of the study)
            moved = np.where(np.arange(len(values)) == place, value, best.values)
            if moved[place] != best.values[place]:
                tried = self.tried(moved, best.postures)
                if not isinstance(tried, str) and tried.c2 >= best.c2 * (1 - NO_GAIN):
                    best = replace(tried, slope=best.slope)
        return best

    def _solved(self, start: Playable, samples: NDArray[np.intp]) -> LayoutAnswer:
        result = start.result
        assert start.values is not None and result.trajectory is not None  # noqa: S101, PT018 (it is playable)
        loads = [result.cell.load] if result.load is None else [point.load for point in result.load.points]
        begun = LayoutStart(
            cell=result.cell,
            layout=start.values,
            motion=result.motion,
            wrench=result.trajectory.wrench,
            c2=start.c2,
            loads=tuple(loads),
        )
        return LayoutProgram(self.functions, self.numbers, begun, samples).solve(stop=self.over)

    def _reached(self, start: Playable, answer: LayoutAnswer) -> Playable | None:
        """What the cell does in the layout of an answer; None where it can do nothing.

        Where the study's postures lead the arms elsewhere than in the program, these are its first joint positions.
        """
        values = self.numbers.rounded(answer.layout)
        reached = self.tried(values)
        if isinstance(reached, str) or reached.c2 < answer.c2 * (1 - BROKEN_PROMISE):
            parts = start.result.cell.joint_slices.items()
            postures = {name: np.round(answer.start[part], POSTURE_DIGITS).tolist() for name, part in parts}
            again = self.tried(values, postures)
            if not isinstance(again, str) and (isinstance(reached, str) or again.c2 > reached.c2):
                reached = again
        return None if isinstance(reached, str) else replace(reached, slope=answer.slope)


def _coarse_samples(start: Playable) -> NDArray[np.intp]:
    """Evenly spaced samples with both ends, and the one that binds."""
    count, end = start.result.motion.samples, start.result.range.upper
    spread = np.linspace(0, count - 1, min(COARSE, count)).round().astype(np.intp)
    return np.union1d(spread, [] if end is None or end.sample is None else [end.sample]).astype(np.intp)
