# SPDX-License-Identifier: MIT
"""The highest interval of speeds that a sample admits where its rows have a term in ṙ beside one in ṙ².

Found by the kernel whatever solver is chosen: mrts/kernel/c/speed_intervals.c.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.programs import OPTIMAL, default_programs
from mrts.program.convex_program import scales
from mrts.program.linear_programs import NO_EFFECT
from mrts.program.sample_problem import SampleProblem


@dataclass
class SpeedIntervals:
    """The highest interval of c² of each of N samples.

    Attributes:
        lower: Its least c², infinity where there is none, Shape (N,).
        upper: Its largest, infinity where nothing bounds it, minus infinity where there is none, Shape (N,).
        gap: A c² in the gap between it and a lower interval, 0 where there is no other, Shape (N,).
        dual: Multipliers of the rows that set the lower and the upper end, Shape (2, N, r); of caps there are none.
        undecided: Samples that have no interval, or where none was found, Shape (N,).
    """

    lower: Array
    upper: Array
    gap: Array
    dual: Array
    undecided: NDArray[np.bool_]

    def put(self, samples: NDArray[np.int_], other: "SpeedIntervals", which: NDArray[np.int_]) -> None:
        """Take some samples from some of another batch."""
        for name in ("lower", "upper", "gap", "undecided"):
            getattr(self, name)[samples] = getattr(other, name)[which]
        self.dual[:, samples] = other.dual[:, which]


def highest_intervals(problem: SampleProblem, most: Array | None = None) -> SpeedIntervals:
    """The highest interval of c² that each sample admits.

    Args:
        problem: Rows with a column of ṙ.
        most: Largest c² that is asked for, Shape (N,); None for any.
    """
    assert problem.speed is not None  # noqa: S101 (as in `speed_unit`)
    rows, cap = ~problem.is_cap, problem.cap()
    cap = cap if most is None else np.minimum(cap, most)
    A, lower, upper = problem.A[:, rows], problem.lower[:, rows], problem.upper[:, rows]
    column, row = scales(A, lower == upper)
    scaled = A * column[:, None] * row[:, :, None]
    low, high, gap, of_rows, status = default_programs().speed_intervals(
        scaled, lower * row, upper * row, column, problem.speed[:, rows] * row, cap
    )
    undecided, dual = status != OPTIMAL, np.zeros((2, *problem.lower.shape))
    dual[:, :, rows] = of_rows * row
    high = np.where(speed_unit(problem) == 0, cap, high)
    low[undecided], high[undecided], gap[undecided] = np.inf, -np.inf, 0.0
    return SpeedIntervals(low, high, gap, dual, undecided)


def speed_unit(problem: SampleProblem) -> Array:
    """The c² of each sample that, with its own c, moves some row by about one limit; 0 at rest, Shape (N,)."""
    assert problem.speed is not None  # noqa: S101 (asked of rows with a column of ṙ)
    moving = ~problem.is_cap & problem.is_limit
    square = np.max(np.abs(problem.square[:, moving]), axis=1, initial=0.0)
    effect = np.maximum(square, np.max(np.abs(problem.speed[:, moving]), axis=1, initial=0.0) ** 2)
    with np.errstate(divide="ignore"):
        return np.where(effect > NO_EFFECT, 1 / effect, 0.0)
