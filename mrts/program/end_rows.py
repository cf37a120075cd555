# SPDX-License-Identifier: MIT
"""The rows that set an end of the range, whichever solver found it.

Where more rows meet than the unknowns need, a solver gives multipliers to some of them only, and which depends on its
basis. Named are therefore all rows that are at their limit in every solution at the end; by strict complementarity they
are those with a multiplier in some solution of the dual program.
"""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.limits.rows import STANDSTILL, ActiveRow, Side
from mrts.program.closed_form import tied_codes
from mrts.program.convex_program import ConvexPrograms
from mrts.program.linear_programs import effect_of_speed
from mrts.program.motion_rows import CAPS_TIE
from mrts.program.range_ends import BINDING_TOLERANCE
from mrts.program.sample_problem import SampleProblem
from mrts.program.solvers import DEFAULT_SOLVER, solve_programs

WIDER = 3e-9
"""Limits are moved outward by this share of themselves, more than c² is off: at the end there may be one solution."""

NEAR = 1e-4
"""A row is at its limit if no solution keeps further away than this share of it: 1 / NEAR times `WIDER` is the least
multiplier, as a share of all, that counts."""


ASKED_AT_ONCE = 24
"""Sides of rows up to which a program is solved for each; of more, one solution shows first which are far away."""


def rows_at_end(problem: SampleProblem, c2: float, end: Side) -> tuple[ActiveRow, ...]:
    """All rows at their limit in every solution at an end of a sample's range, in the order of the rows.

    A row whose limits are equal is at both whatever c² is, and none of them.

    Args:
        problem: Rows of one sample.
        c2: The end, finite.
        end: Which.
    """
    if end == "lower" and c2 * float(effect_of_speed(problem)[0]) <= WIDER:
        return (ActiveRow(STANDSTILL, "lower", 0.0),)
    moving = np.flatnonzero(~problem.is_cap)
    is_limit = problem.is_limit[moving]
    widening = WIDER * is_limit
    lower, upper = (limit[0, moving] for limit in problem.limits_at(c2))
    lower, upper = lower - widening, upper + widening
    apart = is_limit & (upper - lower > 2 * NEAR)
    rows, lows = np.nonzero(np.column_stack([apart & np.isfinite(upper), apart & np.isfinite(lower)]))
    distance = _largest_distance(problem.free[0, moving], lower, upper, rows, np.where(lows, -1.0, 1.0))
    tight = np.flatnonzero(distance <= NEAR)
    named = [
        problem.active_row(place, upper=not low)
        for place, low in zip(moving[rows[tight]].tolist(), lows[tight].tolist(), strict=True)
    ]
    if end == "upper":
        caps = np.flatnonzero(problem.is_cap)[problem.cap_share[0] * c2 >= 1 - CAPS_TIE]
        named += [problem.active_row(row, upper=bool(problem.square[0, row] > 0)) for row in caps.tolist()]
    return tuple(named)


def tight_codes(problem: SampleProblem, lower: Array, upper: Array) -> NDArray[np.int32]:
    """Codes of `BindingRows` where c² is the only unknown: of all rows at a limit at the ends.

    Args:
        problem: Rows.
        lower: c²⁻(t), Shape (N,).
        upper: c²⁺(t), Shape (N,); there are no rows where an end is not finite.
    """
    apart = problem.is_limit & (problem.upper - problem.lower > 2 * NEAR)
    sides = np.zeros((2, *apart.shape), dtype=np.int8)
    for end, c2 in enumerate((lower, upper)):
        there = np.isfinite(c2)[:, None]
        least, most = problem.limits_at(np.where(there, c2[:, None], 0.0))
        sides[end] = np.where(most <= BINDING_TOLERANCE, 1, np.where(least >= -BINDING_TOLERANCE, -1, 0))
        sides[end] *= there & apart & ~problem.is_cap
        if end == 1:
            caps = there & (problem.cap_share * np.where(there, c2[:, None], 0.0) >= 1 - CAPS_TIE)
            sides[end][:, problem.is_cap] = np.where(caps, np.sign(problem.square[:, problem.is_cap]), 0)
    known = np.isfinite(lower)
    still = known & (np.where(known, lower, 0.0) * effect_of_speed(problem) <= WIDER)
    return tied_codes(sides, np.where(still, 0.0, lower))


def _largest_distance(A: Array, lower: Array, upper: Array, row: NDArray[np.int_], sign: Array) -> Array:
    """How far some rows can keep from one of their sides (sign 1: upper), at most 1; infinity if it was not found.

    Of those that keep further away than `NEAR` in one solution, it is how far they do there.
    """
    asked, distance = np.arange(len(row)), np.full(len(row), np.inf)
    if len(row) > ASKED_AT_ONCE:
        x, _, verified = _away_from(A, lower, upper, row[None], sign[None])
        if verified[0]:
            value: Array = A[row] @ x[0]
            distance = np.where(sign > 0, upper[row] - value, value - lower[row])
            asked = np.flatnonzero(distance <= NEAR)
    if asked.size:
        _, furthest, verified = _away_from(A, lower, upper, row[asked, None], sign[asked, None])
        distance[asked] = np.where(verified, furthest, np.inf)
    return distance


def _away_from(
    A: Array, lower: Array, upper: Array, row: NDArray[np.int_], sign: Array
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Unknowns that keep as far as they can from all sides of a program at once, at most 1, and whether it was solved.

    Args:
        A: Shape (r, k).
        lower: Shape (r,).
        upper: Shape (r,).
        row: Of each program, Shape (p, s).
        sign: Likewise, 1 of upper sides.

    Returns:
        Unknowns, Shape (p, k), distances, Shape (p,), and Shape (p,).
    """
    (rows, unknowns), (count, sides) = A.shape, row.shape
    asked = np.zeros((count, rows + sides, unknowns + 1))
    asked[:, :rows, :-1] = A
    asked[:, rows:, :-1] = sign[:, :, None] * A[row]
    asked[:, rows:, -1] = 1.0
    g = np.zeros((count, unknowns + 1))
    g[:, -1] = -1.0
    free = np.full((count, unknowns), np.inf)
    answers = solve_programs(
        ConvexPrograms(
            H=None,
            g=g,
            A=asked,
            lower=np.column_stack([np.tile(lower, (count, 1)), np.full((count, sides), -np.inf)]),
            upper=np.column_stack([np.tile(upper, (count, 1)), np.where(sign > 0, upper[row], -lower[row])]),
            x_lower=np.column_stack([-free, np.zeros(count)]),
            x_upper=np.column_stack([free, np.ones(count)]),
        ),
        DEFAULT_SOLVER,
    )
    return answers.x[:, :-1], answers.x[:, -1], answers.verified
