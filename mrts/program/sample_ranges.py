# SPDX-License-Identifier: MIT
"""The admissible range of c² at every sample."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import SolverError
from mrts.base.load_box import LoadPoint
from mrts.kernel.programs import OPTIMAL
from mrts.limits.rows import ActiveRow, Side
from mrts.program.infeasibility import CERTIFICATE_TOLERANCE, Conflict, find_conflicts
from mrts.program.motion_rows import binds
from mrts.program.range_ends import (
    BindingRows,
    RangeEnds,
    codes_of_duals,
    ends_by_linear_programs,
    ends_in_closed_form,
    highest_intervals,
    intervals_below,
    no_codes,
    rows_at_end,
    rows_of_problem,
    tight_codes,
)
from mrts.program.range_status import RangeStatus
from mrts.program.sample_problem import SampleProblem

REST_TOLERANCE = 1e-12
"""A sample is at rest where c² moves no row by more than this share of what it does elsewhere."""

POINT_TOLERANCE = 1e-9
"""Relative overlap by which rounding may miss a range that is a single point."""

TIE = 1e-7
"""Relative difference of two samples' ends, or two loads', that may be rounding: the first of them counts as the one
that sets the end, so that it does not depend on the solver."""


@dataclass(frozen=True)
class SampleRanges:
    """The least and the largest c² of each of N samples: of the highest interval where a sample admits several.

    Attributes:
        time: Of the given motion, Shape (N,) [s].
        status: Shape (N,).
        lower: c²⁻(t), Shape (N,); infinity where infeasible.
        upper: c²⁺(t), Shape (N,); minus infinity where infeasible, infinity where unbounded.
        rows: Which rows bind at both ends of each sample.
        conflicts: One for each infeasible sample, in order.
        fallbacks: Programs that the chosen solver did not solve and another did.
        lower_loads: If the load is uncertain, the load that sets the lower end of each sample.
        upper_loads: Likewise of the upper end.
        several: Whether some sample admits other intervals of c² as well.
        problem: The rows of one sample, with a load if the load is uncertain; None where `rows` has all that bind.
    """

    time: Array
    status: tuple[RangeStatus, ...]
    lower: Array
    upper: Array
    rows: BindingRows
    conflicts: tuple[Conflict, ...]
    fallbacks: int
    lower_loads: Sequence[LoadPoint] | None = None
    upper_loads: Sequence[LoadPoint] | None = None
    several: bool = False
    problem: Callable[[int, Array | None], SampleProblem] | None = field(default=None, repr=False, compare=False)

    def binding(self, sample: int, side: Side) -> tuple[ActiveRow, ...]:
        """Rows that bind at one end of a sample; where more meet than determine it, some of them."""
        return self.rows.at(sample, side)

    def all_binding(self, sample: int, side: Side) -> tuple[ActiveRow, ...]:
        """All rows that bind at one end of a sample.

        Raises:
            SolverError: If no solver answers.
        """
        c2 = float((self.lower if side == "lower" else self.upper)[sample])
        if self.problem is None or not np.isfinite(c2) or (side == "lower" and c2 == 0):
            return self.binding(sample, side)
        loads = self.lower_loads if side == "lower" else self.upper_loads
        problem = self.problem(sample, None if loads is None else loads[sample].load)
        return rows_at_end(problem, c2, side) or self.binding(sample, side)

    def to_json(self) -> dict[str, Any]:
        """Entry of "samples" in the JSON result; null stands for an end that does not exist."""
        ends = {"c2_lower": self.lower, "c2_upper": self.upper}
        return {
            "time": self.time.tolist(),
            "status": [status.value for status in self.status],
            **{name: [c2 if np.isfinite(c2) else None for c2 in values.tolist()] for name, values in ends.items()},
        }


def sample_ranges(problem: SampleProblem, time: Array, solver: str, high: float = np.inf) -> SampleRanges:
    """Step 1 of MMTSF: min and max of c² at every sample, with binding rows.

    One unknown (a fixed distribution, a single arm) is an intersection of intervals; more are linear programs.

    Args:
        problem: Rows along the motion.
        time: Shape (N,) [s].
        solver: Name in the registry.
        high: Of several intervals the highest is found that does not begin above this c².

    Raises:
        InputError: If there is no such solver.
        SolverError: If no solver answers.
    """
    return ranges_of_ends(time, *decided_ends(problem, time, solver, high))


def decided_ends(
    problem: SampleProblem, time: Array, solver: str, high: float, effect: float | None = None
) -> tuple[RangeEnds, list[Conflict]]:
    """`sample_ranges` as ends, and the conflicts of the samples that have none.

    Where the largest effect of c² at other samples is given, these are doubtful: whether they are infeasible is looked
    at first.
    """
    doubtful = effect is not None
    problem = without_speed_at_rest(problem, effect or 0.0)
    none, samples = np.full(problem.samples, np.inf), np.arange(problem.samples)
    ends = RangeEnds(none, -none, rows_of_problem(problem, no_codes(len(samples))), np.ones(len(samples), dtype=bool))
    if not doubtful:
        ends.replace(samples, _ends(problem, solver, high))
    conflicts: list[Conflict] = []
    if np.any(ends.undecided):
        found = find_conflicts(problem, time, np.flatnonzero(ends.undecided), solver)
        conflicts = [conflict for conflict in found if conflict is not None]
    infeasible = np.array([conflict.sample for conflict in conflicts], dtype=int)
    ends.lower[infeasible], ends.upper[infeasible], ends.undecided[infeasible] = np.inf, -np.inf, False
    ends.rows = ends.rows.with_samples(infeasible, no_codes(len(infeasible)))
    for widen in (False, True) if doubtful else (True,):
        left = np.flatnonzero(ends.undecided)
        if left.size:
            part = problem.at(left)
            ends.replace(left, _ends(_widened(part) if widen else part, solver, high))
            ends.lower[left] = np.minimum(ends.lower[left], ends.upper[left])
    if np.any(ends.undecided):
        raise SolverError(
            f"no solver found the range of c² at t = {time[np.argmax(ends.undecided)]:.6g} s, although its limits hold "
            "together. This is a defect of mrts or of extremely scaled data: please report the cell and the motion."
        )
    return ends, conflicts


def ranges_of_ends(time: Array, ends: RangeEnds, conflicts: Sequence[Conflict], **loads: Any) -> SampleRanges:
    """The ranges with these ends; `loads` are `lower_loads` and `upper_loads`."""
    return SampleRanges(
        time=time,
        status=statuses(ends.lower, ends.upper, conflicts),
        lower=ends.lower,
        upper=ends.upper,
        rows=ends.rows,
        conflicts=tuple(conflicts),
        fallbacks=ends.fallbacks,
        several=ends.several,
        **loads,
    )


def _ends(problem: SampleProblem, solver: str, high: float) -> RangeEnds:
    if problem.speed is None:
        return ends_in_closed_form(problem) if problem.unknowns == 1 else ends_by_linear_programs(problem, solver)
    found, several = intervals_below(partial(highest_intervals, problem), np.full(problem.samples, np.inf), high)
    if problem.unknowns == 1:
        codes = tight_codes(problem, found.lower, found.upper)
    else:
        low, top = found.dual.copy()
        caps, capped = problem.is_cap, found.upper >= problem.cap() * (1 - POINT_TOLERANCE)
        top[:, caps] = capped[:, None] * binds(problem.cap_share) * np.sign(problem.square[:, caps])
        codes = np.stack([codes_of_duals(low, found.lower == 0), codes_of_duals(problem, top)])
    rows = rows_of_problem(problem, codes)
    return RangeEnds(found.lower, found.upper, rows, found.status[0] != OPTIMAL, 0, several)


def statuses(lower: Array, upper: Array, conflicts: Iterable[Conflict]) -> tuple[RangeStatus, ...]:
    """The outcome at every sample."""
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
        largest: Largest effect of c², or of c squared, at other samples of the motion.
    """
    dynamic, speed = ~problem.is_cap, problem.speed
    effect = np.max(np.abs(problem.square[:, dynamic]), axis=1, initial=0.0)
    if speed is not None:
        effect = np.maximum(effect, np.max(np.abs(speed[:, dynamic]), axis=1, initial=0.0) ** 2)
    at_rest = effect <= REST_TOLERANCE * np.max(effect, initial=largest)
    A, still = problem.A.copy(), at_rest[:, None] & dynamic
    A[:, :, -1] = np.where(still, 0.0, problem.square)
    return replace(problem, A=A, speed=None if speed is None else np.where(still, 0.0, speed))


def _widened(problem: SampleProblem) -> SampleProblem:
    """The same problem with limits wider by what `find_conflicts` cannot tell from nothing."""
    widening = 2 * CERTIFICATE_TOLERANCE
    return replace(problem, lower=problem.lower - widening, upper=problem.upper + widening)
