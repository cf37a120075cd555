# SPDX-License-Identifier: MIT
"""Least and largest c² of samples, by the kernel, by linear programs or by intervals of speeds, and what sets them.

Where more rows meet at an end than the unknowns need, a solver gives multipliers to some of them only, and which
depends on its basis. `rows_at_end` names all that are at their limit in every solution there; by strict complementarity
they are those with a multiplier in some solution of the dual program.
"""

from collections.abc import Callable
from dataclasses import dataclass

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

Duals = NDArray[np.float32]
"""Multipliers of r rows and of c² >= 0 at the lower and the upper ends of N samples, Shape (2, N, r + 1): positive at a
row's upper limit, negative at its lower one, 0 where it does not bind. Those of one end are compared, no more."""


@dataclass
class RangeEnds:
    """Least and largest c² of N samples: of the highest interval where a sample admits several.

    Attributes:
        lower: Infinity where there is none, Shape (N,).
        upper: Infinity where nothing bounds it, minus infinity where there is none, Shape (N,).
        duals: What binds.
        status: Status of the kernel, Shape (N,): `OPTIMAL` where the ends are known.
        below: A c² between the interval and the next one below, 0 where there is none, Shape (N,). Of an interval that
            is not the highest one it is that of the highest.
        effect: Largest effect of c² = 1 on a row in its unit, Shape (N,).
    """

    lower: Array
    upper: Array
    duals: Duals
    status: NDArray[np.uint8]
    below: Array
    effect: Array

    @classmethod
    def unknown(cls, samples: int, rows: int) -> "RangeEnds":
        """Nothing of any sample."""
        none = np.full(samples, np.inf)
        status = np.full(samples, STOPPED, dtype=np.uint8)
        return cls(none, -none, np.zeros((2, samples, rows + 1), np.float32), status, *np.zeros((2, samples)))

    @property
    def undecided(self) -> NDArray[np.intp]:
        """Samples whose ends are not known."""
        return np.flatnonzero(self.status != OPTIMAL)

    def replace(self, samples: NDArray[np.intp], other: "RangeEnds") -> None:
        """Take some samples from another batch."""
        self.duals[:, samples] = other.duals
        for name in ("lower", "upper", "status", "below", "effect"):
            getattr(self, name)[samples] = getattr(other, name)


def kernel_ends(rows: MotionRows, load: Array | None, most: Array) -> RangeEnds:
    """The ends at all samples in one call of the kernel, c² at most `most`, Shape (N,)."""
    found = np.zeros(len(most), dtype=range_record(rows.cell.library.unknowns))
    name = "mrts_speed_ranges" if rows.has_speed_terms else "mrts_ranges"
    rows.over_samples(name, [np.minimum(most, INFINITY)], [found], load=load)
    basis, dual = (found[of].swapaxes(0, 1) for of in ("basis", "dual"))
    (lower, upper), duals = found["end"].T, _duals_of_bases(rows, basis, dual)
    return RangeEnds(lower, upper, duals, found["status"].max(axis=1), found["gap"], found["effect"])


def _duals_of_bases(rows: MotionRows, basis: NDArray[np.int16], dual: NDArray[np.float32]) -> Duals:
    """Multipliers of the kernel's bases and theirs, Shape (2, N, k) each.

    It has the r rows that are no caps; row r + k - 1 of a basis is c² >= 0 at its lower side, a cap at its upper one.
    """
    count, kept, size = len(rows.given.names), (~rows.is_cap).nonzero()[0], np.abs(dual)
    most = len(kept) + rows.cell.library.unknowns + 1
    place_of = np.full(2 * most + 1, count + 1)  # by codes, negative ones from the end on
    end = len(place_of) - len(kept)
    place_of[1 : len(kept) + 1], place_of[most + 1 : end], place_of[end:] = kept, count, kept[::-1]
    strong = size > BINDING_TOLERANCE * size.max(axis=2, initial=0.0, keepdims=True)
    duals = np.zeros((2, len(rows.most), count + 2), dtype=np.float32)
    np.put_along_axis(duals, np.where(strong, place_of[basis], count + 1), np.copysign(size, basis), axis=2)
    return duals[:, :, :-1]


def binding_duals(dual: Array, standstill: NDArray[np.bool_]) -> Duals:
    """Multipliers of rows, Shape (2, N, r), without rounding, and where c² >= 0 binds at the lower end, Shape (N,)."""
    size = np.abs(dual)
    strong = np.where(size > BINDING_TOLERANCE * np.max(size, axis=2, initial=0.0, keepdims=True), dual, 0.0)
    still = np.stack([np.where(standstill, -np.inf, 0.0), np.zeros(len(standstill))])
    return np.concatenate([strong, still[:, :, None]], axis=2).astype(np.float32)


def with_caps(ends: RangeEnds, is_cap: NDArray[np.bool_], cap_share: Array, square: Array | None) -> RangeEnds:
    """The same ends with the caps that bind at the upper ones; `square` is that of all rows, Shape (N, r), if any."""
    if square is None:
        return ends
    at_cap = np.isfinite(ends.upper) & (ends.upper >= (1 - BINDING_TOLERANCE) * largest_square(cap_share))
    sample, cap = (at_cap[:, None] & binds(cap_share)).nonzero()
    row = is_cap.nonzero()[0][cap]
    ends.duals[1, sample, row] = np.copysign(np.inf, square[sample, row])
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
    dual = np.zeros((2, *problem.lower.shape))
    dual[:, :, ~caps] = least.dual[:, :-unknowns], largest.dual[:, :-unknowns]
    dual[1, free] = 0.0
    still = np.abs(least.dual[:, -1])
    weight = np.maximum(np.max(np.abs(dual[0]), axis=1, initial=0.0), still)
    dual[0, np.abs(dual[0]) <= BINDING_TOLERANCE * weight[:, None]] = 0.0
    return RangeEnds(
        lower=np.maximum(least.x[:, -1], 0.0) * unit,
        upper=np.where(free, np.inf, largest.x[:, -1] * unit),
        duals=binding_duals(dual, still > BINDING_TOLERANCE * weight),
        status=np.where(least.verified & largest.verified, OPTIMAL, MARGINAL).astype(np.uint8),
        below=np.zeros(count),
        effect=effect,
    )


SCALES = (1.0, 3.0, 0.3, 10.0, 0.1)
"""Scales of the unknowns beside c, tried in turn: the kernel may decide a degenerate program in one of them only."""

MOST_INTERVALS = 100
"""Intervals of one sample that are looked for, at most."""


def intervals_below(find: Callable[[Array], RangeEnds], most: Array, high: float) -> RangeEnds:
    """The highest interval of c² of each sample whose lower end is at most `high`, or the lowest where all lie above.

    `find` gives the highest one of each sample up to a c² of its own, Shape (N,), first up to `most`.
    """
    found, lowest = find(most), np.zeros(len(most), dtype=bool)
    highest = found.below
    for _ in range(MOST_INTERVALS):
        above = (found.below > 0) & (found.lower > high) & ~lowest
        if not np.any(above):
            break
        tried = np.where(above, found.below, most)
        further = find(tried)
        nothing = above & (further.status == INFEASIBLE)
        lowest |= nothing
        if not np.any(nothing):
            most, found = tried, further
    found.below = highest
    return found


def highest_intervals(problem: SampleProblem, most: Array) -> RangeEnds:
    """Eqs. (38), (39): the highest interval of c² up to `most`, Shape (N,), that each sample admits.

    The equations are left where c² is the only unknown: every row bounds it by itself. `duals` leave out caps.
    """
    rows, cap = ~problem.is_cap, np.minimum(problem.cap(), most)
    A, lower, upper = problem.A[:, rows], problem.lower[:, rows], problem.upper[:, rows]
    column, row = scales(A, lower == upper)
    A, speed = A * row[:, :, None], 0.0 * row if problem.speed is None else problem.speed[:, rows] * row
    count = problem.samples
    (low, high, below), of_rows = np.zeros((3, count)), np.zeros((2, *lower.shape))
    status = np.full(count, MARGINAL, dtype=np.uint8)
    for scale in SCALES:
        left = np.flatnonzero(status >= MARGINAL)
        if not left.size:
            break
        size = column[left]
        size[:, :-1] *= scale
        low[left], high[left], below[left], of_rows[:, left], status[left] = speed_intervals(
            A[left] * size[:, None], (lower * row)[left], (upper * row)[left], size, speed[left], cap[left]
        )
    nothing, dual, effect = status != OPTIMAL, np.zeros((2, *problem.lower.shape)), problem.effect(caps=False)
    dual[:, :, rows] = of_rows * row
    high = np.where(effect == 0, cap, high)
    low[nothing], high[nothing], below[nothing] = np.inf, -np.inf, 0.0
    return RangeEnds(low, high, binding_duals(dual, low == 0), status, below, effect)


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
