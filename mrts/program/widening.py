# SPDX-License-Identifier: MIT
"""By how much limits must move outward before some unknowns, or a given c², keep them all."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.program.convex_program import ConvexPrograms
from mrts.program.sample_problem import SampleProblem
from mrts.program.solvers import require_verified, solve_programs


def least_widening(
    A: Array,
    lower: Array,
    upper: Array,
    is_limit: NDArray[np.bool_],
    x_lower: Array,
    solver: str,
    what: str,
    *,
    sizes: tuple[Array, Array] | None = None,
    least: float = 0.0,
) -> tuple[Array, Array, int]:
    """Solve min s, lower - s l <= A x <= upper + s u for limits, lower <= A x <= upper for laws; it has a solution.

    Args:
        A: Shape (N, r, k).
        lower: Shape (N, r).
        upper: Shape (N, r).
        is_limit: False for laws, which do not move, Shape (r,).
        x_lower: Lower bounds of the unknowns, Shape (k,).
        solver: Name in the registry.
        what: What is found, for the message.
        sizes: l and u, how far s = 1 moves each side, each Shape (r,); None is 1.
        least: Least s: below 0 limits move inward.

    Returns:
        Least s, in sizes of limits, Shape (N,); multipliers of the rows, positive at an upper limit, Shape (N, r); and
        how many programs another solver solved.

    Raises:
        SolverError: If no solver answers.
    """
    count, rows, unknowns = A.shape
    below, above = (np.ones(rows), np.ones(rows)) if sizes is None else sizes
    limits, laws = np.flatnonzero(is_limit), np.flatnonzero(~is_limit)
    # each limit twice, once a side, as s moves them in opposite senses; laws once, as they are
    order = np.concatenate([limits, limits, laws])
    sense = np.repeat([-1.0, 1.0, 0.0], [len(limits), len(limits), len(laws)])
    moved = sense * np.concatenate([above[limits], below[limits], np.ones(len(laws))])
    moved = np.broadcast_to(moved[:, None], (count, len(order), 1))
    g = np.zeros((count, unknowns + 1))
    g[:, -1] = 1
    bounds = np.tile(np.append(x_lower, least), (count, 1))
    programs = ConvexPrograms(
        H=None,
        g=g,
        A=np.concatenate([A[:, order], moved], axis=2),
        lower=np.where(sense < 0, -np.inf, lower[:, order]),
        upper=np.where(sense > 0, np.inf, upper[:, order]),
        x_lower=bounds,
        x_upper=np.full_like(bounds, np.inf),
    )
    answers = solve_programs(programs, solver)
    require_verified(answers, what)
    row_dual = np.zeros((count, rows))
    for column, row in enumerate(order):
        row_dual[:, row] += answers.row_dual[:, column]
    return answers.x[:, -1], row_dual, answers.fallbacks


def widening_at(problem: SampleProblem, c2: float | Array, solver: str, what: str) -> Array:
    """Least s that admits a given c², Shape (N,); where c² is the only unknown, the largest excess.

    Args:
        problem: Rows of some samples.
        c2: c², one for all samples, or one a sample, Shape (N, 1).
        solver: Name in the registry.
        what: What is found, for the message.

    Raises:
        SolverError: If no solver answers.
    """
    lower, upper = problem.limits_at(c2)
    if problem.unknowns == 1:
        return np.asarray(np.max(np.maximum(lower, -upper), axis=1, initial=0.0), dtype=np.float64)
    free = np.full(problem.unknowns - 1, -np.inf)
    return least_widening(problem.free, lower, upper, problem.is_limit, free, solver, what)[0]
