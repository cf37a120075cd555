# SPDX-License-Identifier: MIT
"""Least and largest c² of every sample, by the kernel, linear programs or intervals of speeds, and what sets them.

Where more rows meet at an end than the unknowns need, a solver gives multipliers to some of them only, and which
depends on its basis. `rows_at_end` names all that are at their limit in every solution there; by strict complementarity
they are those with a multiplier in some solution of the dual program.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, without_infinity
from mrts.base.errors import SolverError
from mrts.base.load_box import LoadPoint
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.binding import INFINITY
from mrts.kernel.programs import INFEASIBLE, MARGINAL, OPTIMAL, STOPPED, speed_intervals
from mrts.limits.rows import STANDSTILL, ActiveRow, RowName, Side
from mrts.program.infeasibility import CERTIFICATE_TOLERANCE, Conflict, conflicts_at, linear_conflicts, widening_at
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import CAPS_TIE, MotionRows, binds, motion_rows
from mrts.program.sample_problem import BLOCK, SampleProblem, build_sample_problem
from mrts.program.solvers import DEFAULT_SOLVER, Answers, ConvexPrograms, scales, solve_programs

REST_TOLERANCE = 1e-12
"""A sample is at rest where c² moves no row by more than this share of what it does elsewhere."""

POINT_TOLERANCE = 1e-9
"""Relative overlap by which rounding may miss a range that is a single point."""

TIE = 1e-7
"""Relative difference of two samples' ends, or two loads', that may be rounding: the first of them counts as the one
that sets the end, so that it does not depend on the solver."""

SIDES: tuple[Side, Side] = ("lower", "upper")

Asked = tuple[Cell, CoordinatedMotion, LoadSharing | None, Array | None]
"""Whose ranges they are; the load is the cell's where there is none. Rows hold what C reads and stay in their process,
where results may leave it."""


class RangeStatus(Enum):
    """Outcome at one sample, or over the motion; `advice` says what it means there and what to do.

    A sample is empty if every load of a box has a range there, but no c² is in all.
    """

    FEASIBLE = "feasible"
    INFEASIBLE = "infeasible"
    EMPTY = "empty"
    UNBOUNDED = "unbounded"

    @property
    def advice(self) -> str:
        """What this outcome over the motion means and what to do."""
        return {
            "feasible": "Every c² in the range keeps all limits.",
            "infeasible": (
                "Some sample is infeasible at every speed. Move the path, raise a limit, lighten the load, or try "
                "another configuration."
            ),
            "empty": (
                "Every sample, and every load, is feasible at some speed, but no constant c² suits all. Change the "
                "velocity profile, split the motion between the two samples, or narrow the load."
            ),
            "unbounded": "No limit depends on the speed at the samples: you may play it as fast as you like.",
        }[self.value]

    @property
    def admits_motion(self) -> bool:
        """Whether some c² is admissible."""
        return self in {RangeStatus.FEASIBLE, RangeStatus.UNBOUNDED}


SampleStatus = ScalingStatus = RangeStatus
"""The public names: of a sample's range, and of the range over the motion."""


@dataclass(frozen=True)
class SampleRanges:
    """The least and the largest c² of each of N samples: of the highest interval where a sample admits several.

    Attributes:
        time: Time in the given motion, Shape (N,) [s].
        lower: c²⁻(t), Shape (N,); infinity where infeasible.
        upper: c²⁺(t), Shape (N,); minus infinity where infeasible, infinity where unbounded.
        names: Names of the r rows.
        limits: Their lower and upper limits as given, Shape (2, r).
        duals: Which of them and of c² >= 0 bind at both ends of each sample, as of `RangeEnds`, Shape (2, N, r + 1).
        gaps: Whether a sample admits other intervals of c² as well, Shape (N,).
        conflicts: One for each infeasible sample, in order.
        loads: If the load is uncertain, the loads that set the lower and the upper end of each sample.
        asked: From what the rows of a sample are made again; None where `duals` has all that bind.
    """

    time: Array
    lower: Array
    upper: Array
    names: tuple[RowName, ...]
    limits: Array
    duals: NDArray[np.float32]
    gaps: NDArray[np.bool_]
    conflicts: tuple[Conflict, ...] = ()
    loads: tuple[Sequence[LoadPoint], Sequence[LoadPoint]] | None = None
    asked: Asked | None = field(default=None, repr=False, compare=False)

    @cached_property
    def status(self) -> tuple[RangeStatus, ...]:
        """The outcome at every sample."""
        names = np.array([RangeStatus.FEASIBLE, RangeStatus.EMPTY, RangeStatus.UNBOUNDED, RangeStatus.INFEASIBLE])
        empty = self.lower > self.upper * (1 + POINT_TOLERANCE)
        code = np.where(np.isinf(self.upper), 2, np.where(empty, 1, 0))
        code[[conflict.sample for conflict in self.conflicts]] = 3
        return tuple(names[code].tolist())

    @property
    def several(self) -> bool:
        """Whether some sample admits other intervals of c² as well."""
        return bool(self.gaps.any())

    def load_at(self, sample: int, side: Side) -> LoadPoint | None:
        """The load that sets one end of a sample; None where the load is known."""
        return None if self.loads is None else self.loads[SIDES.index(side)][sample]

    def binding(self, sample: int, side: Side) -> tuple[ActiveRow, ...]:
        """Rows that bind at one end of a sample; where more meet than determine it, some of them."""
        dual, found = self.duals[SIDES.index(side), sample], []
        for row in np.argsort(-np.abs(dual), kind="stable")[: np.count_nonzero(dual)].tolist():
            if row == len(self.names):
                found.append(ActiveRow(STANDSTILL, "lower", 0.0))
            else:
                found.append(ActiveRow.of(self.names[row], *self.limits[:, row].tolist(), at_upper=bool(dual[row] > 0)))
        return tuple(dict.fromkeys(found))

    def all_binding(self, sample: int, side: Side) -> tuple[ActiveRow, ...]:
        """All rows that bind at one end of a sample."""
        c2 = float((self.lower if side == "lower" else self.upper)[sample])
        if self.asked is None or not np.isfinite(c2) or (side == "lower" and c2 == 0):
            return self.binding(sample, side)
        (cell, motion, sharing, known), load = self.asked, self.load_at(sample, side)
        rows, carried = motion_rows(cell, motion, sharing), known if load is None else load.load
        problem = build_sample_problem(rows, load=carried, samples=np.array([sample]))
        return rows_at_end(problem, c2, side) or self.binding(sample, side)

    def to_json(self) -> dict[str, Any]:
        """Entry of "samples" in the JSON result; null stands for an end that does not exist."""
        return {
            "time": self.time.tolist(),
            "status": [status.value for status in self.status],
            "c2_lower": without_infinity(self.lower),
            "c2_upper": without_infinity(self.upper),
        }


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
    fields = [*numbers, ("status", np.intc), ("duals", np.float32, (2, rows + 1))]  # as mrts_range of trajectory.c
    ends = np.zeros(samples, dtype=np.dtype(fields, align=True))
    ends["lower"], ends["upper"], ends["status"] = np.inf, -np.inf, STOPPED
    return ends


def kernel_ends(rows: MotionRows, load: Array | None, most: Array) -> RangeEnds:
    """The ends at all samples in one call of the kernel, c² at most `most`, Shape (N,)."""
    ends, kept = unknown_ends(len(most), len(rows.given.names)), (~rows.is_cap).nonzero()[0]
    name = "mrts_speed_ranges" if rows.has_speed_terms else "mrts_ranges"
    for_all = ends["duals"].shape[2], kept
    rows.over_samples(name, [np.minimum(most, INFINITY)], [ends], for_all, load=load)
    return ends


def _binding(dual: NDArray[np.floating[Any]]) -> NDArray[np.bool_]:
    """Which of some multipliers at an end, Shape (…, k), are no rounding."""
    size = np.abs(dual)
    return np.asarray(size > BINDING_TOLERANCE * size.max(axis=-1, initial=0.0, keepdims=True))


def with_caps(ends: RangeEnds, rows: MotionRows | SampleProblem) -> RangeEnds:
    """The same ends with the caps of rows that bind at the upper ones."""
    upper = ends["upper"]
    at_cap = (np.isfinite(upper) & (upper >= (1 - BINDING_TOLERANCE) * rows.most)).nonzero()[0]
    share = rows.cap_share[at_cap]
    sample, cap = binds(share).nonzero()
    ends["duals"][at_cap[sample], 1, rows.is_cap.nonzero()[0][cap]] = np.copysign(np.inf, share[sample, cap])
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
    return with_caps(found, problem)


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
    lower[:, -1], upper[:, -1] = 0.0, np.where(effect > 0, np.minimum(UNBOUNDED, problem.most / unit), 0.0)

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
    ends["upper"] = np.where(free, np.inf, np.maximum(largest.x[:, -1], 0.0) * unit)
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
    found = find(most)
    highest = found["below"].copy()
    for _ in range(MOST_INTERVALS):
        above = (found["below"] > 0) & (found["lower"] > high)
        if not above.any():
            break
        further = find(np.where(above, found["below"], most))
        some = above & (further["status"] != INFEASIBLE)
        found["below"][above] = 0.0
        found[some] = further[some]
    found["below"] = highest
    return found


def highest_intervals(problem: SampleProblem, most: Array) -> RangeEnds:
    """Eqs. (38), (39): the highest interval of c² up to `most`, Shape (N,), that each sample admits.

    The equations are left where c² is the only unknown: every row bounds it by itself. `duals` leave out caps.
    """
    rows, cap = ~problem.is_cap, np.minimum(problem.most, most)
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
        caps = np.flatnonzero(problem.is_cap)[np.abs(problem.cap_share[0]) * c2 >= 1 - CAPS_TIE]
        named += [problem.active_row(row, upper=bool(problem.square[0, row] > 0)) for row in caps.tolist()]
    return tuple(dict.fromkeys(named))  # the sides of a norm have one name


def motion_ranges(rows: MotionRows, load: Array | None = None, high: float = np.inf) -> SampleRanges:
    """Least and largest c² at every sample (step 1 of MMTSF), by the compiled path where it applies.

    A load stands instead of the cell's, Shape (10,). Of several intervals it is the highest that does not begin above
    `high`.
    """
    time, asked = rows.motion.object.time, (rows.cell, rows.motion, rows.sharing, load)
    if rows.solver != DEFAULT_SOLVER or not rows.compiled:
        return sample_ranges(build_sample_problem(rows, load=load), time, high, asked)
    find = partial(kernel_ends, rows, load)
    ends = intervals_below(find, rows.most, high) if rows.has_speed_terms else find(rows.most)
    effect = float(ends["effect"].max(initial=0.0))
    at_rest = ends["effect"] <= REST_TOLERANCE * effect
    ends["upper"][at_rest], ends["duals"][at_rest, 1] = rows.most[at_rest], 0
    suspects = ((ends["status"] != OPTIMAL) | (at_rest & (ends["lower"] > 0))).nonzero()[0]
    ends, conflicts = with_caps(ends, rows), []
    for start in range(0, len(suspects), BLOCK):
        block = suspects[start : start + BLOCK]
        problem = without_speed_at_rest(build_sample_problem(rows, load=load, samples=block), effect)
        conflicts += decide(ends, block, problem, time, high)
    return _ranges(time, ends, conflicts, (rows.given.names, rows.given.limits.lower, rows.given.limits.upper), asked)


def sample_ranges(
    problem: SampleProblem, time: Array, high: float = np.inf, asked: Asked | None = None
) -> SampleRanges:
    """Step 1 of MMTSF for rows along a motion: min and max of c² at every sample; see `motion_ranges`."""
    still = without_speed_at_rest(problem)
    ends = ends_of_problem(still, high, alone=True)
    conflicts = decide(ends, (ends["status"] != OPTIMAL).nonzero()[0], still, time, high)
    return _ranges(time, ends, conflicts, (problem.names, problem.limit_lower, problem.limit_upper), asked)


def _ranges(
    time: Array,
    ends: RangeEnds,
    conflicts: Sequence[Conflict],
    rows: tuple[tuple[RowName, ...], Array, Array],
    asked: Asked | None,
) -> SampleRanges:
    names, limits = rows[0], np.array(rows[1:])
    lower, upper = ends["lower"] + 0.0, ends["upper"] + 0.0  # 0 has no sign
    duals, gaps = ends["duals"].swapaxes(0, 1), ends["below"] > 0
    return SampleRanges(time, lower, upper, names, limits, duals, gaps, tuple(conflicts), asked=asked)


def decide(
    ends: RangeEnds, samples: NDArray[np.intp], problem: SampleProblem, time: Array, high: float
) -> list[Conflict]:
    """Find the ends of some samples that one solver did not find, or the conflicts of those that have none.

    `ends` and `time` are those of all samples; ends are changed in place. The problem is of these samples, or of all.

    Raises:
        SolverError: If no solver answers.
    """
    if not samples.size:
        return []
    part = problem if problem.samples == samples.size else problem.at(samples)
    own = unknown_ends(samples.size, len(part.names))
    found = find_conflicts(part, time[samples])
    feasible = np.array([conflict is None for conflict in found], dtype=bool)
    own["status"][~feasible] = OPTIMAL
    for widening in (0.0, 2 * CERTIFICATE_TOLERANCE):  # wider by what cannot be told from nothing
        left = (own["status"] != OPTIMAL).nonzero()[0]
        if left.size:
            wider = replace(part, lower=part.lower - widening, upper=part.upper + widening).at(left)
            own[left] = ends_of_problem(wider, high)
            own["lower"][left] = np.minimum(own["lower"], own["upper"])[left]
    for place in (own["status"] != OPTIMAL).nonzero()[0][:1]:
        raise SolverError(
            f"no solver found the range of c² at t = {time[samples[place]]:.6g} s, although its limits hold "
            "together. This is a defect of mrts or of extremely scaled data: please report the cell and the motion."
        )
    ends[samples] = own
    return [replace(one, sample=int(samples[one.sample])) for one in found if one is not None]


def first_least(values: Array) -> Any:
    """Place of the least value along the first axis, the first of those that differ by rounding only."""
    least = values.min(axis=0)
    return (values <= least + TIE * np.abs(np.where(np.isfinite(least), least, 0.0))).argmax(axis=0)


def without_speed_at_rest(problem: SampleProblem, largest: float = 0.0) -> SampleProblem:
    """The same problem with exactly no effect of c² on torques and wrenches where only rounding is left of it.

    It is compared with the largest effect of c², or of c squared, at these and other samples of the motion.
    """
    dynamic, speed = ~problem.is_cap, problem.speed
    effect = problem.effect(caps=False)
    at_rest = effect <= REST_TOLERANCE * np.max(effect, initial=largest)
    A, still = problem.A.copy(), at_rest[:, None] & dynamic
    A[:, :, -1] = np.where(still, 0.0, problem.square)
    return replace(problem, A=A, speed=None if speed is None else np.where(still, 0.0, speed))


HALVINGS = 40
"""Bisections for the widening at the closest speed: to 1e-12 of what standstill takes."""


def find_conflicts(problem: SampleProblem, time: Array) -> list[Conflict | None]:
    """`linear_conflicts`; where rows have a term in ṙ, at the speed that comes closest."""
    if problem.speed is None:
        return linear_conflicts(problem, time)
    best = closest_speed(problem) ** 2
    found = zip(conflicts_at(problem, best, time), best.tolist(), strict=True)
    return [conflict and replace(conflict, c2=c2) for conflict, c2 in found]


def closest_speed(problem: SampleProblem) -> Array:
    """The c at which the limits of a sample must move outward the least, Shape (N,), where rows have a term in ṙ.

    The widening is no convex function of c, but the more of it the more speeds are admitted: it is halved as long as
    some speed is left, up to what standstill takes.
    """
    c, low = np.zeros((2, problem.samples))
    high = widening_at(problem, 0.0)
    for _ in range(HALVINGS):
        level = (low + high) / 2
        moved = level[:, None] * problem.is_limit
        wider = replace(problem, lower=problem.lower - moved, upper=problem.upper + moved)
        found = highest_intervals(wider, np.full(problem.samples, np.inf))
        admitted = found["status"] == OPTIMAL
        low, high = np.where(admitted, low, level), np.where(admitted, level, high)
        least, most = np.sqrt(found["lower"][admitted]), np.sqrt(found["upper"][admitted])
        c[admitted] = np.where(np.isfinite(most), (least + most) / 2, least)
    return c
