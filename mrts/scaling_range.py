# SPDX-License-Identifier: MIT
"""The admissible range of c²: at every sample, and over the whole motion."""

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from mrts.convex_program import Answers, ConvexPrograms, Mask, solve_programs
from mrts.errors import SolverError
from mrts.infeasibility import CERTIFICATE_TOLERANCE, Conflict, find_conflicts
from mrts.limit_rows import STANDSTILL, ActiveRow
from mrts.rigid_transform import Array
from mrts.sample_problem import SampleProblem

REST_TOLERANCE = 1e-12
"""A sample is at rest where c² moves no row by more than this share of what it does elsewhere."""

UNBOUNDED = 1e9
"""Effect of the speed on some row, as a multiple of its limit, beyond which a range has no upper end."""

BINDING_TOLERANCE = 1e-7
"""A row binds if its multiplier exceeds this share of the largest, or, in closed form, its c² ties this closely."""

POINT_TOLERANCE = 1e-9
"""Relative overlap by which rounding may miss a range that is a single point."""


class SampleStatus(Enum):
    """Outcome at one sample."""

    FEASIBLE = "feasible"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"


class ScalingStatus(Enum):
    """Outcome over the motion; the text says what it means and what to do."""

    FEASIBLE = "feasible"
    INFEASIBLE = "infeasible"
    EMPTY = "empty"
    UNBOUNDED = "unbounded"

    @property
    def advice(self) -> str:
        """What this outcome means and what to do."""
        return {
            "feasible": "Every c² in the range keeps all limits.",
            "infeasible": (
                "Some sample is infeasible at every speed. Move the path, raise a limit, lighten the load, or try "
                "another configuration."
            ),
            "empty": (
                "Every sample is feasible at some speed, but no constant c² suits all. Change the velocity profile, "
                "or split the motion between the two samples."
            ),
            "unbounded": "No limit depends on the speed at the samples. Any c² from the lower end on is admissible.",
        }[self.value]

    @property
    def admits_motion(self) -> bool:
        """Whether some c² is admissible."""
        return self in {ScalingStatus.FEASIBLE, ScalingStatus.UNBOUNDED}


@dataclass(frozen=True)
class SampleRanges:
    """The least and the largest c² of each of N samples.

    Attributes:
        time: Of the given motion, Shape (N,) [s].
        status: Shape (N,).
        lower: c²⁻(t), Shape (N,); infinity where infeasible.
        upper: c²⁺(t), Shape (N,); minus infinity where infeasible, infinity where unbounded.
        lower_rows: Rows that bind at the lower end of each sample.
        upper_rows: Rows that bind at the upper end of each sample.
        conflicts: One for each infeasible sample, in order.
        fallbacks: Programs that the chosen solver did not solve and another did.
    """

    time: Array
    status: tuple[SampleStatus, ...]
    lower: Array
    upper: Array
    lower_rows: tuple[tuple[ActiveRow, ...], ...]
    upper_rows: tuple[tuple[ActiveRow, ...], ...]
    conflicts: tuple[Conflict, ...]
    fallbacks: int


@dataclass(frozen=True)
class RangeEnd:
    """One end of the range over the motion.

    Attributes:
        c2: Its value; infinity if nothing limits it.
        sample: Where it is reached, None if nothing limits it.
        time: Of that sample [s], None if nothing limits it.
        rows: Rows that bind there.
    """

    c2: float
    sample: int | None
    time: float | None
    rows: tuple[ActiveRow, ...]


@dataclass(frozen=True)
class ScalingRange:
    """The range over the whole motion.

    Attributes:
        status: The outcome.
        lower: c²⁻, None if infeasible.
        upper: c²⁺, None if infeasible. Empty if below `lower`.
        samples: The ranges that were intersected.
    """

    status: ScalingStatus
    lower: RangeEnd | None
    upper: RangeEnd | None
    samples: SampleRanges

    def explain(self) -> str:
        """Why no c² is admissible (the message of step 3.2); empty if some is."""
        if self.status is ScalingStatus.INFEASIBLE:
            conflicts = self.samples.conflicts
            worst = max(conflicts, key=lambda conflict: conflict.widening)
            text = f"{len(conflicts)} of {len(self.samples.time)} samples are infeasible; worst {worst}."
        elif self.status is ScalingStatus.EMPTY and self.lower and self.upper:
            slow, fast = self.lower, self.upper
            text = (
                f"at t = {slow.time:.4g} s c² must be at least {slow.c2:.6g} ({_joined(slow.rows)}), but at "
                f"t = {fast.time:.4g} s at most {fast.c2:.6g} ({_joined(fast.rows)})."
            )
        else:
            return ""
        return f"{text} {self.status.advice}"


def _joined(rows: tuple[ActiveRow, ...]) -> str:
    return "; ".join(str(row) for row in rows)


def sample_ranges(problem: SampleProblem, time: Array, solver: str) -> SampleRanges:
    """Step 1 of MMTSF: min and max of c² at every sample, with binding rows.

    One unknown (a fixed distribution, a single arm) is an intersection of intervals; more are linear programs.

    Args:
        problem: Rows along the motion.
        time: Shape (N,) [s].
        solver: Name in the registry.

    Raises:
        InputError: If there is no such solver.
        SolverError: If no solver answers.
    """
    problem = _without_speed_at_rest(problem)
    find = _ends_in_closed_form if problem.unknowns == 1 else _ends_by_linear_programs
    ends = find(problem, solver)
    conflicts: dict[int, Conflict] = {}
    if np.any(ends.undecided):
        suspects = np.flatnonzero(ends.undecided)
        found = find_conflicts(problem, time, suspects, solver)
        conflicts = {conflict.sample: conflict for conflict in found if conflict is not None}
        marginal = np.array([sample for sample in suspects if sample not in conflicts], dtype=int)
        if marginal.size:
            ends.replace(marginal, find(_relaxed(problem.at(marginal)), solver))
    status = [SampleStatus.UNBOUNDED if np.isinf(high) else SampleStatus.FEASIBLE for high in ends.high]
    for sample in conflicts:
        ends.low[sample], ends.high[sample] = np.inf, -np.inf
        ends.low_rows[sample] = ends.high_rows[sample] = ()
        status[sample] = SampleStatus.INFEASIBLE
    return SampleRanges(
        time,
        tuple(status),
        ends.low,
        ends.high,
        tuple(ends.low_rows),
        tuple(ends.high_rows),
        tuple(conflicts.values()),
        ends.fallbacks,
    )


def intersect(samples: SampleRanges) -> ScalingRange:
    """Eq. (30): the intersection of the ranges of all samples (step 2 of MMTSF).

    Args:
        samples: Ranges of all samples.
    """
    if samples.conflicts:
        return ScalingRange(ScalingStatus.INFEASIBLE, None, None, samples)
    at_low, at_high = int(np.argmax(samples.lower)), int(np.argmin(samples.upper))
    low, high = float(samples.lower[at_low]), float(samples.upper[at_high])
    if high < low <= high * (1 + POINT_TOLERANCE):
        low = high
    lower = RangeEnd(low, at_low, float(samples.time[at_low]), samples.lower_rows[at_low])
    if np.isinf(high):
        return ScalingRange(ScalingStatus.UNBOUNDED, lower, RangeEnd(high, None, None, ()), samples)
    upper = RangeEnd(high, at_high, float(samples.time[at_high]), samples.upper_rows[at_high])
    status = ScalingStatus.FEASIBLE if low <= high else ScalingStatus.EMPTY
    return ScalingRange(status, lower, upper, samples)


@dataclass
class _Ends:
    """Least and largest c² of a batch, the rows that bind there, and where neither was found."""

    low: Array
    high: Array
    low_rows: list[tuple[ActiveRow, ...]]
    high_rows: list[tuple[ActiveRow, ...]]
    undecided: Mask
    fallbacks: int

    def replace(self, samples: NDArray[np.int_], other: "_Ends") -> None:
        """Take some samples from another batch, which must have found them."""
        if np.any(other.undecided):
            sample = int(samples[int(np.argmax(other.undecided))])
            raise SolverError(
                f"no solver found the range of c² at sample {sample}, although its limits hold together. This is a "
                "defect of mrts or of extremely scaled data: please report the cell and the motion."
            )
        for index, sample in enumerate(samples):
            low, high = other.low[index], other.high[index]
            self.low[sample], self.high[sample] = min(low, high), high
            self.low_rows[sample], self.high_rows[sample] = other.low_rows[index], other.high_rows[index]
        self.fallbacks += other.fallbacks


def _without_speed_at_rest(problem: SampleProblem) -> SampleProblem:
    """The same problem with exactly no effect of c² where only rounding is left of it."""
    effect = np.max(np.abs(problem.A[:, :, -1]), axis=1)
    at_rest = effect <= REST_TOLERANCE * np.max(effect, initial=0.0)
    A = problem.A.copy()
    A[at_rest, :, -1] = 0.0
    return replace(problem, A=A)


def _relaxed(problem: SampleProblem) -> SampleProblem:
    """The same problem with limits wider by what `find_conflicts` cannot tell from nothing."""
    slack = 2 * CERTIFICATE_TOLERANCE * problem.is_limit
    return replace(problem, lower=problem.lower - slack, upper=problem.upper + slack)


def _ends_in_closed_form(problem: SampleProblem, _solver: str) -> _Ends:
    """Eqs. (38), (39): every row bounds c² by itself; `intersect` adds the intersection over t."""
    slope = problem.A[:, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        at_lower, at_upper = problem.lower / slope, problem.upper / slope
    none = np.full_like(slope, np.inf)
    least = np.where(slope > 0, at_lower, np.where(slope < 0, at_upper, -none))
    most = np.where(slope > 0, at_upper, np.where(slope < 0, at_lower, none))
    low, high = np.maximum(np.max(least, axis=1), 0.0), np.min(most, axis=1)
    violated = (slope == 0) & ((problem.lower > 0) | (problem.upper < 0))
    undecided = np.any(violated, axis=1) | (low > high)
    low_rows, high_rows = [], []
    for sample in range(problem.samples):
        s = slope[sample]
        low_rows.append(_closest_rows(problem, least[sample], low[sample], np.where(s > 0, -1.0, 1.0)))
        high_rows.append(_closest_rows(problem, most[sample], high[sample], np.where(s > 0, 1.0, -1.0)))
    return _Ends(low, high, low_rows, high_rows, undecided, 0)


def _closest_rows(problem: SampleProblem, ends: Array, c2: float, sign: Array) -> tuple[ActiveRow, ...]:
    if not np.isfinite(c2):
        return ()
    near = np.abs(ends - c2) <= BINDING_TOLERANCE * abs(c2)
    if not np.any(near):
        return (ActiveRow(STANDSTILL, "lower", 0.0),)
    return _active_rows(problem, np.where(near, sign, 0.0), 0.0)


def _ends_by_linear_programs(problem: SampleProblem, solver: str) -> _Ends:
    """Eqs. (26), (29): least and largest c² >= 0 within all limits; c² is scaled to the size of the other unknowns."""
    count, _, unknowns = problem.A.shape
    effect = _effect_of_speed(problem)
    unit = 1 / np.where(effect > 0, effect, 1.0)  # c² = unit · y, where y = 1 moves some row by a whole limit
    A = problem.A.copy()
    A[:, :, -1] *= unit[:, None]
    x_lower = np.full((count, unknowns), -np.inf)
    x_lower[:, -1] = 0.0
    x_upper = np.full((count, unknowns), np.inf)
    x_upper[:, -1] = np.where(effect > 0, UNBOUNDED, 0.0)

    def solve(direction: float) -> Answers:
        g = np.zeros((count, unknowns))
        g[:, -1] = direction
        programs = ConvexPrograms(None, g, A, problem.lower, problem.upper, x_lower, x_upper)
        return solve_programs(programs, solver)

    least, most = solve(1.0), solve(-1.0)
    low, high = np.maximum(least.x[:, -1], 0.0) * unit, most.x[:, -1] * unit
    free = (most.x[:, -1] >= UNBOUNDED * (1 - POINT_TOLERANCE)) | (effect == 0)
    high = np.where(free, np.inf, high)
    low_rows = [
        _active_rows(problem, least.row_dual[sample], float(least.bound_dual[sample, -1])) for sample in range(count)
    ]
    high_rows = [_active_rows(problem, most.row_dual[sample], 0.0) for sample in range(count)]
    undecided = ~(least.verified & most.verified)
    return _Ends(low, high, low_rows, high_rows, undecided, least.fallbacks + most.fallbacks)


def _effect_of_speed(problem: SampleProblem) -> Array:
    """Largest effect of c² = 1 on a limit, or on a balance that other unknowns of the size of their limits keep."""
    size = np.abs(problem.A)
    limits = size[:, problem.is_limit]
    effect: Array = np.max(limits[:, :, -1], axis=1)
    laws = size[:, ~problem.is_limit]
    if laws.shape[1] == 0:
        return effect
    reach = np.max(limits[:, :, :-1], axis=1)  # 1 / size of each unknown at its limits
    terms = np.max(laws[:, :, :-1] / np.where(reach > 0, reach, 1.0)[:, None, :], axis=2)
    in_laws: Array = np.max(laws[:, :, -1] / np.where(terms > 0, terms, 1.0), axis=1)
    return np.maximum(effect, in_laws)


def _active_rows(problem: SampleProblem, dual: Array, standstill_dual: float) -> tuple[ActiveRow, ...]:
    """Rows with a multiplier, strongest first; rows of the object's balance are laws and are left out."""
    largest = max(float(np.max(np.abs(dual), initial=0.0)), abs(standstill_dual))
    active = []
    if abs(standstill_dual) > BINDING_TOLERANCE * largest:
        active.append(ActiveRow(STANDSTILL, "lower", 0.0))
    order = np.argsort(-np.abs(dual), kind="stable")
    strong = [row for row in order if problem.is_limit[row] and abs(dual[row]) > BINDING_TOLERANCE * largest]
    return tuple(active + [problem.active_row(row, upper=bool(dual[row] > 0)) for row in strong])
