# SPDX-License-Identifier: MIT
"""MMTSF, the paper's algorithm, whole: range, choice of c², torques."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from types import NoneType
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from mrts.base.argument_types import Progress, check_callable, check_type
from mrts.base.arrays import Array
from mrts.base.errors import InputError, MrtsError
from mrts.base.remark import Remark
from mrts.cell.cell import Cell
from mrts.following.coordinate import coordinate
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import moved_remarks
from mrts.following.grasp_closure import ClosureBound
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.program.excess import BETWEEN, checked_tolerance
from mrts.program.formulation import DistributionName, FormulationName
from mrts.program.infeasibility import Conflict
from mrts.program.load_sharing import LoadSharing, check_distribution
from mrts.program.motion_widening import motion_widening
from mrts.program.range_status import RangeStatus
from mrts.program.rate_limits import Rates, rate_limits
from mrts.program.sample_ranges import POINT_TOLERANCE, SampleRanges
from mrts.program.search import Asked, Refinement, refine
from mrts.program.solvers import DEFAULT_SOLVER, check_solver
from mrts.program.torque_distribution import torque_weights
from mrts.program.trajectory_programs import motion_ranges
from mrts.scaling.chosen_c2 import conflict_at, loads_of
from mrts.scaling.load_study import LoadStudy, load_question
from mrts.scaling.motion_remarks import interpolated, motion_remarks
from mrts.scaling.range import ScalingRange, within_rates
from mrts.scaling.result import END_TOLERANCE, DistributionRule, ScalingResult, kept_text
from mrts.scaling.uncertain_load import range_at_samples
from mrts.scaling.with_torques import ChosenFactor, check_rates

if TYPE_CHECKING:
    from mrts.program.constant_rates import RatedFactors

LARGEST_C2 = 1e300
"""What is asked for beyond it counts as it: Python's whole numbers have no end, floating point has."""


class SelectionError(MrtsError):
    """The requested c² is not in the admissible range, or no single value answers the request.

    Attributes:
        result: The result with the range that was found; None before there is one.
    """

    result: ScalingResult | None = None


Selection = Literal["auto", "fastest", "nominal"] | float


def scale(
    cell: Cell,
    motion: ObjectMotion | JointTable | CoordinatedMotion,
    select: Selection = "auto",
    *,
    sharing: LoadSharing | None = None,
    formulation: FormulationName = "wrench",
    weights: Array | float | None = None,
    solver: str = DEFAULT_SOLVER,
    load: str = "auto",
    distribute: DistributionName = "least-torque",
    reserve: float | None = None,
    closure: ClosureBound | None = None,
    between: float | None = BETWEEN,
    rates: Rates = False,
    progress: Progress = lambda _done, _total: None,
) -> ScalingResult:
    """Find the admissible range of c², choose c² and distribute the torques (steps 1 to 5 of MMTSF).

    Args:
        cell: The cell.
        motion: Motion of the object, a table of joint motion, or motion of the whole cell.
        select: "fastest" takes c²⁺, "nominal" takes 1, a number takes itself; "auto" is "fastest", or "nominal"
            where nothing limits the speed.
        sharing: A fixed distribution of the load; None leaves it to the quadratic program.
        formulation: "wrench", or the paper's "torque".
        weights: W of the quadratic program: None weighs each torque by its limit, diag(1 / τ̂²), so that weak joints are
            spared; 1 weighs all alike, as in the paper; else the diagonal, Shape (m,), or the matrix, Shape (m, m).
        solver: Name in the registry of solvers.
        load: Which range is asked for where the load varies: "guaranteed" (for every load), "possible" (for some
            load), "grid:N" (for N masses), or "nominal". "auto" is "guaranteed" if the cell has a load box. Torques
            are those of the nominal load; "possible" has none, as it leaves open which load it is.
        distribute: What redundant torques are chosen by: "least-torque", or "reserve", which first makes the largest
            share of any limit as small as can be at each sample.
        reserve: Share of every limit that is kept free, 0 or more and below 1; None is the cell's own.
        closure: How far given joints may be off their grasps; None allows 2 mm and 5 mrad.
        between: Share of a limit by which it may be overstepped between the samples; samples are added where it takes
            them. None looks at the given samples alone.
        rates: Whether torques, accelerations and contact wrenches may only change at limited rates: True for the limits
            of the cell, a number for the torque rate of the joints that have none, as a multiple of their torque limit
            [1/s]; docs/real_cell.md. Rates are those between neighbouring samples. The torques are then chosen for the
            whole motion at once, by the least ∫ τᵀWτ dt.
        progress: Told how many of how many pieces of work on an uncertain load are done.

    Returns:
        The outcome. An infeasible motion is an outcome: see `ScalingResult.range`.

    Raises:
        InputError: If an argument breaks a rule.
        MotionError: If the arms cannot follow the object.
        SelectionError: If c² is not in the range; its `result` holds the range.
        SolverError: If no solver answers.
    """
    rule = DistributionRule(sharing, formulation, weights, distribute)
    check_callable("progress", progress)
    asked = factor_question(
        cell, motion, select, rule, solver=solver, load=load, reserve=reserve, closure=closure, between=between,
        rates=rates,
    )  # fmt: skip
    return asked.answer(progress).whole


def factor_question(
    cell: Cell,
    motion: ObjectMotion | JointTable | CoordinatedMotion,
    select: Selection,
    rule: DistributionRule,
    *,
    solver: str,
    load: str,
    reserve: float | None,
    closure: ClosureBound | None,
    between: float | None,
    rates: Rates,
) -> "FactorQuestion":
    """What `scale` asks, with arms that follow the object and all arguments checked; nothing is answered yet.

    Args:
        cell: As in `scale`.
        motion: Likewise.
        select: Likewise.
        rule: How torques are to be distributed, rates apart.
        solver: As in `scale`.
        load: Likewise.
        reserve: Likewise.
        closure: Likewise.
        between: Likewise.
        rates: Likewise.

    Raises:
        InputError: If an argument breaks a rule.
        MotionError: If the arms cannot follow the object.
    """
    check_type("cell", cell, Cell)
    _check_select(select)
    check_type("sharing", rule.sharing, LoadSharing, NoneType)
    check_distribution(rule.distribute, rule.sharing)
    cell = cell if reserve is None else cell.with_reserve(reserve)
    check_type("formulation", rule.formulation, str)
    check_solver(solver)
    question = load_question(cell, load, select)
    torque_weights(rule.weights, cell)
    tolerance = checked_tolerance(between)
    rule = rule if rates is False else replace(rule, rates=rate_limits(cell, rates))
    check_rates(rule, question)
    given = coordinate(cell, motion, closure)
    return FactorQuestion(
        cell=cell, motion=given, select=select, rule=rule, solver=solver, question=question, tolerance=tolerance
    )


@dataclass(frozen=True, kw_only=True)
class FactorQuestion:
    """What is asked of a motion at a constant factor of speed, checked.

    Attributes:
        cell: The cell, with the reserve that it keeps.
        motion: Of the whole cell, as given.
        select: As in `scale`.
        rule: How torques are distributed.
        solver: As in `scale`.
        question: As from `load_question`.
        tolerance: Share of a limit by which it may be overstepped between the samples; None for the bare samples.
    """

    cell: Cell
    motion: CoordinatedMotion
    select: Selection
    rule: DistributionRule
    solver: str
    question: str
    tolerance: float | None

    def answer(self, progress: Progress = lambda _done, _total: None) -> ChosenFactor:
        """Steps 1 to 3 of MMTSF: `scale` before the torques are distributed.

        Args:
            progress: As in `scale`.

        Raises:
            MotionError: If the arms cannot hold the object between the samples.
            SelectionError: If c² is not in the range; its `result` holds the range.
            SolverError: If no solver answers.
        """
        cell, given, rule, own = self.cell, self.motion, self.rule, self.motion.object.time
        found = admissible_range(cell, given, self.question, rule, self.solver, self.tolerance, progress)
        found, factors = within_rate_limits(cell, found, rule, self.question, self.solver)
        remarks = motion_remarks(cell, given, found.range)
        remarks = remarks and moved_remarks(remarks, own, np.setdiff1d(found.motion.object.time, own))
        untouched = ScalingResult(
            cell=cell,
            motion=found.motion,
            found=found.range,
            trajectory=None,
            fallbacks=found.range.samples.fallbacks,
            load=found.study,
            rule=rule,
            warnings=remarks + found.remarks,
        )
        if not found.range.status.admits_motion or self.question == "possible":
            return ChosenFactor(untouched, None)
        try:
            c2 = choose_c2(found.range, self.select, partial(self._conflict, found))
            _check_rated(factors, found.range, c2)
        except SelectionError as error:
            refused = SelectionError(f"{kept_text(cell.reserve)}{error}")
            refused.result = untouched
            raise refused from None
        excess = None if found.refinement is None else found.refinement.excess(c2)
        return ChosenFactor(replace(untouched, excess=excess), c2, self.solver)

    def _conflict(self, found: "AdmissibleRange", c2: float) -> Conflict | None:
        return conflict_at(self.cell, found.motion, self.rule, c2, loads_of(found.study), self.solver)

    @cached_property
    def factor(self) -> ChosenFactor:
        """The answer, found when it is first read; without a c² where none moves the object.

        Raises:
            MotionError: As `answer`.
            SolverError: Likewise.
        """
        try:
            return self.answer()
        except SelectionError as error:
            if error.result is None:
                raise
            return ChosenFactor(error.result, None)


@dataclass(frozen=True)
class AdmissibleRange:
    """The range of c² of a motion, and the motion with the samples that it took.

    Attributes:
        motion: With the samples that were added.
        range: Over them.
        study: What was asked of an uncertain load; None if the load is known.
        refinement: What was found between the samples; None if that was not looked at.
        remarks: What to know of the samples that were added.
    """

    motion: CoordinatedMotion
    range: ScalingRange
    study: LoadStudy | None
    refinement: Refinement | None = None
    remarks: tuple[Remark, ...] = ()


def admissible_range(
    cell: Cell,
    motion: CoordinatedMotion,
    question: str,
    rule: DistributionRule,
    solver: str,
    tolerance: float | None,
    progress: Progress = lambda _done, _total: None,
) -> AdmissibleRange:
    """The range of c² of a motion (steps 1 and 2 of MMTSF), between its samples too.

    Args:
        cell: The cell.
        motion: Its motion.
        question: As from `load_question`; of "possible" only the given samples are looked at.
        rule: How torques are distributed; with an internal wrench for each sample, only these are looked at.
        solver: Name in the registry.
        tolerance: Share of a limit by which it may be overstepped between the samples; None for the bare samples.
        progress: As in `scale`.

    Raises:
        InputError: If an argument breaks a rule.
        MotionError: If the arms cannot hold the object between the samples.
        SolverError: If no solver answers.
    """
    sharing, formulation = rule.sharing, rule.formulation

    def along(path: CoordinatedMotion, told: Progress, high: float = np.inf) -> tuple[ScalingRange, LoadStudy | None]:
        return range_at_samples(cell, path, question, formulation, sharing, solver, told, high)

    def widening(path: CoordinatedMotion, places: NDArray[np.intp], loads: Array | None, c2: Array) -> Array:
        return motion_widening(cell, path, c2, formulation=formulation, sharing=sharing, load=loads, samples=places)

    found, study = along(motion, progress)
    prescribed = sharing is not None and sharing.internal_wrench is not None and np.ndim(sharing.internal_wrench) > 1
    if tolerance is None or question == "possible" or prescribed or not found.status.admits_motion:
        return AdmissibleRange(motion, found, study)

    assert found.lower is not None and found.upper is not None  # noqa: S101, PT018 (the range admits motion)
    high = found.upper.c2

    def ranges(path: CoordinatedMotion) -> SampleRanges:
        if question == "nominal":
            return motion_ranges(cell, path, formulation, sharing, solver, None, high)
        return along(path, lambda _done, _total: None, high)[0].samples

    asked = Asked(ranges, widening)
    refined = refine(cell, motion, found.samples, (found.lower.c2, high), asked, tolerance)
    if refined.motion is motion:
        return AdmissibleRange(motion, found, study, refined)
    finer, study = along(refined.motion, progress)
    return AdmissibleRange(refined.motion, finer, study, refined, interpolated(motion, found, finer))


def within_rate_limits(
    cell: Cell, found: AdmissibleRange, rule: DistributionRule, question: str, solver: str
) -> tuple[AdmissibleRange, "RatedFactors | None"]:
    """What limits of rates leave of a range for all loads that were asked about, and what they admit; None without.

    Args:
        cell: The cell.
        found: The range, rates apart.
        rule: With the limits, if there are any.
        question: As from `load_question`.
        solver: Name in the registry.
    """
    if rule.rates is None or not found.range.status.admits_motion:
        return found, None
    from mrts.program.constant_rates import RatedFactors  # noqa: PLC0415 (scipy is not needed otherwise)

    def below(high: float) -> ScalingRange:
        return range_at_samples(
            cell, found.motion, question, rule.formulation, rule.sharing, solver, high=high * (1 + POINT_TOLERANCE)
        )[0]

    points = loads_of(found.study)
    loads = [None if point is None else point.load for point in points]
    factors = RatedFactors(cell, found.motion, loads, rule.sharing, rule.rates)
    return replace(found, range=within_rates(found.range, factors, below, points)), factors


def _check_rated(factors: "RatedFactors | None", found: ScalingRange, c2: float) -> None:
    """That rates admit a c² between the ends of the range: they may leave gaps."""
    ends = {end.c2 for end in (found.lower, found.upper) if end is not None}
    refused = None if factors is None or c2 in ends else factors.refused(c2)
    if refused is not None:
        rows = ", ".join(str(row) for row in refused.rows)
        raise SelectionError(
            f"c² = {c2:g} lies in a gap that rates leave in the admissible range {found.text(digits=6)}: at "
            f"t = {found.samples.time[refused.sample]:.4g} s {rows} would be passed."
        )


def _check_select(select: object) -> None:
    known = select in {"auto", "fastest", "nominal"} if isinstance(select, str) else isinstance(select, int | float)
    if not known or isinstance(select, bool):
        raise InputError("select", "must be 'auto', 'fastest', 'nominal' or a number.", value=select)


def choose_c2(
    found: ScalingRange, select: Selection, conflict: Callable[[float], Conflict | None] = lambda _c2: None
) -> float:
    """Step 3.1 of MMTSF: choose c² in an admissible range.

    Args:
        found: A range that admits motion.
        select: As in `scale`.
        conflict: What forbids a c²; only asked of one below the range where a sample admits several intervals.

    Raises:
        SelectionError: If the value is not admissible, not finite, or not above 0.
    """
    assert found.lower is not None and found.upper is not None  # noqa: S101, PT018 (the range admits motion)
    high, interval = found.upper.c2, found.text(digits=6)
    unlimited = found.status is RangeStatus.UNBOUNDED
    if select == "auto":
        select = "nominal" if unlimited else "fastest"
    if select == "fastest":
        if unlimited:
            raise SelectionError(f"no limit depends on the speed: c² ∈ {interval}. Choose a value.")
        if high <= 0:
            still = f"c² ∈ {interval}: the cell can only hold still. The upper end is set {found.upper.place()}."
            raise SelectionError(still)
        return high
    c2 = 1.0 if select == "nominal" else float(max(min(select, LARGEST_C2), -LARGEST_C2))
    if not (np.isfinite(c2) and c2 > 0):
        raise SelectionError(f"c² = {c2:g} is no speed: it must be finite and > 0. Admissible: {interval}.")
    if (admitted := found.admitted(c2, END_TOLERANCE)) is not None:
        return admitted
    side, end = ("lower", found.lower) if c2 < found.lower.c2 else ("upper", found.upper)
    outside = f"c² = {c2:g} is outside the admissible range {interval}"
    if side == "lower" and found.samples.several:
        worst = conflict(c2)
        if worst is None:
            return c2
        load = "" if worst.load is None else f" with {worst.load}"
        rows = "; ".join(str(row) for row in worst.rows)
        raise SelectionError(
            f"{outside}, and no slower one admits it: at t = {worst.time:.4g} s{load} {rows} forbid it."
        )
    raise SelectionError(f"{outside}. The {side} end is set {end.place()}.")
