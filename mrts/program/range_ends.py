# SPDX-License-Identifier: MIT
"""Least and largest c² of samples, in closed form, by linear programs or by intervals of speeds, and what sets them.

Where more rows meet at an end than the unknowns need, a solver gives multipliers to some of them only, and which
depends on its basis. `rows_at_end` names all that are at their limit in every solution there; by strict complementarity
they are those with a multiplier in some solution of the dual program.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.cell_library import KernelRanges
from mrts.kernel.programs import INFEASIBLE, MARGINAL, OPTIMAL, default_programs
from mrts.limits.rows import STANDSTILL, ActiveRow, RowName, Side
from mrts.program.convex_program import ConvexPrograms, scales
from mrts.program.motion_rows import CAPS_TIE, MotionRows, binds
from mrts.program.sample_problem import SampleProblem
from mrts.program.solvers import DEFAULT_SOLVER, Answers, solve_programs

BINDING_TOLERANCE = 1e-7
"""A row binds if its multiplier exceeds this share of the largest, or, in closed form, its c² ties this closely."""


@dataclass(frozen=True)
class BindingRows:
    """Which of r rows bind at both ends of N samples.

    Attributes:
        names: One a row.
        limits: Their lower and upper limits as given, Shape (2, r).
        codes: At the lower and the upper ends, strongest first, Shape (2, N, k): 1 + row at its upper limit, -1 - row
            at its lower one, -1 - r for c² >= 0, 0 for none.
    """

    names: tuple[RowName, ...]
    limits: Array
    codes: NDArray[np.int32]

    def at(self, sample: int, side: Side) -> tuple[ActiveRow, ...]:
        """The rows at one end of a sample."""
        codes = self.codes[0 if side == "lower" else 1, sample]
        return tuple(self._row(code) for code in codes[codes != 0].tolist())

    def _row(self, code: int) -> ActiveRow:
        row = abs(code) - 1
        if row == len(self.names):
            return ActiveRow(STANDSTILL, "lower", 0.0)
        limit = float(self.limits[0 if code < 0 else 1, row])
        return ActiveRow(self.names[row], "lower" if code < 0 else "upper", limit)

    def with_samples(
        self, samples: NDArray[np.int_], found: NDArray[np.int32], ends: slice = slice(None)
    ) -> "BindingRows":
        """The same with other codes at some samples.

        Args:
            samples: Indices, n of them.
            found: Their codes, Shape (2, n, k).
            ends: Which ends change.
        """
        codes = _wide(self.codes, found.shape[2])
        codes[ends, samples] = _wide(found, codes.shape[2])[ends]
        return BindingRows(self.names, self.limits, codes)


def chosen_rows(sources: list[BindingRows], choice: NDArray[np.int_]) -> BindingRows:
    """The rows of each end from one of several sources of the same rows.

    Args:
        sources: S of them.
        choice: Which counts at the lower and the upper ends, Shape (2, N).
    """
    wide = max(source.codes.shape[2] for source in sources)
    codes = np.stack([_wide(source.codes, wide) for source in sources])
    side, sample = np.indices(choice.shape)
    return BindingRows(sources[0].names, sources[0].limits, codes[choice, side, sample])


def _wide(codes: NDArray[np.int32], size: int) -> NDArray[np.int32]:
    """Codes with zeros behind them, so that there are at least so many."""
    more = max(size - codes.shape[2], 0)
    return np.concatenate([codes, np.zeros((*codes.shape[:2], more), dtype=np.int32)], axis=2)


def no_codes(samples: int) -> NDArray[np.int32]:
    """Codes of samples where no row binds."""
    return np.zeros((2, samples, 0), dtype=np.int32)


def rows_of_problem(problem: SampleProblem, codes: NDArray[np.int32]) -> BindingRows:
    """Codes with the names of a problem's rows."""
    return BindingRows(problem.names, np.stack([problem.limit_lower, problem.limit_upper]), codes)


def kernel_rows(form: MotionRows, basis: NDArray[np.int16], dual: NDArray[np.float32]) -> BindingRows:
    """The rows of the kernel's bases.

    Args:
        form: The rows of a motion, of which the kernel has the r that are no caps; row r + k - 1 of a basis is c² >= 0
            at its lower side, a cap at its upper one.
        basis: As the kernel gives them, Shape (2, N, k).
        dual: Their multipliers, likewise.
    """
    given, kept = form.given, np.flatnonzero(~form.is_cap)
    size = np.abs(dual)
    order = np.argsort(-size, axis=2, kind="stable")
    sides, size = np.take_along_axis(basis, order, axis=2).astype(np.int32), np.take_along_axis(size, order, axis=2)
    strong = (size > BINDING_TOLERANCE * size[:, :, :1]) & (sides != 0)
    row, of_c2 = np.abs(sides) - 1, np.abs(sides) > len(kept)
    alike = np.append(given.alike_speeds, False)
    place = np.append(kept, len(given.names))[np.where(of_c2 | (sides == 0), len(kept), row)]
    code = np.where((sides > 0) | alike[place], 1 + place, -1 - place)
    code[of_c2 & (sides > 0)] = 0
    capped = np.any(strong & of_c2 & (sides > 0), axis=2)
    of_caps = np.where(capped[:, :, None] & binds(form.cap_share), form.cap_code, 0)
    codes = np.concatenate([of_caps, np.where(strong, code, 0)], axis=2).astype(np.int32)
    return BindingRows(given.names, np.stack([given.lower, given.upper]), codes)


@dataclass
class RangeEnds:
    """Least and largest c² of a batch, the rows that bind there, and where neither was found.

    Attributes:
        lower: Shape (N,).
        upper: Shape (N,).
        rows: At both ends.
        undecided: Shape (N,).
        fallbacks: Programs that the chosen solver did not solve and another did.
        several: Whether some sample admits other intervals of c² as well: these are the highest.
    """

    lower: Array
    upper: Array
    rows: BindingRows
    undecided: NDArray[np.bool_]
    fallbacks: int = 0
    several: bool = False

    def replace(self, samples: NDArray[np.int_], other: "RangeEnds") -> None:
        """Take some samples from another batch."""
        self.lower[samples], self.upper[samples] = other.lower, other.upper
        self.rows = self.rows.with_samples(samples, other.rows.codes)
        self.undecided[samples] = other.undecided
        self.fallbacks += other.fallbacks
        self.several |= other.several


def codes_of_duals(dual: Array, standstill: NDArray[np.bool_] | None = None) -> NDArray[np.int32]:
    """Codes of the rows with a multiplier, strongest first.

    Args:
        dual: Multipliers of one end, Shape (N, r).
        standstill: Where c² >= 0 binds too, Shape (N,).
    """
    size = np.abs(dual)
    order = np.argsort(-size, axis=1, kind="stable")
    strong = size > BINDING_TOLERANCE * np.max(size, axis=1, initial=0.0, keepdims=True)
    codes = np.where(strong, np.where(dual > 0, 1, -1) * np.arange(1, dual.shape[1] + 1), 0)
    first = np.zeros((len(dual), 1)) if standstill is None else np.where(standstill, -1 - dual.shape[1], 0)[:, None]
    return np.concatenate([first, np.take_along_axis(codes, order, axis=1)], axis=1).astype(np.int32)


def ends_in_closed_form(problem: SampleProblem) -> RangeEnds:
    """Eqs. (38), (39): every row bounds c², the only unknown, by itself; `intersect` adds the intersection over t."""
    slope = problem.square
    least_by_upper, most_by_upper = _below_zero(slope, -problem.upper)
    least_by_lower, most_by_lower = _below_zero(-slope, problem.lower)
    least, most = np.maximum(least_by_upper, least_by_lower), np.minimum(most_by_upper, most_by_lower)
    lower, upper = np.max(least, axis=1, initial=0.0), np.min(most, axis=1, initial=np.inf)
    sides = [
        tied_sides(least, lower, least_by_upper >= least_by_lower),
        tied_sides(most, upper, most_by_upper <= most_by_lower),
    ]
    rows = rows_of_problem(problem, tied_codes(np.stack(sides), lower))
    return RangeEnds(lower, upper, rows, lower > upper)


def tied_codes(sides: NDArray[np.int8], lower: Array) -> NDArray[np.int32]:
    """Codes of `BindingRows`: of rows that tie, or of c² >= 0 alone where a sample may stand still.

    Args:
        sides: As from `tied_sides`, of both ends, Shape (2, N, r).
        lower: c²⁻(t), Shape (N,).
    """
    still = lower == 0
    sides[0, still] = 0
    first = np.zeros((*sides.shape[:2], 1), dtype=np.int32)
    first[0, still] = -1 - sides.shape[2]
    codes = sides * np.arange(1, sides.shape[2] + 1, dtype=np.int32)
    return np.concatenate([first, codes], axis=2)


def tied_sides(ends: Array, c2: Array, by_upper: NDArray[np.bool_]) -> NDArray[np.int8]:
    """Rows whose own end ties with that of their sample: 1 by its upper limit, -1 by its lower one, 0 for none.

    Args:
        ends: Of each row, Shape (N, r).
        c2: Of each sample, Shape (N,).
        by_upper: Whether a row's end is set by its upper limit, Shape (N, r).
    """
    given = np.where(np.isfinite(c2), c2, np.nan)[:, None]
    near = np.abs(ends - given) <= BINDING_TOLERANCE * np.abs(given)
    return np.where(near, np.where(by_upper, 1, -1), 0).astype(np.int8)


def _below_zero(a: Array, b: Array) -> tuple[Array, Array]:
    """Where a c² + b <= 0 with c² >= 0: an interval, [∞, -∞] if nowhere."""
    with np.errstate(divide="ignore", invalid="ignore"):
        root = 0.0 - b / a
    inside, falls = b <= 0, a < 0
    lower = np.where(inside, 0.0, np.where(falls, root, np.inf))
    upper = np.where(falls | (inside & (a == 0)), np.inf, np.where(inside, root, -np.inf))
    return lower, upper


UNBOUNDED = 1e9
"""Effect of the speed on some row, as a multiple of its limit, beyond which a range has no upper end."""

AT_UNBOUNDED = 1e-9
"""Rounding of an answer at that bound."""

NO_EFFECT = 1e-300
"""What moves no row by more than this share of a limit moves none: its reciprocal is not finite. As in numbers.h."""


def ends_by_linear_programs(problem: SampleProblem, solver: str) -> RangeEnds:
    """Eqs. (26), (29): least and largest c² >= 0 within all limits; c² is scaled to the size of the other unknowns.

    Caps go in as a bound of c²: rows of a motion near rest would spoil its scale.
    """
    count, _, unknowns = problem.A.shape
    effect = effect_of_speed(problem)
    unit = 1 / np.where(effect > 0, effect, 1.0)  # c² = unit · y, where y = 1 moves some row by a whole limit
    caps, most = problem.is_cap, problem.cap()
    A, lower, upper = problem.A[:, ~caps], problem.lower[:, ~caps], problem.upper[:, ~caps]
    A[:, :, -1] *= unit[:, None]
    x_lower = np.full((count, unknowns), -np.inf)
    x_lower[:, -1] = 0.0
    x_upper = np.full((count, unknowns), np.inf)
    x_upper[:, -1] = np.where(effect > 0, np.minimum(UNBOUNDED, most / unit), 0.0)

    def solve(direction: float) -> Answers:
        g = np.zeros((count, unknowns))
        g[:, -1] = direction
        programs = ConvexPrograms(H=None, g=g, A=A, lower=lower, upper=upper, x_lower=x_lower, x_upper=x_upper)
        return solve_programs(programs, solver)

    least, largest = solve(1.0), solve(-1.0)
    ends = np.maximum(least.x[:, -1], 0.0) * unit, largest.x[:, -1] * unit
    free = (largest.x[:, -1] >= UNBOUNDED * (1 - AT_UNBOUNDED)) | (effect == 0)
    at_most = np.sign(problem.square[:, caps]) * binds(problem.cap_share) * np.maximum(largest.bound_dual[:, -1:], 0.0)
    duals = [np.zeros(problem.A.shape[:2]) for _ in range(2)]
    duals[0][:, ~caps], duals[1][:, ~caps], duals[1][:, caps] = least.row_dual, largest.row_dual, at_most
    duals[1][free] = 0.0
    weight = np.maximum(np.max(np.abs(duals[0]), axis=1, initial=0.0), still := np.abs(least.bound_dual[:, -1]))
    duals[0][np.abs(duals[0]) <= BINDING_TOLERANCE * weight[:, None]] = 0.0
    codes = [codes_of_duals(duals[0], still > BINDING_TOLERANCE * weight), codes_of_duals(problem, duals[1])]
    undecided = ~(least.verified & largest.verified)
    rows, fallbacks = rows_of_problem(problem, np.stack(codes)), least.fallbacks + largest.fallbacks
    return RangeEnds(ends[0], np.where(free, np.inf, ends[1]), rows, undecided, fallbacks)


def effect_of_speed(problem: SampleProblem) -> Array:
    """Largest effect of c² = 1 on a limit, Shape (N,)."""
    effect: Array = np.max(np.abs(problem.square), axis=1, initial=0.0)
    return np.where(effect > NO_EFFECT, effect, 0.0)


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
    moving = ~problem.is_cap
    square = np.max(np.abs(problem.square[:, moving]), axis=1, initial=0.0)
    effect = np.maximum(square, np.max(np.abs(problem.speed[:, moving]), axis=1, initial=0.0) ** 2)
    with np.errstate(divide="ignore"):
        return np.where(effect > NO_EFFECT, 1 / effect, 0.0)


WIDER = 3e-9
"""Limits are moved outward by this share of themselves, more than c² is off: at the end there may be one solution."""

NEAR = 1e-4
"""A row is at its limit if no solution keeps further away than this share of it: 1 / NEAR times `WIDER` is the least
multiplier, as a share of all, that counts."""


def rows_at_end(problem: SampleProblem, c2: float, end: Side) -> tuple[ActiveRow, ...]:
    """All rows at their limit in every solution at an end of a sample's range, in the order of the rows.

    A row whose limits are equal is at both whatever c² is, and none of them.
    """
    if end == "lower" and c2 * float(effect_of_speed(problem)[0]) <= WIDER:
        return (ActiveRow(STANDSTILL, "lower", 0.0),)
    moving = np.flatnonzero(~problem.is_cap)
    lower, upper = (limit[0, moving] for limit in problem.limits_at(c2))
    lower, upper = lower - WIDER, upper + WIDER
    apart = upper - lower > 2 * NEAR
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
    apart = problem.upper - problem.lower > 2 * NEAR
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

    Of those that keep further away than `NEAR` in a solution that keeps from all, it is how far they do there.
    """
    x, _, verified = _away_from(A, lower, upper, row[None], sign[None])
    value: Array = A[row] @ x[0]
    distance = np.where(verified[0], np.where(sign > 0, upper[row] - value, value - lower[row]), 0.0)
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
