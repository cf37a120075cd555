# SPDX-License-Identifier: MIT
"""What `mrts.place` found."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mrts.base.argument_types import as_path
from mrts.base.arrays import Array
from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import InputError
from mrts.base.printable import printable
from mrts.base.remark import Remark
from mrts.cell.number_paths import value_at
from mrts.scaling.result import ScalingResult, kept_text
from mrts.studies.study import Study

NO_GAIN = 1e-9
"""Share of c²⁺ that is no reason to move an arm: rounding."""

AT_BOUND = 1e-6
"""Share of its range by which a number may miss its bound and is at it all the same."""

STEPS = {"m": (0.01, "10 mm"), "rad": (float(np.radians(1)), "1°")}
"""Step of a number past its bound by its unit, and how it is called."""

WORTH_TELLING = 1e-3
"""Share of c²⁺ that a step past a bound must gain to be told."""


@dataclass(frozen=True, eq=False, repr=False)
class PlayedLayout:
    """One layout and what the cell does in it.

    Attributes:
        keys: Keys and values of its cell file.
        values: Of the numbers of the study, Shape (P,): those of the cell file, where no values give that, the nearest.
        slope: ∂ ln c²⁺/∂values, Shape (P,), where a search ended there; else None.
        result: What `mrts.scale` finds, between the samples too.
        postures: By robot, where they are not the study's [rad or m]; None where they are.
        collisions: What is to say of them.
    """

    keys: dict[str, Any]
    values: Array
    slope: Array | None
    result: ScalingResult
    postures: dict[str, list[float]] | None = None
    collisions: tuple[Remark, ...] = ()

    @property
    def c2(self) -> float:
        """c²⁺; infinity if nothing limits it."""
        return self.result.range.c2_upper

    @property
    def duration(self) -> float:
        """Of the motion at the fastest constant factor [s]; 0 if nothing limits it."""
        return float(self.result.motion.object.time[-1] / np.sqrt(self.c2))


@dataclass(frozen=True, eq=False, repr=False)
class Placement:
    """The best layout of a study.

    Attributes:
        study: The study.
        before: The layout of the cell file; None if it cannot be played.
        after: The best layout within the bounds; None if none that was looked at can be played.
        reason: Why a layout that was looked at cannot be played; empty if all can.
        looked_at: Number of layouts that were looked at.
        playable: How many of them can be played.
        searches: Number of layouts from which a search began.
        interrupted: Whether Ctrl-C ended the search early.
        colliding: Number of faster layouts that were passed over because bodies collide.
    """

    study: Study
    before: PlayedLayout | None
    after: PlayedLayout | None
    reason: str
    looked_at: int
    playable: int
    searches: int
    interrupted: bool
    colliding: int

    def __repr__(self) -> str:
        return f"<Placement: {self.sentence()}>"

    @property
    def gain(self) -> float:
        """Share by which c²⁺ grew; nan where there is no before or after, or nothing limits both."""
        if self.before is None or self.after is None or np.isinf(self.before.c2):
            return float("nan")
        return self.after.c2 / self.before.c2 - 1

    def sentence(self) -> str:
        """The outcome."""
        after, before = self.after, self.before
        name = f"{self.study.cell['name']}: {kept_text(self.study.question.reserve or 0)}".rstrip()
        if after is None:
            return f"{name} none of {self.looked_at} layouts within the bounds can be played. {self.reason}"
        if before is None:
            return (
                f"{name} c² up to {after.c2:.4g}, {after.duration:.4g} s; the layout of the cell file cannot be played"
            )
        if after.c2 <= before.c2 * (1 + NO_GAIN):
            return f"{name} no layout was found that is better than that of the cell file, c² up to {before.c2:.4g}"
        return (
            f"{name} c² up to {after.c2:.4g} instead of {before.c2:.4g} ({100 * self.gain:+.1f} %), "
            f"{after.duration:.4g} s instead of {before.duration:.4g} s"
        )

    def lines(self) -> Iterator[str]:
        """What the command line says: the outcome, what moved, what binds, and which bounds are worth widening."""
        yield self.sentence()
        after, before = self.after, self.before
        if after is None:
            return
        for word, layout in (("limited", after), ("before", before)):
            end = None if layout is None else layout.result.range.upper
            if end is not None and end.time is not None:
                yield f"{word} {end.place()}"
        yield ""
        yield from self._moved()
        yield from self._bounds()
        ended = "; ended by Ctrl-C" if self.interrupted else ""
        yield (
            f"searched from the best {self.searches} of {self.looked_at} layouts, of which "
            f"{self.playable} can be played{ended}"
        )
        if self.colliding:
            yield f"layouts passed over because bodies collide: {self.colliding}"
        yield from (remark.text for remark in after.collisions)

    def moved(self) -> list[tuple[str, str, float, float]]:
        """Path, unit, value before and after of each number that the study sets, and of postures that followed."""
        assert self.after is not None  # noqa: S101 (asked for of an answer only)
        ours, theirs = ({"cell": keys} for keys in (self.study.cell, self.after.keys))
        targets = [target for parameter in self.study.parameters for target in parameter.targets]
        moved = [
            (target.path, target.unit, float(value_at(ours, target.keys)), float(value_at(theirs, target.keys)))
            for target in targets
        ]
        named = {path for path, *_ in moved}
        for own, new in zip(self.study.cell["robots"], self.after.keys["robots"], strict=True):
            for joint, pair in enumerate(zip(own["posture"], new["posture"], strict=True)):
                path = f"robots.{own['name']}.posture[{joint}]"
                if path not in named and pair[0] != pair[1]:
                    moved.append((path, "", *pair))
        return moved

    def _moved(self) -> Iterator[str]:
        rows = self.moved()
        width = max(len(path) for path, *_ in rows)
        yield f"{'what may move':<{width}} {'before':>12} {'after':>12}"
        for path, unit, before, after in rows:
            now = "stays" if after == before else f"{after:.6g}"
            yield f"{path:<{width}} {before:>12.6g} {now:>12} {unit}".rstrip()
        yield ""

    def _bounds(self) -> Iterator[str]:
        after = self.after
        if after is None or after.slope is None:
            return
        for index, parameter in enumerate(self.study.parameters):
            (low, *_, high), value = parameter.distribution.numbers, after.values[index]
            side = -1 if value - low <= AT_BOUND * (high - low) else 1 if high - value <= AT_BOUND * (high - low) else 0
            step, word = STEPS.get(parameter.unit, (0.01, "0.01"))
            gain = side * after.slope[index] * step
            if gain >= WORTH_TELLING:
                yield f"{parameter.path} is at its bound {value:g}: {word} further c² gains {100 * gain:.2g} %"

    def write(self, path: Path | str) -> None:
        """Write the cell file of the best layout, whole or not at all; comments of the study's own are not in it.

        Args:
            path: The file.

        Raises:
            InputError: If there is no such layout, or the file cannot be written.
        """
        path = as_path("path", path)
        if self.after is None:
            raise InputError(path, "there is no layout to write: none within the bounds can be played.")
        heading = f"# The layout that mrts place found of {printable(self.study.path.name)}\n"
        write_text_atomically(path, heading + self.study.cell_text(self.after.keys, path.absolute().parent))
