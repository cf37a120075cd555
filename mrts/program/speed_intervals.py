# SPDX-License-Identifier: MIT
"""The highest interval of speeds that a sample admits where its rows have a term in ṙ beside one in ṙ².

Found by the kernel whatever solver is chosen: mrts/kernel/c/speed_intervals.c.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.cell_library import KernelRanges
from mrts.kernel.programs import INFEASIBLE, MARGINAL, OPTIMAL, default_programs
from mrts.program.convex_program import scales
from mrts.program.linear_programs import NO_EFFECT
from mrts.program.sample_problem import SampleProblem

SCALES = (1.0, 3.0, 0.3, 10.0, 0.1)
"""Of the unknowns beside c: a degenerate program that the kernel does not decide in one it does in another."""

MOST_INTERVALS = 100
"""Of one sample: more are not looked for."""


@dataclass(frozen=True)
class SpeedIntervals:
    """The highest interval of c² of each of N samples.

    Attributes:
        lower: Its least c², infinity where there is none, Shape (N,).
        upper: Its largest, infinity where nothing bounds it, minus infinity where there is none, Shape (N,).
        gap: A c² in the gap between it and a lower interval, 0 where there is no other, Shape (N,).
        dual: Multipliers of the rows that set the lower and the upper end, Shape (2, N, r); of caps there are none.
        status: Of the kernel, Shape (1, N).
    """

    lower: Array
    upper: Array
    gap: Array
    dual: Array
    status: NDArray[np.uint8]


Intervals = TypeVar("Intervals", SpeedIntervals, KernelRanges)


def intervals_below(find: Callable[[Array], Intervals], most: Array, high: float) -> tuple[Intervals, bool]:
    """The highest intervals of c² that do not begin above a c², and whether some sample has others.

    Args:
        find: Highest intervals below a c² of each sample, Shape (N,).
        most: Largest c² of each sample, Shape (N,).
        high: The c².
    """
    found, lowest = find(most), np.zeros(len(most), dtype=bool)
    several = bool(np.any(np.asarray(found.gap) > 0))
    for _ in range(MOST_INTERVALS):
        gap = np.asarray(found.gap)
        above = (gap > 0) & (found.lower > high) & ~lowest
        if not np.any(above):
            break
        tried = np.where(above, gap, most)
        below = find(tried)
        nothing = above & (below.status[0] == INFEASIBLE)
        lowest |= nothing
        if not np.any(nothing):
            most, found = tried, below
    return found, several


def highest_intervals(problem: SampleProblem, most: Array) -> SpeedIntervals:
    """The highest interval of c² that each sample admits.

    Args:
        problem: Rows with a column of ṙ.
        most: Largest c² that is asked for, Shape (N,).
    """
    assert problem.speed is not None  # noqa: S101 (as in `speed_unit`)
    rows, cap = ~problem.is_cap, np.minimum(problem.cap(), most)
    A, lower, upper = problem.A[:, rows], problem.lower[:, rows], problem.upper[:, rows]
    column, row = scales(A, lower == upper)
    A, speed = A * row[:, :, None], problem.speed[:, rows] * row
    count, programs = problem.samples, default_programs()
    (low, high, gap), of_rows = np.zeros((3, count)), np.zeros((2, *lower.shape))
    status = np.full(count, MARGINAL, dtype=np.uint8)
    for scale in SCALES:
        left = np.flatnonzero(status >= MARGINAL)
        if not left.size:
            break
        size = column[left]
        size[:, :-1] *= scale
        low[left], high[left], gap[left], of_rows[:, left], status[left] = programs.speed_intervals(
            A[left] * size[:, None], (lower * row)[left], (upper * row)[left], size, speed[left], cap[left]
        )
    nothing, dual = status != OPTIMAL, np.zeros((2, *problem.lower.shape))
    dual[:, :, rows] = of_rows * row
    high = np.where(speed_unit(problem) == 0, cap, high)
    low[nothing], high[nothing], gap[nothing] = np.inf, -np.inf, 0.0
    return SpeedIntervals(low, high, gap, dual, status[None])


def speed_unit(problem: SampleProblem) -> Array:
    """The c² of each sample that, with its own c, moves some row by about one limit; 0 at rest, Shape (N,)."""
    assert problem.speed is not None  # noqa: S101 (asked of rows with a column of ṙ)
    moving = ~problem.is_cap & problem.is_limit
    square = np.max(np.abs(problem.square[:, moving]), axis=1, initial=0.0)
    effect = np.maximum(square, np.max(np.abs(problem.speed[:, moving]), axis=1, initial=0.0) ** 2)
    with np.errstate(divide="ignore"):
        return np.where(effect > NO_EFFECT, 1 / effect, 0.0)
