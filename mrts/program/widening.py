# SPDX-License-Identifier: MIT
"""By how much limits must move outward before some unknowns, or a given c², keep them all."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.programs import OPTIMAL, STOPPED
from mrts.program.motion_rows import MotionRows
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.solvers import DEFAULT_SOLVER, ConvexPrograms, require_verified, solve_programs


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

    A has Shape (N, r, k), its limits (N, r); laws are where `is_limit`, Shape (r,), is False. Unknowns are at least
    `x_lower`, Shape (k,), and s is at least `least`: below 0 limits move inward. `sizes` are l and u, Shape (r,), or 1.

    Returns:
        Least s, Shape (N,); multipliers of the rows, positive at an upper limit, Shape (N, r); and how many programs
        another solver solved.

    Raises:
        SolverError: If no solver answers; it says `what` was looked for.
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
    """Least s that admits a c², one for all samples or Shape (N, 1), Shape (N,); of one unknown, the largest excess."""
    lower, upper = problem.limits_at(c2)
    if problem.unknowns == 1:
        return np.asarray(np.max(np.maximum(lower, -upper), axis=1, initial=0.0), dtype=np.float64)
    free = np.full(problem.unknowns - 1, -np.inf)
    return least_widening(problem.free, lower, upper, problem.is_limit, free, solver, what)[0]


WHAT = "the excess between samples"
"""What is found, for messages."""


def motion_widening(
    rows: MotionRows, c2: Array, load: Array | None = None, samples: NDArray[np.intp] | None = None
) -> Array:
    """By how much all limits must move outward before a motion keeps them, in shares of each: Shape (k,).

    c² is that of each of k samples, Shape (k,), all or some; a load is one for all, Shape (10,), or Shape (k, 10).
    """
    places = np.arange(rows.motion.samples) if samples is None else samples
    if not len(places):
        return np.zeros(0)
    share, left = np.zeros(len(places)), np.arange(len(places))
    if rows.compiled:
        speed = np.sqrt(c2[:, None]) if rows.has_speed_terms else 1.0
        status, units = np.full(len(places), STOPPED, dtype=np.uint8), rows.given.units[~rows.is_cap]
        outputs = share, status
        rows.over_samples("mrts_widenings", [c2], outputs, (units,), load=load, speed=speed, samples=samples)
        share, left = np.maximum(share, _passed_caps(rows, c2, places)), (status != OPTIMAL).nonzero()[0]
    if left.size:
        carried = load if load is None or load.ndim == 1 else load[left]
        problem = build_sample_problem(rows, load=carried, samples=places[left])
        share[left] = widening_at(problem, c2[left, None], DEFAULT_SOLVER, WHAT)
    return share


def _passed_caps(rows: MotionRows, c2: Array, samples: NDArray[np.intp]) -> Array:
    """By how much rows that only bound c² are passed at some samples, in shares of each, Shape (k,)."""
    if rows.rows.square is None or not np.any(rows.is_cap):
        return np.zeros(len(samples))
    lower, upper, size = rows.rows.lower[rows.is_cap], rows.rows.upper[rows.is_cap], rows.given.units[rows.is_cap]
    value = rows.rows.square[np.ix_(samples, rows.is_cap)] * c2[:, None]
    return np.asarray(np.max(np.maximum(value - upper, lower - value) / size, axis=1, initial=0.0))
