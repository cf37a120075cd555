# SPDX-License-Identifier: MIT
"""The admissible range of c² at every sample: by the compiled kernel in one call, or from rows for another solver."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import SolverError
from mrts.base.load_box import LoadPoint
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.programs import OPTIMAL
from mrts.limits.rows import STANDSTILL, ActiveRow, RowName, Side
from mrts.program.infeasibility import CERTIFICATE_TOLERANCE, Conflict, find_conflicts
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.range_ends import (
    RangeEnds,
    ends_of_problem,
    intervals_below,
    kernel_ends,
    rows_at_end,
    unknown_ends,
    with_caps,
)
from mrts.program.range_status import RangeStatus
from mrts.program.sample_problem import BLOCK, SampleProblem, build_sample_problem
from mrts.program.solvers import DEFAULT_SOLVER

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
        ends = {"c2_lower": self.lower, "c2_upper": self.upper}
        return {
            "time": self.time.tolist(),
            "status": [status.value for status in self.status],
            **{name: [c2 if np.isfinite(c2) else None for c2 in values.tolist()] for name, values in ends.items()},
        }


def motion_ranges(rows: MotionRows, load: Array | None = None, high: float = np.inf) -> SampleRanges:
    """Least and largest c² at every sample (step 1 of MMTSF), by the compiled path where it applies.

    A load stands instead of the cell's, Shape (10,). Of several intervals it is the
    highest that does not begin above `high`.
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
    ends, conflicts = with_caps(ends, rows.is_cap, rows.cap_share, rows.rows.square), []
    for start in range(0, len(suspects), BLOCK):
        block = suspects[start : start + BLOCK]
        problem = without_speed_at_rest(build_sample_problem(rows, load=load, samples=block), effect)
        conflicts += decide(ends, block, problem, time, high)
    return _ranges(time, ends, conflicts, (rows.given.names, rows.given.lower, rows.given.upper), asked)


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
