# SPDX-License-Identifier: MIT
"""Least and largest c² of samples, by the kernel, by linear programs or by intervals of speeds, and what sets them.

Where more rows meet at an end than the unknowns need, a solver gives multipliers to some of them only, and which
depends on its basis. `rows_at_end` names all that are at their limit in every solution there; by strict complementarity
they are those with a multiplier in some solution of the dual program.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.binding import INFINITY
from mrts.kernel.cell_library import range_record
from mrts.kernel.programs import INFEASIBLE, MARGINAL, OPTIMAL, STOPPED, speed_intervals
from mrts.limits.rows import STANDSTILL, ActiveRow, Side
from mrts.program.motion_rows import CAPS_TIE, MotionRows, binds, largest_square
from mrts.program.sample_problem import SampleProblem
from mrts.program.solvers import DEFAULT_SOLVER, Answers, ConvexPrograms, scales, solve_programs

BINDING_TOLERANCE = 1e-7
"""A row binds if its multiplier exceeds this share of the largest."""


RangeEnds = NDArray[np.void]
"""Least and largest c² of N samples, Shape (N,): of the highest interval where a sample admits several. Fields:

lower: Infinity where there is none.
upper: Infinity where nothing bounds it, minus infinity where there is none.
duals: Multipliers of r rows and of c² >= 0 at both ends, Shape (2, r + 1): positive at a row's upper limit, negative at
    its lower one, 0 where it does not bind. Those of one end are compared, no more.
status: Status of the kernel: `OPTIMAL` where the ends are known.
below: A c² between the interval and the next one below, 0 where there is none. Of an interval that is not the highest
    one it is that of the highest.
effect: Largest effect of c² = 1 on a row in its unit, where the kernel found the ends.
"""


def unknown_ends(samples: int, rows: int) -> RangeEnds:
    """Nothing of any sample."""
    numbers = [(name, np.float64) for name in ("lower", "upper", "below", "effect")]
    fields = [*numbers, ("status", np.uint8), ("duals", np.float32, (2, rows + 1))]
    ends = np.zeros(samples, dtype=np.dtype(fields, align=True))
    ends["lower"], ends["upper"], ends["status"] = np.inf, -np.inf, STOPPED
    return ends


def kernel_ends(rows: MotionRows, load: Array | None, most: Array) -> RangeEnds:
    """The ends at all samples in one call of the kernel, c² at most `most`, Shape (N,)."""
    found = np.zeros(len(most), dtype=range_record(rows.cell.library.unknowns))
    name = "mrts_speed_ranges" if rows.has_speed_terms else "mrts_ranges"
    rows.over_samples(name, [np.minimum(most, INFINITY)], [found], load=load)
    count, kept = len(rows.given.names), (~rows.is_cap).nonzero()[0]
    ends, basis, dual = unknown_ends(len(most), count), found["basis"], found["dual"]
    (ends["lower"], ends["upper"]), ends["below"], ends["effect"] = found["end"].T, found["gap"], found["effect"]
    ends["status"] = found["status"].max(axis=1)
    # unknowns come after the rows that are no caps: of c² its lower side is standstill, its upper one a cap
    row = np.append(kept, np.full(rows.cell.library.unknowns + 1, count))[np.abs(basis) - 1]
    binding = _binding(dual) & ((row < count) | (basis < 0))
    sample, end, _ = binding.nonzero()
    ends["duals"][sample, end, row[binding]] = np.copysign(dual, basis)[binding]
    return ends


def _binding(dual: NDArray[np.floating[Any]]) -> NDArray[np.bool_]:
    """Which of some multipliers at an end, Shape (…, k), are no rounding."""
    size = np.abs(dual)
    return np.asarray(size > BINDING_TOLERANCE * size.max(axis=-1, initial=0.0, keepdims=True))


def with_caps(ends: RangeEnds, is_cap: NDArray[np.bool_], cap_share: Array, square: Array | None) -> RangeEnds:
    """The same ends with the caps that bind at the upper ones; `square` is that of all rows, Shape (N, r), if any."""
    if square is None:
        return ends
    upper = ends["upper"]
    at_cap = np.isfinite(upper) & (upper >= (1 - BINDING_TOLERANCE) * largest_square(cap_share))
    sample, cap = (at_cap[:, None] & binds(cap_share)).nonzero()
    row = is_cap.nonzero()[0][cap]
    ends["duals"][sample, 1, row] = np.copysign(np.inf, square[sample, row])
    return ends


UNBOUNDED = 1e9
"""Effect of the speed on some row, as a multiple of its limit, beyond which a range has no upper end."""

AT_UNBOUNDED = 1e-9
"""Rounding of an answer at that bound."""


def ends_of_problem(problem: SampleProblem, high: float, *, alone: bool = False) -> RangeEnds:
    """The ends of the rows of some samples; as in `motion_ranges`, or by the problem's solver alone."""
    if problem.speed is None and (problem.unknowns > 1 or not alone):
        found = ends_by_linear_programs(problem, alone=alone)
    else:
        found = intervals_below(lambda most: highest_intervals(problem, most), np.full(problem.samples, np.inf), high)
    return with_caps(found, problem.is_cap, problem.cap_share, problem.square)


def ends_by_linear_programs(problem: SampleProblem, *, alone: bool = False) -> RangeEnds:
    """Eqs. (26), (29): least and largest c² >= 0 within all limits; c² is scaled to the size of the other unknowns.

    Caps go in as a bound of c²: rows of a motion near rest would spoil its scale.
    """
    count, _, unknowns = problem.A.shape
    effect = problem.effect(caps=True)
    unit = 1 / np.where(effect > 0, effect, 1.0)  # c² = unit · y, where y = 1 moves some row by a whole limit
    caps = problem.is_cap
    A, lower, upper = problem.A[:, ~caps], problem.lower[:, ~caps], problem.upper[:, ~caps]
    A[:, :, -1] *= unit[:, None]
    free = np.full((count, unknowns), np.inf)
    lower, upper = np.hstack([lower, -free]), np.hstack([upper, free])
    lower[:, -1], upper[:, -1] = 0.0, np.where(effect > 0, np.minimum(UNBOUNDED, problem.cap() / unit), 0.0)

    def solve(direction: float) -> Answers:
        g = np.zeros((count, unknowns))
        g[:, -1] = direction
        programs = ConvexPrograms(H=None, g=g, A=A, lower=lower, upper=upper)
        return solve_programs(programs, problem.solver, alone=alone)

    least, largest = solve(1.0), solve(-1.0)
    free = (largest.x[:, -1] >= UNBOUNDED * (1 - AT_UNBOUNDED)) | (effect == 0)
    ends, dual = unknown_ends(count, len(caps)), np.zeros((count, 2, len(caps) + 1))
    rows = np.append(~caps, False)
    dual[:, 0, rows], dual[:, 1, rows] = least.dual[:, :-unknowns], largest.dual[:, :-unknowns]
    dual[free, 1], dual[:, 0, -1] = 0.0, -np.abs(least.dual[:, -1])
    ends["lower"] = np.maximum(least.x[:, -1], 0.0) * unit
    ends["upper"] = np.where(free, np.inf, largest.x[:, -1] * unit)
    ends["status"] = np.where(least.verified & largest.verified, OPTIMAL, MARGINAL)
    ends["duals"] = np.where(_binding(dual), dual, 0.0)
    return ends


SCALES = (1.0, 3.0, 0.3, 10.0, 0.1)
"""Scales of the unknowns beside c, tried in turn: the kernel may decide a degenerate program in one of them only."""

MOST_INTERVALS = 100
"""Intervals of one sample that are looked for, at most."""


def intervals_below(find: Callable[[Array], RangeEnds], most: Array, high: float) -> RangeEnds:
    """The highest interval of c² of each sample whose lower end is at most `high`, or the lowest where all lie above.

    `find` gives the highest one of each sample up to a c² of its own, Shape (N,), first up to `most`.
    """
    found, lowest = find(most), np.zeros(len(most), dtype=bool)
    highest = found["below"]
    for _ in range(MOST_INTERVALS):
        above = (found["below"] > 0) & (found["lower"] > high) & ~lowest
        if not np.any(above):
            break
        tried = np.where(above, found["below"], most)
        further = find(tried)
        nothing = above & (further["status"] == INFEASIBLE)
        lowest |= nothing
        if not np.any(nothing):
            most, found = tried, further
    found["below"] = highest
    return found


def highest_intervals(problem: SampleProblem, most: Array) -> RangeEnds:
    """Eqs. (38), (39): the highest interval of c² up to `most`, Shape (N,), that each sample admits.

    The equations are left where c² is the only unknown: every row bounds it by itself. `duals` leave out caps.
    """
    rows, cap = ~problem.is_cap, np.minimum(problem.cap(), most)
    A, lower, upper = problem.A[:, rows], problem.lower[:, rows], problem.upper[:, rows]
    column, row = scales(A, lower == upper)
    A, speed = A * row[:, :, None], 0.0 * row if problem.speed is None else problem.speed[:, rows] * row
    count, ends, dual = problem.samples, unknown_ends(problem.samples, len(rows)), np.zeros((2, *lower.shape))
    (low, high, below), status = np.zeros((3, count)), np.full(count, MARGINAL, dtype=np.uint8)
    for scale in SCALES:
        left = np.flatnonzero(status >= MARGINAL)
        if not left.size:
            break
        size = column[left]
        size[:, :-1] *= scale
        low[left], high[left], below[left], dual[:, left], status[left] = speed_intervals(
            A[left] * size[:, None], (lower * row)[left], (upper * row)[left], size, speed[left], cap[left]
        )
    known, dual = status == OPTIMAL, (dual * row).swapaxes(0, 1)
    high = np.where(problem.effect(caps=False) == 0, cap, high)
    for name, values in (("lower", low), ("upper", high), ("below", below)):
        ends[name][known] = values[known]
    ends["status"], ends["duals"][:, :, :-1][:, :, rows] = status, np.where(_binding(dual), dual, 0.0)
    ends["duals"][ends["lower"] == 0, 0, -1] = -np.inf
    return ends


WIDER = 3e-9
"""Limits are moved outward by this share of themselves, more than c² is off: at the end there may be one solution."""

NEAR = 1e-4
"""A row is at its limit if no solution keeps further away than this share of it: 1 / NEAR times `WIDER` is the least
multiplier, as a share of all, that counts."""

AWAY = 0.99
"""Share of `NEAR` from which a side is away from its limit: rounding."""


def rows_at_end(problem: SampleProblem, c2: float, end: Side) -> tuple[ActiveRow, ...]:
    """All rows at their limit in every solution at an end of a sample's range, in the order of the rows.

    A linear program asks as many sides as can to be `NEAR` away at once: with t from 0 to 1 for each, the largest Σ t.
    A row whose limits are equal is at both whatever c² is, and none of them.
    """
    if end == "lower" and c2 * float(problem.effect(caps=True)[0]) <= WIDER:
        return (ActiveRow(STANDSTILL, "lower", 0.0),)
    moving = np.flatnonzero(~problem.is_cap)
    free, limits = problem.free[0, moving], np.stack(problem.limits_at(c2))[:, 0, moving]
    equal, unknowns = limits[1] - limits[0] <= 2 * NEAR, problem.unknowns - 1
    sides, rows = np.nonzero(np.isfinite(limits) & ~equal)
    sign, of_equal, of_free = np.where(sides, 1.0, -1.0), limits[:, equal], np.full(unknowns, np.inf)
    of_sides = sign * limits[sides, rows] + WIDER
    A = np.zeros((len(rows) + len(of_equal[0]), unknowns + len(rows)))
    A[:, :unknowns] = np.concatenate([sign[:, None] * free[rows], free[equal]])
    np.fill_diagonal(A[:, unknowns:], NEAR if unknowns else BINDING_TOLERANCE)
    g = np.append(np.zeros(unknowns), np.full(len(rows), -1.0))
    lower = np.concatenate([of_sides - np.inf, of_equal[0] - WIDER, -of_free, 0 * rows])
    upper = np.concatenate([of_sides, of_equal[1] + WIDER, of_free, 0 * rows + 1])
    programs = ConvexPrograms(H=None, g=g[None], A=A[None], lower=lower[None], upper=upper[None])
    answers = solve_programs(programs, DEFAULT_SOLVER)
    if not answers.verified[0]:
        return ()
    tight = sorted(
        (row, side) for row, side, t in zip(moving[rows], sides, answers.x[0, unknowns:], strict=True) if t < AWAY
    )
    named = [problem.active_row(row, upper=bool(side)) for row, side in tight]
    if end == "upper":
        caps = np.flatnonzero(problem.is_cap)[problem.cap_share[0] * c2 >= 1 - CAPS_TIE]
        named += [problem.active_row(row, upper=bool(problem.square[0, row] > 0)) for row in caps.tolist()]
    return tuple(dict.fromkeys(named))  # the sides of a norm have one name
