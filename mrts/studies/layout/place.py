# SPDX-License-Identifier: MIT
"""The best layout of a study: a small sweep for starts, IPOPT from the best of them, `scale` for the last word.

What a program promises counts only as far as the cell then does it.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.argument_types import Progress, check_callable, check_type
from mrts.base.arrays import Array
from mrts.base.errors import InputError, MotionError, MrtsError
from mrts.base.held_interrupt import held_interrupt
from mrts.cell.cell import Cell
from mrts.cell.generation import symbolic_functions
from mrts.collisions.clearance import clearance_remarks
from mrts.motion.motion_file import MotionDescription, sample_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.program.excess import BETWEEN, checked_tolerance
from mrts.scaling.result import ScalingResult
from mrts.scaling.scale import scale
from mrts.studies.distributions import Distribution
from mrts.studies.layout.layout_numbers import LayoutNumbers
from mrts.studies.layout.layout_program import LayoutAnswer, solve_layout
from mrts.studies.layout.placement import NO_GAIN, Placement, PlayedLayout
from mrts.studies.sampling import sample_points
from mrts.studies.study import Study
from mrts.studies.study_file import read_study

STARTS = 3
"""Layouts from which IPOPT searches, the best of those that were looked at."""

LOOKED_AT = 64
"""Layouts that are looked at for starts."""

MAX_LAYOUTS = 100_000
"""That may be: an hour of looking."""

SEED = 17

COARSE_SAMPLES = 25
"""Samples of the first program; samples that turn out to bind are added."""

MAX_ROUNDS = 6
"""Most programs from one start."""

MISSING_SAMPLE = 1e-4
"""Share by which c²⁺ of all samples may be less than that of the program's: then no sample between is missing."""

OTHER_POSITIONS = 1e-2
"""Share above which it is not samples: the arms took other joint positions than the program's."""

POSTURE_DIGITS = 4
"""Decimals of a posture that is written to keep the program's joint positions; it only says near which to start."""


def place(
    study: Study | Path | str,
    *,
    starts: int = STARTS,
    looked_at: int = LOOKED_AT,
    between: float | None = BETWEEN,
    progress: Progress = lambda _done, _total: None,
) -> Placement:
    """Base poses, grasps and postures, within the bounds of a study, that give the largest c²⁺.

    The layouts looked at first are points of a Sobol sequence between the bounds, and the layout that the cell file
    gives. From the best of them IPOPT searches the nearest local optimum (`mrts.studies.layout.layout_program`);
    what it finds counts only as `mrts.scale` confirms it, so the answer is never worse than the best start. Layouts in
    which bodies collide (`mrts.clearance`) are no answer. Ctrl-C keeps the best so far.

    Args:
        study: The study, or its file; `vary` names numbers of base, grasp or posture, each `from` and `to`.
        starts: From how many layouts to search.
        looked_at: Of how many.
        between: Share of a limit by which it may be overstepped between the samples, as in `mrts.scale`, before and
            after; the search itself looks at samples alone.
        progress: Told how many of how many pieces of work are done.

    Returns:
        The outcome. Where no layout within the bounds can be played, it has no answer.

    Raises:
        InputError: If the study varies what is no layout, or asks what does not fit.
        SolverError: If no solver answers.
    """
    if not isinstance(study, Study):
        study = read_study(study)
    for name, value in (("starts", starts), ("looked_at", looked_at)):
        check_type(name, value, int)
        if not 1 <= value <= MAX_LAYOUTS:
            raise InputError(name, f"must be at least 1, and at most {MAX_LAYOUTS}.", value=value)
    check_callable("progress", progress)
    tolerance = checked_tolerance(between)
    if study.question.load == "possible":
        rule = "the best layout is one for loads that are known, or for every load of a box: nominal or guaranteed."
        raise InputError(study.path, rule, key="load", value="possible")
    search = LayoutSearch(study, tolerance)
    with held_interrupt() as pressed:
        search.over = lambda: bool(pressed)
        counts = search.run(starts, looked_at, progress)
        interrupted = search.over()
        pressed.clear()
    progress(looked_at + starts, looked_at + starts)
    after = search.best_played()
    return Placement(
        study=search.study,
        numbers=search.numbers,
        before=None if search.given is None else search.played(search.given),
        after=after,
        reason=search.failures[-1] if search.failures else "",
        interrupted=interrupted,
        colliding=search.colliding,
        **counts,
    )


class LayoutSearch:
    """Tries layouts of a study and improves them.

    Args:
        study: The study.
        between: As in `place`.

    Attributes:
        given: What the cell can do as its file has it; None if it can do nothing.
        found: All layouts that can be played at the samples.
        failures: Why others cannot.
        colliding: How many were the fastest, but for a collision.
        over: Says whether to come to the end.
    """

    def __init__(self, study: Study, between: float | None = None) -> None:
        study = study.at_hand()
        cell = Cell.from_description(study.cell, folder=study.folder).with_limits(*study.limits)
        self.study, self.between = study, between
        self.numbers, self.motion = LayoutNumbers.of(study, cell), _object_motion(study)
        self.functions = symbolic_functions(study.cell, study.folder.absolute())
        self.machines = cell.machines
        self.over: Callable[[], bool] = lambda: False
        self.found: list[PlayedLayout] = []
        self.failures: list[str] = []
        self.colliding = 0
        nearest, is_layout = self.numbers.nearest_given()
        self.given = self._scaled(study.cell, nearest, None)
        if self.given is not None and is_layout:
            self.found.append(self.given)

    def run(self, starts: int, looked_at: int, progress: Progress) -> dict[str, int]:
        """Look at layouts, and search from the best; counts those looked at, those playable, and the searches."""
        counts = {"looked_at": 0, "playable": 0, "searches": 0}
        bounds = zip(self.numbers.lower, self.numbers.upper, strict=True)
        points = sample_points([Distribution("uniform", pair) for pair in bounds], "sobol", SEED, (0, looked_at))
        for values in self.numbers.rounded(points):
            if self.over():
                break
            progress(counts["looked_at"], looked_at + starts)
            counts["looked_at"] += 1
            tried = self.tried(values)
            if tried is not None:
                counts["playable"] += 1
                self.found.append(tried)
        for start in sorted(self.found, key=lambda one: -one.c2)[:starts]:
            if self.over():
                break
            progress(looked_at + counts["searches"], looked_at + starts)
            counts["searches"] += 1
            self.improve(start)
        return counts

    def tried(self, values: Array, postures: dict[str, list[float]] | None = None) -> PlayedLayout | None:
        """What the cell can do in a layout at the given samples; None if it can do nothing.

        Args:
            values: Of the numbers, Shape (P,).
            postures: By robot, instead of the study's [rad or m].
        """
        keys = self.study.descriptions(values)[0]
        for robot in keys["robots"]:
            robot["posture"] = (postures or {}).get(robot["name"], robot["posture"])
        return self._scaled(keys, values, postures)

    def _scaled(
        self, keys: dict[str, Any], values: Array, postures: dict[str, list[float]] | None
    ) -> PlayedLayout | None:
        asked = self.study.question
        try:
            cell = Cell.from_description(keys, folder=self.study.folder).with_limits(*self.study.limits)
            parted = set(self.machines) - set(cell.machines)
            if parted:
                rule = "robots '{}' and '{}' are arms of one machine: their bases move together. Let one parameter "
                raise MotionError(f"{rule}move both.".format(*min(parted)))
            result = _with_trajectory(scale(cell, self.motion, load=asked.load, reserve=asked.reserve, between=None))
        except MrtsError as error:
            self.failures.append(str(error))
            return None
        return PlayedLayout(keys, values, None, result, postures)

    def improve(self, start: PlayedLayout) -> None:
        """Search from a layout; whatever the cell can play on the way joins those that were found."""
        samples = _coarse_samples(start)
        best = start
        for _ in range(MAX_ROUNDS):
            if self.over() or not np.isfinite(best.c2):
                return
            answer = solve_layout(self.functions, self.numbers, best.values, best.result, samples, stop=self.over)
            reached = self._reached(best, answer)
            if reached is None:
                return
            self.found.append(reached)
            best = max(best, reached, key=lambda playable: playable.c2)
            short = reached.result.range.samples.upper < answer.c2 * (1 - MISSING_SAMPLE)
            more = np.setdiff1d(np.flatnonzero(short), samples)
            if not more.size:
                return
            samples = np.union1d(samples, more)

    def _reached(self, start: PlayedLayout, answer: LayoutAnswer) -> PlayedLayout | None:
        """What the cell does in the layout of an answer; None where it can do nothing.

        Where the study's postures lead the arms elsewhere than in the program, these are its first joint positions.
        """
        values = self.numbers.rounded(answer.layout)
        reached = self.tried(values)
        if reached is None or reached.c2 < answer.c2 * (1 - OTHER_POSITIONS):
            parts = start.result.cell.joint_slices.items()
            postures = {name: np.round(answer.start[part], POSTURE_DIGITS).tolist() for name, part in parts}
            again = self.tried(values, postures)
            if again is not None and (reached is None or again.c2 > reached.c2):
                reached = again
        return None if reached is None else replace(reached, slope=answer.slope)

    def best_played(self) -> PlayedLayout | None:
        """The best, and the best start, which might be better between the samples, less what moved for nothing."""
        best_first = sorted(self.found, key=lambda one: -one.c2)
        groups = best_first, [one for one in best_first if one.slope is None]
        played = (next(filter(None, (self._free(self._settled(one)) for one in group)), None) for group in groups)
        return max(filter(None, played), key=lambda layout: layout.c2, default=None)

    def _settled(self, best: PlayedLayout) -> PlayedLayout:
        """The same with every number that gains nothing where the cell file has it."""
        values, _ = self.numbers.nearest_given()
        for place, value in enumerate(values):
            moved = np.where(np.arange(len(values)) == place, value, best.values)
            if moved[place] != best.values[place]:
                tried = self.tried(moved, best.postures)
                if tried is not None and tried.c2 >= best.c2 * (1 - NO_GAIN):
                    best = replace(tried, slope=best.slope)
        return best

    def _free(self, layout: PlayedLayout) -> PlayedLayout | None:
        """As `played`; None too if two bodies collide."""
        played = self.played(layout)
        if played is None:
            return None
        near, said = clearance_remarks(played.result.cell, played.result.motion)
        if near is not None and near.collides:
            self.failures.append(near.sentence())
            self.colliding += 1
            return None
        return replace(played, collisions=said)

    def played(self, layout: PlayedLayout) -> PlayedLayout | None:
        """A layout between the samples too; None if it cannot be played there."""
        cell, load = layout.result.cell, self.study.question.load
        try:
            result = _with_trajectory(scale(cell, self.motion, load=load, between=self.between))
        except MrtsError as error:
            self.failures.append(str(error))
            return None
        return replace(layout, result=result)


def _with_trajectory(result: ScalingResult) -> ScalingResult:
    if result.trajectory is None:
        raise MotionError(f"{result.status.value}: {result.explanation()}")
    return result


def _coarse_samples(start: PlayedLayout) -> NDArray[np.intp]:
    count, end = start.result.motion.samples, start.result.range.upper
    spread = np.linspace(0, count - 1, min(COARSE_SAMPLES, count)).round().astype(np.intp)
    return np.union1d(spread, [] if end is None or end.sample is None else [end.sample]).astype(np.intp)


def _object_motion(study: Study) -> ObjectMotion:
    if study.table is None:
        return sample_motion(MotionDescription(**study.motion))
    if isinstance(study.table, ObjectMotion):
        return study.table
    rule = "a table of joint motion fixes where the arms stand; give the object's motion."
    raise InputError(study.path, rule, key="motion")
