# SPDX-License-Identifier: MIT
"""The fastest admissible r(t): a speed that varies along the path, where `mrts.scale` keeps its factor constant."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Progress, Remark, check_callable, check_type, is_number
from mrts.base.input_file import LARGEST_NUMBER
from mrts.cell.cell import Cell
from mrts.following.coordinate import ClosureBound, coordinate
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits import Limit
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.program.between_samples import BETWEEN
from mrts.program.formulation import DistributionName
from mrts.program.load_sharing import LoadSharing
from mrts.program.rate_limits import RateLimits, Rates, rate_limits
from mrts.program.smooth_program import LEAST_EFFORT, Goal
from mrts.scaling.options import Options, limited_cell
from mrts.scaling.remarks import interpolated, motion_remarks
from mrts.scaling.scale import Remarks, ScalingResult, with_torques
from mrts.timing.between_samples import check_held_between, refined_timing, without_sharp_turns
from mrts.timing.fastest_timing import fastest_timing
from mrts.timing.result import RetimingResult, RetimingStatus, retimed_motion, smooth_torques
from mrts.timing.smooth_timing import smooth_timing

ROOM = 0.01
"""Share of the least duration that a timing which keeps a reserve may add: near the fastest are many that need far less
of the limits. On the shipped cells the mean of the largest shares falls from 86 to 34, 98 to 43 and 100 to 72 %."""


def retime(
    cell: Cell,
    motion: ObjectMotion | JointTable | CoordinatedMotion,
    *,
    sharing: LoadSharing | None = None,
    weights: Array | float | None = None,
    load: str = "auto",
    distribute: DistributionName | None = None,
    reserve: float | None = None,
    limits: Sequence[Limit] | None = None,
    closure: ClosureBound | None = None,
    start_speed: float = 0.0,
    end_speed: float = 0.0,
    between: float | None = BETWEEN,
    rates: Rates = False,
    least_energy_in: float | None = None,
    progress: Progress = lambda _done, _total: None,
) -> RetimingResult:
    """Find the fastest r(t) within all limits, and distribute its torques.

    The time of the given motion is the path parameter r; how fast it is given only spaces the samples. Limits hold at
    both ends of every segment between samples (the interpolation scheme of Pham and Pham, IEEE T-RO 34(3), 2018); the
    polygons of admissible (r̈, ṙ²) are projections over all contact wrenches (for redundant actuation see Pham and
    Stasse, IEEE/ASME T-MECH 20(6), 2015). Where the load is uncertain, they are intersected over the corners of its
    box; docs/optimal_profile.md has the proof.

    Args:
        cell: The cell.
        motion: Motion of the object, a table of joint motion, or motion of the whole cell.
        sharing: A fixed distribution of the load; None leaves it free.
        weights: W of the quadratic program, as in `mrts.scale`.
        load: "guaranteed" (for every load of the box) or "nominal"; "auto" is "guaranteed" if the cell has a load box.
        distribute: As in `mrts.scale`. With rates "reserve" may also add a hundredth to the duration; it is the default
            there where there is something to distribute and no energy is to be least.
        reserve: Likewise.
        limits: Likewise.
        closure: Likewise.
        start_speed: ṙ at the start, where the given motion does not start from rest [1].
        end_speed: ṙ at the end, likewise [1].
        between: As in `mrts.scale`; what is left above it is told in the first sentence.
        rates: Whether torques, accelerations and contact wrenches may only change at limited rates: True for the limits
            of the cell, a number for the torque rate of the joints that have none, as a multiple of their torque limit
            [1/s]; docs/smooth.md.
        least_energy_in: With rates: the longest duration, within which the energy ∫ τᵀWτ dt is to be least [s]; None
            makes the duration least.
        progress: With rates, told how many of how many steps are done.

    Returns:
        The outcome; where no timing is admissible, its `explanation` says why.

    Raises:
        InputError: If an argument breaks a rule.
        MotionError: If the arms cannot follow the object.
        SolverError: If no solver answers.
    """
    check_type("cell", cell, Cell)
    check_callable("progress", progress)
    cell = limited_cell(cell, reserve, limits)
    kept = None if rates is False else rate_limits(cell, rates)
    goal = Goal() if least_energy_in is None else _least_energy(kept, least_energy_in)
    if distribute is None:
        chosen = kept is not None and goal.effort == 0 and sharing is None and len(cell.robots) > 1
        distribute = "reserve" if chosen else "least-torque"
    options = Options(sharing=sharing, weights=weights, load=load, distribute=distribute, between=between, rates=kept)
    options = options.checked(cell)
    _check_timing(options, start_speed, end_speed)
    if options.distribute == "reserve" and goal.effort == 0:
        goal = replace(goal, room=ROOM)
    given = coordinate(cell, motion, closure)
    asked = RetimingResult(cell, given, given, options, end_speeds=(start_speed, end_speed))
    if options.between is not None:
        check_held_between(cell, given)

    first = fastest_timing(asked, given)
    stuck = first.status in {RetimingStatus.STANDSTILL, RetimingStatus.NOT_CONTROLLABLE}
    if stuck and options.between is not None:
        divided = fastest_timing(asked, without_sharp_turns(cell, given))
        first = divided if divided.pieces else first
    fastest = refined_timing(first, None if options.between is None else partial(fastest_timing, asked))
    if kept is not None and (fastest.pieces or fastest.status is RetimingStatus.UNBOUNDED):
        found = smooth_timing(fastest, goal, progress)
        return _played(found, partial(motion_remarks, cell, given, given)) if found.pieces else found
    if not fastest.pieces:
        return fastest
    told = tuple[Remark, ...]()
    if fastest.motion is not first.motion and first.duration and fastest.duration:
        told = interpolated(given, fastest.duration / first.duration - 1, "the timing {} longer")
    return _played(fastest, partial(motion_remarks, cell, given, fastest.motion, told))


def _played(timed: RetimingResult, remarks: Remarks) -> RetimingResult:
    """A timing with its motion and its torques: those of a smooth timing, or of the quadratic program (31) to (34).

    The motion's range of c², which only says what faster or slower would be, is found when it is read.
    """
    motion, excess = retimed_motion(timed.motion, timed.pieces), timed.excess
    given, own = timed.motion.object.time, motion.object.time
    if excess is not None and excess.time is not None:
        excess = replace(excess, time=float(np.interp(excess.time, given, own)))
    untouched = ScalingResult(
        timed.cell,
        motion,
        c2=1.0,
        options=replace(timed.options, load="nominal"),
        origin=f"{timed.what} of a path that was given {given[-1]:.4g} s: {own[-1]:.4g} s",
        remarks=remarks,
        excess=excess,
    )
    torques = None if timed.smooth is None else smooth_torques(timed.pieces)
    return replace(timed, retimed=with_torques(untouched, torques))


def _check_timing(options: Options, start_speed: float, end_speed: float) -> None:
    if options.load not in {"guaranteed", "nominal"}:
        raise InputError("load", "must be guaranteed or nominal where the speed varies.", value=options.load)
    if options.sharing is not None and options.sharing.varies:
        raise InputError("sharing", "its internal wrench must be one for all samples where the speed varies.")
    for name, speed in (("start_speed", start_speed), ("end_speed", end_speed)):
        if not is_number(speed, 0, LARGEST_NUMBER):
            rule = f"must be a number from 0 to {LARGEST_NUMBER:.0e}, a multiple of the given motion's speed."
            raise InputError(name, rule, value=speed)


def _least_energy(rates: RateLimits | None, duration: float) -> Goal:
    if rates is None:
        raise InputError("least_energy_in", "needs limits of rates: give rates too.", value=duration)
    if not is_number(duration, 0, LARGEST_NUMBER) or duration == 0:
        raise InputError("least_energy_in", "must be a duration > 0 [s].", value=duration)
    return replace(LEAST_EFFORT, longest=float(duration))
