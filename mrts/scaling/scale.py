# SPDX-License-Identifier: MIT
"""MMTSF, the paper's algorithm, whole: range, choice of c², torques."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mrts.base.argument_types import Progress, check_callable, check_type
from mrts.base.arrays import Array
from mrts.base.errors import InputError, MrtsError, SolverError
from mrts.base.remark import Remark
from mrts.base.words import first_names
from mrts.cell.cell import Cell
from mrts.following.coordinate import coordinate
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import moved_remarks
from mrts.following.grasp_closure import ClosureBound
from mrts.limits import Limit
from mrts.limits.rows import rows_text
from mrts.motion.joint_table import NO_SPEED, JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.rows_at_rest import pushing_ends
from mrts.program.between_samples import Refinement, refine
from mrts.program.excess import BETWEEN
from mrts.program.formulation import DistributionName, FormulationName
from mrts.program.infeasibility import Conflict, conflicts_at
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows
from mrts.program.range_status import RangeStatus
from mrts.program.rate_limits import Rates, rate_limits
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import POINT_TOLERANCE, SampleRanges, motion_ranges
from mrts.program.solvers import DEFAULT_SOLVER, check_solver
from mrts.program.torque_distribution import TORQUE_WIDENING, motion_torques, torque_weights
from mrts.program.widening import motion_widening
from mrts.scaling.limit_use import LimitUse, limit_uses, power_uses, rate_uses
from mrts.scaling.loads import range_at_samples
from mrts.scaling.motion_remarks import interpolated, motion_remarks
from mrts.scaling.options import Options, Selection, limited_cell
from mrts.scaling.range import ScalingRange
from mrts.scaling.result import END_TOLERANCE, LIMIT_TOLERANCE, ScalingResult, kept_text, largest_excess
from mrts.scaling.scaled_trajectory import Holding, ScaledTrajectory

if TYPE_CHECKING:
    from mrts.scaling.constant_rates import RatedFactors


EXCEEDS_RATED_TORQUE = "above-rated"
"""Code of the remark on torques that a motor does not bear for ever."""

EXCEEDS_POWER = "above-power"
"""Code of the remark on power above that of the motors, or of their supply: reported only."""

EXCEEDS_RATE_LIMIT = "rate-passed"
"""Code of the remark on rates that pass their limit, which nothing keeps."""

EXCEEDS_VELOCITY = "velocity-passed"
"""Code of the remark on velocities above limits that are not enforced."""

STEPS = "step-at-ends"
"""Code of the remark on torques that must jump where a motion starts or ends, whatever its speed."""

OF_TORQUES = (EXCEEDS_RATED_TORQUE, EXCEEDS_POWER, EXCEEDS_RATE_LIMIT, EXCEEDS_VELOCITY, STEPS)
"""Codes of remarks that are found again with other torques."""

RATE_TOLERANCE = 1e-6
"""Share by which a rate may pass its limit before it is told: rounding, of differences of neighbouring samples."""

NAMED = 3
"""Further joints that it names."""


class SelectionError(MrtsError):
    """The requested c² is not in the admissible range, or no single value answers the request.

    Attributes:
        result: The result with the range that was found; None before there is one.
    """

    def __init__(self, message: str, result: ScalingResult | None = None) -> None:
        super().__init__(message)
        self.result = result


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
    limits: Sequence[Limit] | None = None,
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
        limits: Functions of a cell and its motion that give further `mrts.limits.rows.LimitRows`, as in
            `Cell.with_limits`; docs/extending.md. None is the cell's own.
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
    check_callable("progress", progress)
    check_type("cell", cell, Cell)
    cell = limited_cell(cell, reserve, limits)
    options = Options(
        select=select,
        sharing=sharing,
        formulation=formulation,
        weights=weights,
        solver=solver,
        load=load,
        distribute=distribute,
        between=between,
        rates=None if rates is False else rate_limits(cell, rates),
    ).checked(cell)
    given = coordinate(cell, motion, closure)
    if given.untimed:
        raise InputError("motion", NO_SPEED)
    chosen, rows = chosen_factor(cell, given, options, progress)
    return with_torques(chosen, rows=rows)


def chosen_factor(
    cell: Cell,
    motion: CoordinatedMotion,
    options: Options,
    progress: Progress = lambda _done, _total: None,
) -> tuple[ScalingResult, MotionRows]:
    """Steps 1 to 3 of MMTSF, `scale` before the torques are distributed: the result, and the limits along its motion.

    Raises:
        MotionError: If the arms cannot hold the object between the samples.
        SelectionError: If c² is not in the range; its `result` holds the range.
        SolverError: If no solver answers.
    """
    result, rows, refinement = admissible_range(cell, motion, options, progress)
    result, factors = within_rate_limits(result, rows)
    found = result.range
    remarks, own = motion_remarks(cell, motion, found), motion.object.time
    remarks = remarks and moved_remarks(remarks, own, np.setdiff1d(result.motion.object.time, own))
    result = replace(result, warnings=remarks + result.warnings)
    if not found.status.admits_motion or options.load == "possible":
        return result, rows
    try:
        c2 = choose_c2(found, options.select, partial(conflict_at, result))
        if factors is not None:
            _check_rated(factors, found, c2)
    except SelectionError as error:
        raise SelectionError(f"{kept_text(cell.reserve)}{error}", result) from None
    return replace(result, c2=c2, excess=None if refinement is None else refinement.excess(c2)), rows


def admissible_range(
    cell: Cell,
    motion: CoordinatedMotion,
    options: Options,
    progress: Progress = lambda _done, _total: None,
) -> tuple[ScalingResult, MotionRows, Refinement | None]:
    """The range of c² of a motion, rates apart (steps 1 and 2 of MMTSF), between its samples too.

    For what is possible with some load, and with an internal wrench a sample, only the given samples are looked at.

    Returns:
        A result without a c², of the motion with the samples that were added, the limits along it, and what was found
        between the samples; None if that was not looked at.

    Raises:
        InputError, MotionError, SolverError: As `scale`.
    """
    rows = options.rows(cell, motion)
    found, study = range_at_samples(rows, options, progress)
    refined, warnings = None, tuple[Remark, ...]()
    prescribed = options.sharing is not None and options.sharing.varies
    if options.between is not None and options.load != "possible" and not prescribed and found.status.admits_motion:
        assert found.lower is not None and found.upper is not None  # noqa: S101, PT018 (the range admits motion)
        ends = found.lower.c2, found.upper.c2

        def ranges(there: MotionRows) -> SampleRanges:
            if options.load == "nominal":
                return motion_ranges(there, options.solver, None, ends[1])
            return range_at_samples(there, options, high=ends[1])[0].samples

        refined = refine(rows, found.samples, ends, ranges, options.between)
        if refined.motion is not motion:
            given, rows = found, rows.along(refined.motion)
            found, study = range_at_samples(rows, options, progress)
            warnings = interpolated(motion, given, found)
    result = ScalingResult(
        cell=cell,
        motion=rows.motion,
        found=found,
        c2=None,
        trajectory=None,
        fallbacks=found.samples.fallbacks,
        load=study,
        options=options,
        warnings=warnings,
    )
    return result, rows, refined


def within_rate_limits(result: ScalingResult, rows: MotionRows) -> tuple[ScalingResult, "RatedFactors | None"]:
    """What limits of rates leave of a range for all loads that were asked about, and what they admit; None without.

    The rows are those of the result's motion.
    """
    options, found = result.options, result.range
    if options.rates is None or not found.status.admits_motion:
        return result, None
    from mrts.scaling.constant_rates import RatedFactors  # noqa: PLC0415 (scipy is not needed otherwise)

    def below(high: float) -> ScalingRange:
        return range_at_samples(rows, options, high=high * (1 + POINT_TOLERANCE))[0]

    factors = RatedFactors(rows, result.loads, options.rates)
    return replace(result, found=factors.within(found, below)), factors


def _check_rated(factors: "RatedFactors", found: ScalingRange, c2: float) -> None:
    ends = {end.c2 for end in (found.lower, found.upper) if end is not None}
    refused = None if c2 in ends else factors.refused(c2)
    if refused is not None:
        raise SelectionError(
            f"c² = {c2:g} lies in a gap that rates leave in the admissible range {found.text(digits=6)}: at "
            f"t = {refused.time:.4g} s {rows_text(refused.rows)} would be passed."
        )


def conflict_at(result: ScalingResult, c2: float) -> Conflict | None:
    """What forbids a c², at the sample where limits would have to move outward the most; None if nothing does.

    There all rows are linear, and no interval has to be known.
    """
    motion, worst = result.motion, None
    rows = result.options.rows(result.cell, motion)
    for point in result.loads:
        load = None if point is None else point.load
        share = motion_widening(rows, np.full(motion.samples, c2), load)
        sample = np.array([np.argmax(share)])
        problem = build_sample_problem(rows, load=load, samples=sample)
        (found,) = conflicts_at(problem, np.array([c2]), motion.object.time[sample], result.options.solver)
        if found is not None and (worst is None or found.widening > worst.widening):
            worst = replace(found, sample=int(sample[0]), load=point, c2=c2)
    return worst


def choose_c2(
    found: ScalingRange, select: Selection, conflict: Callable[[float], Conflict | None] = lambda _c2: None
) -> float:
    """Step 3.1 of MMTSF: choose c² in an admissible range.

    `conflict` tells what forbids a c²: asked of one below the range where a sample admits several intervals.

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
    given = 1.0 if isinstance(select, str) else select
    too_large = abs(given) > sys.float_info.max  # Python's whole numbers have no end
    c2 = float("inf" if given > 0 else "-inf") if too_large else float(given)
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
        raise SelectionError(
            f"{outside}, and no slower one admits it: at t = {worst.time:.4g} s{load} {rows_text(worst.rows, '; ')} "
            "forbid it."
        )
    raise SelectionError(f"{outside}. The {side} end is set {end.place()}.")


def torques_for_load(result: ScalingResult, load: Array, *, solver: str = DEFAULT_SOLVER) -> ScalingResult:
    """Eqs. (47), (48), (49): the quadratic program with a known load k, at the c² of a result.

    At a c² of the guaranteed range every load of the box has such torques; motion and duration stay as they are. Limits
    of rates that the result keeps are kept.

    Args:
        result: A result with a trajectory.
        load: Load vector, Shape (10,), as from `LoadBox.load_at` or of `LoadBox.draw`.
        solver: As in `scale`; the distribution follows the result's own rule.

    Returns:
        The same result with the torques of this load.

    Raises:
        InputError: If the result has no trajectory or an argument breaks a rule.
        SelectionError: If this load cannot be carried at that c²; its `result` holds the range that it admits.
        SolverError: If no solver answers.
    """
    check_type("result", result, ScalingResult)
    check_solver(solver)
    if result.trajectory is None or result.c2 is None:
        raise InputError("result", "has no trajectory: no c² was chosen.", value=result.status.value)
    cell, motion, c2 = result.cell.with_load(load), result.motion, result.c2
    options = replace(result.options, solver=solver)
    rows = options.rows(cell, motion)
    own, _ = range_at_samples(rows, replace(options, load="nominal"))
    refused = replace(result, cell=cell, options=options, found=own, c2=None, trajectory=None, load=None)
    if own.admitted(c2, END_TOLERANCE) is None and not (own.samples.several and conflict_at(refused, c2) is None):
        raise SelectionError(f"c² = {c2:g} does not suit this load: {refused.sentence()}", refused)
    # what is overstepped between the samples is convex in the load: of a box the corners tell it
    excess = result.excess if result.load is not None and result.load.question == "guaranteed" else None
    fallbacks = result.fallbacks + own.samples.fallbacks
    try:
        return with_torques(replace(result, cell=cell, options=options, fallbacks=fallbacks, excess=excess), rows=rows)
    except SolverError as error:
        if options.rates is None:
            raise
        raise SelectionError(f"c² = {c2:g} does not suit this load where rates are kept: {error}", refused) from None


def with_torques(
    result: ScalingResult, given: tuple[Array, Array] | None = None, rows: MotionRows | None = None
) -> ScalingResult:
    """A result with the torques of its options at its c², if it has one, and with what is to be said of them.

    Torques and wrenches may be `given`, Shape (N, m) and (N, n w), and the rows from `motion_rows`.

    Raises:
        SolverError: If no solver answers, or the torques overstep a limit.
    """
    cell, motion, options, c2 = result.cell, result.motion, result.options, result.c2
    if c2 is None:
        return result
    rows = options.rows(cell, motion) if rows is None else rows
    if given is not None:
        torque, wrench, fallbacks = *given, 0
    elif options.rates is None:
        torque, wrench, fallbacks = distributed_torques(rows, options, c2)
    else:
        from mrts.scaling.constant_rates import torques_within_rates  # noqa: PLC0415 (scipy is not needed otherwise)

        W = torque_weights(options.weights, cell)
        torque, wrench, fallbacks = *torques_within_rates(rows, options.rates, c2, W, options.distribute), 0
    holding, unheld = _holding(options, rows)
    before = tuple(warning for warning in result.warnings if warning.code not in OF_TORQUES)
    done = ScaledTrajectory(cell, motion, c2, torque, wrench, holding)
    result = replace(result, trajectory=done, fallbacks=result.fallbacks + fallbacks)
    told = before + unheld + overload_remarks(done) + _fast_rates(result) + _fast_joints(result)
    excess = largest_excess(rows.given, done)
    if not excess <= LIMIT_TOLERANCE:
        raise SolverError(
            f"the torques found overstep a limit by {excess:.2g} of it, more than {LIMIT_TOLERANCE:.0e}: the limits or "
            "the masses of this cell are too unlike in size to be solved."
        )
    return replace(result, warnings=tuple(dict.fromkeys(told)))


def distributed_torques(rows: MotionRows, options: Options, c2: float) -> tuple[Array, Array, int]:
    """Torques, Shape (N, m), and wrenches, Shape (N, n w), at each sample by itself.

    Returns:
        Both, and how many programs were left by the chosen solver.
    """
    return motion_torques(rows, options.solver, c2, torque_weights(options.weights, rows.cell), options.distribute)


def _holding(options: Options, rows: MotionRows) -> tuple[Holding, tuple[Remark, ...]]:
    """What holds the object still at both ends, c² = 0, and what to say where a controller needs what there is not."""
    cell, motion = rows.cell, rows.motion
    needed = np.array(pushing_ends(motion.dq, motion.ddq))
    torque, wrench = np.zeros((2, motion.q.shape[1])), np.zeros((2, len(cell.robots) * len(cell.wrench_components)))
    if not np.any(needed):
        return Holding((False, False), torque, wrench), ()
    places = np.array([0, motion.samples - 1])
    still = _still(rows, places)
    held = needed & (motion_widening(still, np.zeros(2)) <= TORQUE_WIDENING)
    if np.any(held):
        if not np.all(held):  # the other end has no torques: the one that has them stands for both
            still = _still(rows, places[held][[0, -1]])
        found = distributed_torques(still, options, 0.0)
        torque, wrench = (np.where(held[:, None], values, 0.0) for values in found[:2])
    remarks = tuple(
        Remark(
            "no-row-at-rest",
            f"the limits do not let the cell hold still where the motion {('starts', 'ends')[end]}, so tables and bags "
            f"{('begin', 'end')[end]} with the torques of the motion: a controller must not stay there.",
            int(places[end]),
        )
        for end in np.flatnonzero(needed & ~held).tolist()
    )
    return Holding((bool(held[0]), bool(held[1])), torque, wrench), remarks


def _still(rows: MotionRows, samples: NDArray[np.intp]) -> MotionRows:
    """The rows at some samples where the joints stand, so that no friction opposes a motion."""
    motion, sharing = rows.motion, rows.sharing
    stands = np.zeros((len(samples), motion.q.shape[1]))
    if sharing is not None and sharing.varies:
        sharing = replace(sharing, internal_wrench=np.asarray(sharing.internal_wrench)[samples])
    still = replace(motion.at(samples), dq=stands, ddq=stands, travel=None)
    return rows.at_rest(still, sharing, samples)


def overload_remarks(done: ScaledTrajectory) -> tuple[Remark, ...]:
    """What motors do not bear for ever, and power above theirs."""
    return _overrated(done) + _above_power(done)


def _overrated(done: ScaledTrajectory) -> tuple[Remark, ...]:
    if not any(np.any(np.isfinite(robot.motors.rated)) for robot in done.cell.robots):
        return ()
    used = np.concatenate([duty.rated_share for duty in done.duty.values()]).tolist()
    shares = {joint: share for joint, share in zip(done.cell.joint_names, used, strict=True) if share > 1}
    if not shares:
        return ()
    worst, *others = sorted(shares, key=lambda joint: -shares[joint])
    also = f"; above theirs too: {first_names(others, NAMED)}" if others else ""
    text = (
        f"{worst}: its root mean square torque over the motion is {100 * shares[worst]:.0f} % of what its motor bears "
        f"for ever ('rated'{also}): repeated without a pause it overheats. Pause without the load, or carry "
        "less; to play the motion slower saves only what its accelerations take."
    )
    return (Remark(EXCEEDS_RATED_TORQUE, text),)


def _above_power(done: ScaledTrajectory) -> tuple[Remark, ...]:
    """Power is a product of torque and speed, so no linear row: the limits are reported against, and not kept."""
    passed = sorted((use for use in power_uses(done) if use.share > 1), key=lambda use: -use.share)
    if not passed:
        return ()
    worst, names = passed[0], ["/".join(filter(None, (use.name.robot, use.name.element))) for use in passed]
    also = f"; above theirs too: {first_names(names[1:], NAMED)}" if names[1:] else ""
    text = (
        f"{names[0]}: power reaches {worst.size:.4g} W at t = {worst.time:.4g} s, {100 * worst.share:.0f} % of its "
        f"limit of {worst.upper:.4g} W{also}. Power is reported only: a slower motion takes less."
    )
    return (Remark(EXCEEDS_POWER, text),)


def _fast_rates(result: ScalingResult) -> tuple[Remark, ...]:
    if result.options.rates is not None:
        return _steps_at_ends(result.motion)
    advice = "--rates cell keeps them, at a speed that varies --profile smooth (in Python rates=True)."
    return _passing(rate_uses(result), EXCEEDS_RATE_LIMIT, f"Rates are reported only; {advice}")


def _fast_joints(result: ScalingResult) -> tuple[Remark, ...]:
    if result.cell.enforces_velocity_limits:
        return ()
    uses = [use for use in limit_uses(result) if use.name.kind == "velocity"]
    return _passing(uses, EXCEEDS_VELOCITY, "Velocity limits are not kept, as was asked.")


def _passing(uses: list[LimitUse], code: str, advice: str) -> tuple[Remark, ...]:
    """What is told of limits, by falling share, that are reported only."""
    passed = [use for use in uses if use.share > 1 + RATE_TOLERANCE]
    if not passed:
        return ()
    worst, *others = passed
    also = f"; {len(others)} more pass theirs" if others else ""
    text = (
        f"{worst.name} reaches {worst.size:.4g} {worst.name.unit} at t = {worst.time:.4g} s, "
        f"{100 * worst.share:.0f} % of its limit{also}. {advice}"
    )
    return (Remark(code, text),)


def _steps_at_ends(motion: CoordinatedMotion) -> tuple[Remark, ...]:
    first, last = pushing_ends(motion.dq, motion.ddq)
    if not (first or last):
        return ()
    where = " and ".join(word for word, pushes in (("starts", first), ("ends", last)) if pushes)
    text = (
        f"the motion {where} at rest but accelerates there, so torques jump from or to those that hold still, at every "
        "speed. The rates are kept in between; a profile that starts and ends without acceleration (quintic, or "
        "--profile smooth) has no such jump."
    )
    return (Remark(STEPS, text),)
