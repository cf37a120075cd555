# SPDX-License-Identifier: MIT
"""The admissible range of c² at every sample."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.load_box import LoadPoint
from mrts.base.notebook.in_notebooks import InNotebooks
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import ActiveRow, Side
from mrts.samples.closed_form import ends_in_closed_form
from mrts.samples.end_rows import RowsAtEnd, RowsExcept, RowsOfEnds, RowsWithEnd
from mrts.samples.infeasibility import CERTIFICATE_TOLERANCE, Conflict, find_conflicts
from mrts.samples.linear_programs import ends_by_linear_programs
from mrts.samples.range_ends import Gap, Piece, RangeEnds, gaps_between, gaps_of, pieces, require_decided
from mrts.samples.range_status import RangeStatus
from mrts.samples.sample_problem import SampleProblem, build_sample_problem
from mrts.samples.speed_intervals import speed_intervals

REST_TOLERANCE = 1e-12
"""A sample is at rest where c² moves no row by more than this share of what it does elsewhere."""

POINT_TOLERANCE = 1e-9
"""Relative overlap by which rounding may miss a range that is a single point."""

TIE = 1e-7
"""Relative difference of two samples' ends, or two loads', that may be rounding: the first of them counts as the one
that sets the end, so that it does not depend on the solver."""


@dataclass(frozen=True)
class SampleRanges(InNotebooks):
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
        gaps: What samples do not admit between their ends, in order; none where no row has a term in ṙ beside others.
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
    gaps: tuple[Gap, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Entry of "samples" in the JSON result; null stands for an end that does not exist."""
        ends = {"c2_lower": self.lower, "c2_upper": self.upper}
        return {
            "time": self.time.tolist(),
            "status": [status.value for status in self.status],
            **{name: [c2 if np.isfinite(c2) else None for c2 in values.tolist()] for name, values in ends.items()},
            "gaps": [
                {"sample": gap.sample, "time": float(self.time[gap.sample]), "c2": [gap.lower, gap.upper]}
                for gap in self.gaps
            ],
        }


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
    if problem.speed is not None:
        return _union_ranges(problem, time, solver)

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
        lower_rows=ends.lower_rows,
        upper_rows=ends.upper_rows,
        conflicts=tuple(conflicts.values()),
        fallbacks=ends.fallbacks,
    )


def _union_ranges(problem: SampleProblem, time: Array, solver: str) -> SampleRanges:
    """`sample_ranges` where rows have a term in ṙ: the ends of a union of intervals, and the gaps between them."""
    found = speed_intervals(problem, solver)
    suspects = np.flatnonzero(found.undecided)
    conflicts = [one for one in find_conflicts(problem, time, suspects, solver) if one] if suspects.size else []
    proved = {conflict.sample for conflict in conflicts}
    marginal = np.array([sample for sample in suspects if sample not in proved], dtype=int)
    if marginal.size:
        again = speed_intervals(_widened(problem.at(marginal)), solver)
        require_decided(marginal, again.undecided)
        found.fallbacks += again.fallbacks
        for sample, intervals in zip(marginal.tolist(), again.intervals, strict=True):
            found.intervals[sample] = intervals

    def rows(sample: int, c2: float, end: Side) -> RowsAtEnd:
        return RowsAtEnd(partial(problem.at, np.array([sample])), c2, end)

    lower = np.array([one[0][0] ** 2 if one else np.inf for one in found.intervals])
    upper = np.array([one[-1][1] ** 2 if one else -np.inf for one in found.intervals])
    return SampleRanges(
        time=time,
        status=statuses(lower, upper, conflicts),
        lower=lower,
        upper=upper,
        lower_rows=RowsOfEnds(tuple(rows(sample, c2, "lower") for sample, c2 in enumerate(lower.tolist()))),
        upper_rows=RowsOfEnds(tuple(rows(sample, c2, "upper") for sample, c2 in enumerate(upper.tolist()))),
        conflicts=tuple(conflicts),
        fallbacks=found.fallbacks,
        gaps=tuple(gap for sample, one in enumerate(found.intervals) for gap in gaps_of(sample, one, rows)),
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


def with_gaps(samples: SampleRanges, gaps: Mapping[int, Sequence[Gap]]) -> SampleRanges:
    """The same ranges without what gaps take away: in their middle, or at their ends.

    Args:
        samples: Ranges without gaps, as of several loads.
        gaps: By sample, of several loads; they may overlap and reach beyond the ends.
    """
    lower, upper, kept = samples.lower.copy(), samples.upper.copy(), list(samples.gaps)
    rows: tuple[dict[int, tuple[ActiveRow, ...]], ...] = ({}, {})
    loads = [None if of is None else list(of) for of in (samples.lower_loads, samples.upper_loads)]
    for sample in sorted(gaps):
        if not lower[sample] <= upper[sample]:
            continue
        left = pieces(float(lower[sample]), float(upper[sample]), gaps[sample])
        if not left:  # the last gap ends above what is asked for
            last = max(gaps[sample], key=lambda gap: gap.upper)
            left = [Piece(last.upper, float(upper[sample]), last, None)]
        kept += gaps_between(left, sample)
        first, final = left[0].after, left[-1].before
        if first is not None:
            lower[sample], rows[0][sample] = first.upper, tuple(first.upper_rows)
            _put(loads[0], sample, first.upper_load)
        if final is not None:
            upper[sample], rows[1][sample] = final.lower, tuple(final.lower_rows)
            _put(loads[1], sample, final.lower_load)
    return replace(
        samples,
        status=statuses(lower, upper, samples.conflicts),
        lower=lower,
        upper=upper,
        lower_rows=RowsExcept(samples.lower_rows, rows[0]),
        upper_rows=RowsExcept(samples.upper_rows, rows[1]),
        lower_loads=None if loads[0] is None else tuple(loads[0]),
        upper_loads=None if loads[1] is None else tuple(loads[1]),
        gaps=tuple(kept),
    )


def _put(loads: list[LoadPoint] | None, sample: int, load: LoadPoint | None) -> None:
    if loads is not None and load is not None:
        loads[sample] = load


def with_end_rows(
    cell: Cell, motion: CoordinatedMotion, samples: SampleRanges, load_at: Callable[[int, Side], Array | None]
) -> SampleRanges:
    """The same ranges, which name all rows that set the ends over the motion.

    Args:
        cell: The cell; the distribution of its load is free.
        motion: Its motion.
        samples: Ranges of all samples.
        load_at: Load vector of one end of a sample, Shape (10,); None for the cell's.
    """
    if len(cell.robots) == 1:
        return samples  # nothing is free: the closed form names all

    def rows(side: Side, ends: Array, given: Sequence[tuple[ActiveRow, ...]], sample: int) -> RowsWithEnd:
        load = load_at(sample, side)
        loads = None if load is None else np.broadcast_to(load, (motion.samples, len(load)))
        one = partial(build_sample_problem, cell, motion, load=loads, samples=np.array([sample]))
        return RowsWithEnd(given, sample, RowsAtEnd(one, float(ends[sample]), side))

    return replace(
        samples,
        lower_rows=rows("lower", samples.lower, samples.lower_rows, int(first_least(-samples.lower))),
        upper_rows=rows("upper", samples.upper, samples.upper_rows, int(first_least(samples.upper))),
    )


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
    widening = 2 * CERTIFICATE_TOLERANCE * problem.is_limit
    return replace(problem, lower=problem.lower - widening, upper=problem.upper + widening)
