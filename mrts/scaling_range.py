# SPDX-License-Identifier: MIT
"""The admissible range of c²: at every sample, and over the whole motion."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np

from mrts.closed_form_range import ends_in_closed_form
from mrts.infeasibility import CERTIFICATE_TOLERANCE, Conflict, find_conflicts
from mrts.interval_text import interval_text
from mrts.limit_rows import ActiveRow
from mrts.linear_program_range import ends_by_linear_programs
from mrts.load_box import LoadPoint
from mrts.range_ends import RangeEnds
from mrts.rigid_transform import Array
from mrts.sample_problem import SampleProblem

REST_TOLERANCE = 1e-12
"""A sample is at rest where c² moves no row by more than this share of what it does elsewhere."""

POINT_TOLERANCE = 1e-9
"""Relative overlap by which rounding may miss a range that is a single point."""

TIE = 1e-7
"""Relative difference of two samples' ends, or two loads', that may be rounding: the first of them counts as the one
that sets the end, so that it does not depend on the solver."""


class SampleStatus(Enum):
    """Outcome at one sample; empty if every load of a box has a range there, but no c² is in all."""

    FEASIBLE = "feasible"
    INFEASIBLE = "infeasible"
    EMPTY = "empty"
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
                "Every sample, and every load, is feasible at some speed, but no constant c² suits all. Change the "
                "velocity profile, split the motion between the two samples, or narrow the load."
            ),
            "unbounded": "No limit depends on the speed at the samples: you may play it as fast as you like.",
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
        lower_loads: If the load is uncertain, the load that sets the lower end of each sample.
        upper_loads: Likewise of the upper end.
    """

    time: Array
    status: tuple[SampleStatus, ...]
    lower: Array
    upper: Array
    lower_rows: Sequence[tuple[ActiveRow, ...]]
    upper_rows: Sequence[tuple[ActiveRow, ...]]
    conflicts: tuple[Conflict, ...]
    fallbacks: int
    lower_loads: Sequence[LoadPoint] | None = None
    upper_loads: Sequence[LoadPoint] | None = None


@dataclass(frozen=True)
class RangeEnd:
    """One end of the range over the motion.

    Attributes:
        c2: Its value; infinity if nothing limits it.
        sample: Where it is reached, None if nothing limits it.
        time: Of that sample [s], None if nothing limits it.
        rows: Rows that bind there.
        load: The load that sets it, if the load is uncertain.
    """

    c2: float
    sample: int | None
    time: float | None
    rows: tuple[ActiveRow, ...]
    load: LoadPoint | None = None

    def to_json(self) -> dict[str, Any] | None:
        """Entry of "binding" in the JSON result; None if nothing limits this end."""
        if self.time is None:
            return None
        entry: dict[str, Any] = {"time": self.time, "rows": [row.to_json() for row in self.rows]}
        return entry if self.load is None else entry | {"load": self.load.to_json()}

    def place(self) -> str:
        """When, with which load and by which rows this end is set, in words."""
        of_load = self.load is not None and any(row.name.kind != "velocity" for row in self.rows)
        load = f" with {self.load}" if of_load else ""
        return f"at t = {self.time:.4g} s{load} by {', '.join(str(row) for row in self.rows)}"


@dataclass(frozen=True, repr=False)
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

    def __repr__(self) -> str:
        ends = f"c² ∈ {interval_text(self.lower.c2, self.upper.c2)}, " if self.lower and self.upper else ""
        return f"<ScalingRange {self.status.value}: {ends}{len(self.samples.time)} samples>"

    def to_json(self) -> dict[str, Any]:
        """Status, both ends and what sets them; None stands for an end that does not exist."""
        ends = {"lower": self.lower, "upper": self.upper}
        return {
            "status": self.status.value,
            "c2": {side: end.c2 if end and np.isfinite(end.c2) else None for side, end in ends.items()},
            "binding": {side: end.to_json() if end else None for side, end in ends.items()},
        }

    def explain(self) -> str:
        """Why no c² is admissible (the message of step 3.2); empty if some is."""
        if self.status is ScalingStatus.INFEASIBLE:
            conflicts = self.samples.conflicts
            worst = max(conflicts, key=lambda conflict: conflict.widening)
            text = f"{len(conflicts)} of {len(self.samples.time)} samples are infeasible. The worst: {worst}."
        elif self.status is ScalingStatus.EMPTY and self.lower and self.upper:
            slow, fast = self.lower, self.upper
            text = f"c² must be at least {slow.c2:.6g} {slow.place()}, but at most {fast.c2:.6g} {fast.place()}."
        else:
            return ""
        return f"{text} {self.status.advice}"


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
    problem = without_speed_at_rest(problem)

    def find(part: SampleProblem) -> RangeEnds:
        return ends_in_closed_form(part) if part.unknowns == 1 else ends_by_linear_programs(part, solver)

    ends = find(problem)
    conflicts: dict[int, Conflict] = {}
    if np.any(ends.undecided):
        suspects = np.flatnonzero(ends.undecided)
        found = find_conflicts(problem, time, suspects, solver)
        conflicts = {conflict.sample: conflict for conflict in found if conflict is not None}
        marginal = np.array([sample for sample in suspects if sample not in conflicts], dtype=int)
        if marginal.size:
            ends.replace(marginal, find(_relaxed(problem.at(marginal))))
    for sample in conflicts:
        ends.low[sample], ends.high[sample] = np.inf, -np.inf
        ends.low_rows[sample] = ends.high_rows[sample] = ()
    return SampleRanges(
        time,
        statuses(ends.low, ends.high, conflicts.values()),
        ends.low,
        ends.high,
        tuple(ends.low_rows),
        tuple(ends.high_rows),
        tuple(conflicts.values()),
        ends.fallbacks,
    )


def statuses(low: Array, high: Array, conflicts: Iterable[Conflict]) -> tuple[SampleStatus, ...]:
    """The outcome at every sample.

    Args:
        low: c²⁻(t), Shape (N,).
        high: c²⁺(t), Shape (N,).
        conflicts: Of the infeasible samples.
    """
    names = np.array([SampleStatus.FEASIBLE, SampleStatus.EMPTY, SampleStatus.UNBOUNDED, SampleStatus.INFEASIBLE])
    code = np.where(np.isinf(high), 2, np.where(low > high * (1 + POINT_TOLERANCE), 1, 0))
    code[[conflict.sample for conflict in conflicts]] = 3
    return tuple(names[code].tolist())


def intersect(samples: SampleRanges) -> ScalingRange:
    """Eq. (30): the intersection of the ranges of all samples (step 2 of MMTSF).

    Args:
        samples: Ranges of all samples.
    """
    if samples.conflicts:
        return ScalingRange(ScalingStatus.INFEASIBLE, None, None, samples)
    at_low, at_high = int(first_least(-samples.lower)), int(first_least(samples.upper))
    low, high = float(np.max(samples.lower)), float(np.min(samples.upper))
    if high < low <= high * (1 + POINT_TOLERANCE):
        low = high
    lower = _end(samples, at_low, low, samples.lower_rows, samples.lower_loads)
    if np.isinf(high):
        return ScalingRange(ScalingStatus.UNBOUNDED, lower, RangeEnd(high, None, None, ()), samples)
    upper = _end(samples, at_high, high, samples.upper_rows, samples.upper_loads)
    status = ScalingStatus.FEASIBLE if low <= high else ScalingStatus.EMPTY
    return ScalingRange(status, lower, upper, samples)


def first_least(values: Array) -> Any:
    """Place of the least value along the first axis, the first of those that differ by rounding only.

    Args:
        values: Shape (N,), or any with N first: then a place for each column.
    """
    least = np.min(values, axis=0)
    return np.argmax(values <= least + TIE * np.abs(np.where(np.isfinite(least), least, 0.0)), axis=0)


def _end(
    samples: SampleRanges,
    sample: int,
    c2: float,
    rows: Sequence[tuple[ActiveRow, ...]],
    loads: Sequence[LoadPoint] | None,
) -> RangeEnd:
    return RangeEnd(c2, sample, float(samples.time[sample]), rows[sample], loads[sample] if loads else None)


def without_speed_at_rest(problem: SampleProblem, largest: float = 0.0) -> SampleProblem:
    """The same problem with exactly no effect of c² on torques and wrenches where only rounding is left of it.

    Args:
        problem: Rows of some samples.
        largest: Largest effect at other samples of the motion.
    """
    dynamic = ~problem.is_velocity
    effect = np.max(np.abs(problem.A[:, dynamic, -1]), axis=1, initial=0.0)
    at_rest = effect <= REST_TOLERANCE * np.max(effect, initial=largest)
    A = problem.A.copy()
    A[:, :, -1] = np.where(at_rest[:, None] & dynamic, 0.0, A[:, :, -1])
    return replace(problem, A=A)


def _relaxed(problem: SampleProblem) -> SampleProblem:
    """The same problem with limits wider by what `find_conflicts` cannot tell from nothing."""
    slack = 2 * CERTIFICATE_TOLERANCE * problem.is_limit
    return replace(problem, lower=problem.lower - slack, upper=problem.upper + slack)
