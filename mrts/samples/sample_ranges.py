# SPDX-License-Identifier: MIT
"""The admissible range of c² at every sample."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import MrtsError
from mrts.base.load_box import LoadPoint
from mrts.limits.rows import ActiveRow
from mrts.samples.closed_form import ends_in_closed_form
from mrts.samples.infeasibility import CERTIFICATE_TOLERANCE, Conflict, find_conflicts
from mrts.samples.linear_programs import ends_by_linear_programs
from mrts.samples.range_ends import RangeEnds
from mrts.samples.range_status import RangeStatus
from mrts.samples.sample_problem import SampleProblem

REST_TOLERANCE = 1e-12
"""A sample is at rest where c² moves no row by more than this share of what it does elsewhere."""

POINT_TOLERANCE = 1e-9
"""Relative overlap by which rounding may miss a range that is a single point."""

TIE = 1e-7
"""Relative difference of two samples' ends, or two loads', that may be rounding: the first of them counts as the one
that sets the end, so that it does not depend on the solver."""


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
    status: tuple[RangeStatus, ...]
    lower: Array
    upper: Array
    lower_rows: Sequence[tuple[ActiveRow, ...]]
    upper_rows: Sequence[tuple[ActiveRow, ...]]
    conflicts: tuple[Conflict, ...]
    fallbacks: int
    lower_loads: Sequence[LoadPoint] | None = None
    upper_loads: Sequence[LoadPoint] | None = None


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
    if problem.speed is not None:
        raise MrtsError("viscous friction and torque-speed curves have no range yet.")
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
            ends.replace(marginal, find(_widened(problem.at(marginal))))
    for sample in conflicts:
        ends.lower[sample], ends.upper[sample] = np.inf, -np.inf
        ends.lower_rows[sample] = ends.upper_rows[sample] = ()
    return SampleRanges(
        time=time,
        status=statuses(ends.lower, ends.upper, conflicts.values()),
        lower=ends.lower,
        upper=ends.upper,
        lower_rows=tuple(ends.lower_rows),
        upper_rows=tuple(ends.upper_rows),
        conflicts=tuple(conflicts.values()),
        fallbacks=ends.fallbacks,
    )


def statuses(lower: Array, upper: Array, conflicts: Iterable[Conflict]) -> tuple[RangeStatus, ...]:
    """The outcome at every sample.

    Args:
        lower: c²⁻(t), Shape (N,).
        upper: c²⁺(t), Shape (N,).
        conflicts: Of the infeasible samples.
    """
    names = np.array([RangeStatus.FEASIBLE, RangeStatus.EMPTY, RangeStatus.UNBOUNDED, RangeStatus.INFEASIBLE])
    code = np.where(np.isinf(upper), 2, np.where(lower > upper * (1 + POINT_TOLERANCE), 1, 0))
    code[[conflict.sample for conflict in conflicts]] = 3
    return tuple(names[code].tolist())


def first_least(values: Array) -> Any:
    """Place of the least value along the first axis, the first of those that differ by rounding only.

    Args:
        values: Shape (N,), or any with N first: then a place for each column.
    """
    least = np.min(values, axis=0)
    return np.argmax(values <= least + TIE * np.abs(np.where(np.isfinite(least), least, 0.0)), axis=0)


def without_speed_at_rest(problem: SampleProblem, largest: float = 0.0) -> SampleProblem:
    """The same problem with exactly no effect of c² on torques and wrenches where only rounding is left of it.

    Args:
        problem: Rows of some samples.
        largest: Largest effect at other samples of the motion.
    """
    dynamic = ~problem.is_cap
    effect = np.max(np.abs(problem.square[:, dynamic]), axis=1, initial=0.0)
    at_rest = effect <= REST_TOLERANCE * np.max(effect, initial=largest)
    A = problem.A.copy()
    A[:, :, -1] = np.where(at_rest[:, None] & dynamic, 0.0, problem.square)
    return replace(problem, A=A)


def _widened(problem: SampleProblem) -> SampleProblem:
    """The same problem with limits wider by what `find_conflicts` cannot tell from nothing."""
    widening = 2 * CERTIFICATE_TOLERANCE * problem.is_limit
    return replace(problem, lower=problem.lower - widening, upper=problem.upper + widening)
