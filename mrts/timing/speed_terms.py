# SPDX-License-Identifier: MIT
"""Terms in ṡ = √x, of viscous friction and torque-speed curves, put in terms that are linear in x = ṡ²."""

from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.program.sample_problem import SampleProblem

Ends = tuple[float | None, float | None]
"""x at the first and the last sample of a path, None where it is not given."""


@dataclass(frozen=True)
class RootLines:
    """A line start + slope x beside √x at every sample.

    Attributes:
        start: Shape (N,).
        slope: Shape (N,).
    """

    start: Array
    slope: Array

    def pinned(self, ends: Ends) -> "RootLines":
        """The same lines; at the first and the last sample, where x is given, √x itself.

        Args:
            ends: x at the first and the last sample; None where it is not given.
        """
        start, slope = self.start.copy(), self.slope.copy()
        for place, x in ((0, ends[0]), (-1, ends[1])):
            if x is not None:
                start[place], slope[place] = np.sqrt(x), 0.0
        return RootLines(start, slope)


def tangents(at: Array) -> RootLines:
    """Lines that touch √x and lie above it.

    Args:
        at: Where, > 0, Shape (N,).
    """
    root = np.sqrt(at)
    return RootLines(root / 2, 0.5 / root)


def chords(least: Array, most: Array) -> RootLines:
    """Lines below √x between two of its points.

    Args:
        least: The lesser x, >= 0, Shape (N,).
        most: The larger, > 0, Shape (N,).
    """
    low, high = np.sqrt(least), np.sqrt(most)
    return RootLines(low * high / (low + high), 1 / (low + high))


def without_root(problem: SampleProblem, pressing: RootLines, helping: RootLines) -> SampleProblem:
    """Rows that are linear in x in place of rows with terms in √x.

    Each row with such a term becomes two, one a side. Where the term presses towards that side one line is put in the
    place of √x, where it helps the other. With lines above √x for what presses and below it for what helps the rows are
    stricter than the given ones; the other way round, weaker.

    Args:
        problem: Rows of [F, u, x] and √x, from `build_sample_problem` with a varying speed.
        pressing: For terms that press towards a limit.
        helping: For terms that help to keep it.
    """
    root = problem.speed
    if root is None:
        return problem
    both = np.any(root, axis=0)
    plain, split = np.flatnonzero(~both), np.flatnonzero(both)
    order = np.concatenate([plain, split, split])
    A, lower, upper = problem.A[:, order], problem.lower[:, order], problem.upper[:, order]
    above, below = np.split(np.arange(len(plain), len(order)), 2)
    lower[:, above], upper[:, below] = -np.inf, np.inf
    for rows, sign, limit in ((above, 1.0, upper), (below, -1.0, lower)):
        term = root[:, split]
        presses = sign * term > 0
        A[:, rows, -1] += term * np.where(presses, pressing.slope[:, None], helping.slope[:, None])
        limit[:, rows] -= term * np.where(presses, pressing.start[:, None], helping.start[:, None])
    return replace(
        problem,
        names=tuple(problem.names[row] for row in order.tolist()),
        A=A,
        lower=lower,
        upper=upper,
        speed=None,
        torque_speed=None,
        **{
            name: getattr(problem, name)[order] for name in ("unit", "is_limit", "is_cap", "limit_lower", "limit_upper")
        },
    )
