# SPDX-License-Identifier: MIT
"""The rows that set an end of the range, whichever solver found it.

Where more rows meet than the unknowns need, a solver gives multipliers to some of them only, and which depends on its
basis. Named are therefore all rows that are at their limit in every solution at the end; by strict complementarity they
are those with a multiplier in some solution of the dual program.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import STANDSTILL, ActiveRow, Side
from mrts.limits.squared_rows import CAPS_TIE
from mrts.samples.linear_programs import effect_of_speed
from mrts.samples.sample_problem import SampleProblem, build_sample_problem
from mrts.samples.sample_ranges import SampleRanges, first_least
from mrts.solvers import DEFAULT_SOLVER
from mrts.solvers.convex_program import ConvexPrograms, solve_programs

WIDER = 3e-9
"""Limits are moved outward by this share of themselves, more than c² is off: at the end there may be one solution."""

NEAR = 1e-4
"""A row is at its limit if no solution keeps further away than this share of it: 1 / NEAR times `WIDER` is the least
multiplier, as a share of all, that counts."""


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


def rows_at_end(problem: SampleProblem, c2: float, end: Side) -> tuple[ActiveRow, ...]:
    """All rows at their limit in every solution at an end of a sample's range, in the order of the rows.

    A row whose limits are equal is at both whatever c² is, and none of them.

    Args:
        problem: Rows of one sample, in which the distribution of the load is free.
        c2: The end, finite.
        end: Which.
    """
    if end == "lower" and c2 * float(effect_of_speed(problem)[0]) <= WIDER:
        return (ActiveRow(STANDSTILL, "lower", 0.0),)
    moving = ~problem.is_cap
    widening = WIDER * problem.is_limit[moving]
    lower, upper = (limit[0, moving] for limit in problem.limits_at(c2))
    lower, upper = lower - widening, upper + widening
    places = np.flatnonzero(problem.is_limit & moving)
    at = np.searchsorted(np.flatnonzero(moving), places)
    sides = [
        (row, place, sign)
        for row, place in zip(at.tolist(), places.tolist(), strict=True)
        for sign, limit in ((1.0, upper[row]), (-1.0, lower[row]))
        if np.isfinite(limit) and upper[row] - lower[row] > 2 * NEAR
    ]
    distance = _largest_distance(problem.free[0, moving], lower, upper, [(row, sign) for row, _, sign in sides])
    tight = [(place, sign > 0) for (_, place, sign), far in zip(sides, distance, strict=True) if far <= NEAR]
    named = [problem.active_row(place, upper=side) for place, side in tight]
    if end == "upper":
        caps = np.flatnonzero(problem.is_cap)[problem.cap_share[0] * c2 >= 1 - CAPS_TIE]
        named += [problem.active_row(row, upper=bool(problem.square[0, row] > 0)) for row in caps.tolist()]
    return tuple(named)


def _largest_distance(A: Array, lower: Array, upper: Array, sides: list[tuple[int, float]]) -> Array:
    """How far each row can keep from one of its sides (sign 1: upper), at most 1; infinity if it was not found."""
    rows, unknowns = A.shape
    count = len(sides)
    row, sign = (np.array(values) for values in zip(*sides, strict=True)) if sides else (np.zeros(0, int), np.zeros(0))
    asked = np.zeros((count, rows + 1, unknowns + 1))
    asked[:, :-1, :-1] = A
    asked[:, -1, :-1] = sign[:, None] * A[row]
    asked[:, -1, -1] = 1.0
    g = np.zeros((count, unknowns + 1))
    g[:, -1] = -1.0
    free = np.full((count, unknowns), np.inf)
    answers = solve_programs(
        ConvexPrograms(
            H=None,
            g=g,
            A=asked,
            lower=np.column_stack([np.tile(lower, (count, 1)), np.full(count, -np.inf)]),
            upper=np.column_stack([np.tile(upper, (count, 1)), np.where(sign > 0, upper[row], -lower[row])]),
            x_lower=np.column_stack([-free, np.zeros(count)]),
            x_upper=np.column_stack([free, np.ones(count)]),
        ),
        DEFAULT_SOLVER,
    )
    return np.where(answers.verified, answers.x[:, -1], np.inf)
