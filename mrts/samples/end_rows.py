# SPDX-License-Identifier: MIT
"""All rows that set the ends of the range over a motion, found when they are asked for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import STANDSTILL, ActiveRow, Side
from mrts.samples.binding_rows import rows_at_end
from mrts.samples.sample_problem import build_sample_problem
from mrts.samples.sample_ranges import SampleRanges, first_least


@dataclass(frozen=True, kw_only=True)
class EndRows(Sequence[tuple[ActiveRow, ...]]):
    """Rows of one end of each of N samples; all of them, found when they are asked for, where it sets the range.

    Attributes:
        found: As the solver gives them.
        end: Which end.
        sample: Where the end over the motion is.
        c2: Its value.
        cell: The cell.
        motion: Its motion.
        load: Load vector that sets it, Shape (10,); None for the cell's.
    """

    found: Sequence[tuple[ActiveRow, ...]]
    end: Side
    sample: int
    c2: float
    cell: Cell
    motion: CoordinatedMotion
    load: Array | None

    def __len__(self) -> int:
        return len(self.found)

    def __getitem__(self, sample: Any) -> Any:
        if isinstance(sample, slice):
            return tuple(self[index] for index in range(*sample.indices(len(self))))
        index = range(len(self))[sample]
        return (self._all() if index == self.sample else ()) or self.found[index]

    def _all(self) -> tuple[ActiveRow, ...]:
        if not np.isfinite(self.c2):
            return ()
        if self.end == "lower" and self.c2 == 0:
            return (ActiveRow(STANDSTILL, "lower", 0.0),)
        loads = None if self.load is None else np.broadcast_to(self.load, (self.motion.samples, len(self.load)))
        problem = build_sample_problem(self.cell, self.motion, load=loads, samples=np.array([self.sample]))
        return rows_at_end(problem, self.c2, self.end)


def with_end_rows(
    cell: Cell, motion: CoordinatedMotion, samples: SampleRanges, load_at: Callable[[int, Side], Array | None]
) -> SampleRanges:
    """The same ranges, which name all rows that set the ends over the motion.

    Args:
        cell: The cell; the distribution of its load is free.
        motion: Its motion.
        samples: Ranges of all samples.
        load_at: Load vector of one end of a sample, Shape (10,); None for the cell's.
    """
    if len(cell.robots) == 1:
        return samples  # nothing is free: the closed form names all
    sides: tuple[tuple[Side, Array, Sequence[tuple[ActiveRow, ...]], int], ...] = (
        ("lower", samples.lower, samples.lower_rows, int(first_least(-samples.lower))),
        ("upper", samples.upper, samples.upper_rows, int(first_least(samples.upper))),
    )
    lower, upper = (
        EndRows(
            found=found,
            end=side,
            sample=place,
            c2=float(c2[place]),
            cell=cell,
            motion=motion,
            load=load_at(place, side),
        )
        for side, c2, found, place in sides
    )
    return replace(samples, lower_rows=lower, upper_rows=upper)
