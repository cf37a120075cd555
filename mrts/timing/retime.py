# SPDX-License-Identifier: MIT
"""The fastest admissible r(t): a speed that varies along the path, where `mrts.scale` keeps its factor constant."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import NoneType
from typing import Any

import numpy as np

from mrts.base.argument_types import Progress, check_callable, check_type, is_number
from mrts.base.arrays import Array
from mrts.base.errors import InputError, as_array
from mrts.base.input_file import LARGEST_NUMBER
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.grasp_closure import ClosureBound
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.program.excess import BETWEEN
from mrts.program.formulation import DistributionName
from mrts.program.load_sharing import LoadSharing
from mrts.program.path_solver import KernelSolver
from mrts.program.rate_limits import RateLimits, Rates, rate_limits
from mrts.program.smooth_program import Goal
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.scaling.load_study import load_question
from mrts.scaling.motion_remarks import interpolated_timing, timing_remarks
from mrts.scaling.result import DistributionRule
from mrts.scaling.scale import FactorQuestion, factor_question
from mrts.timing.between_samples import check_held_between, excess_by_segment, refined_timing
from mrts.timing.fastest_timing import fastest_timing
from mrts.timing.held_wrenches import GivenTorques
from mrts.timing.played_result import played_result
from mrts.timing.result import RetimingResult
from mrts.timing.smooth_retiming import smooth_goal, smooth_retiming
from mrts.timing.smooth_timing import SmoothQuestion


def retime(
    cell: Cell,
    motion: ObjectMotion | JointTable | CoordinatedMotion,
    *,
    sharing: LoadSharing | None = None,
    weights: Array | float | None = None,
    load: str = "auto",
    distribute: DistributionName = "least-torque",
    reserve: float | None = None,
    closure: ClosureBound | None = None,
    start_speed: float = 0.0,
    end_speed: float = 0.0,
    between: float | None = BETWEEN,
    rates: Rates = False,
    weigh: Mapping[str, float] | None = None,
    least_energy_in: float | None = None,
    start_torque: Array | None = None,
    end_torque: Array | None = None,
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
        distribute: As in `mrts.scale`; with rates "least-torque" alone.
        reserve: Likewise.
        closure: Likewise.
        start_speed: ṙ at the start, where the given motion does not start from rest [1].
        end_speed: ṙ at the end, likewise [1].
        between: As in `mrts.scale`; what is left above it is told in the first sentence.
        rates: Whether torques, accelerations and contact wrenches may only change at limited rates: True for the limits
            of the cell, a number for the torque rate of the joints that have none, as a multiple of their torque limit
            [1/s]; docs/smooth.md.
        weigh: With rates: weights of what is to be least, the "time" [1/s] and the "energy" ∫ τᵀWτ dt [1/s; with W = 1
            1/(N² m² s)];
            None is the time alone.
        least_energy_in: With rates: the longest duration, within which the energy is to be least [s].
        start_torque: With rates: torques that hold still where the motion begins, Shape (m,); None leaves them free
            within the limits, as part of the answer [N m].
        end_torque: Likewise where it ends.
        progress: Told how many of how many loads, or with rates of how many steps, are done.

    Returns:
        The outcome; where no timing is admissible, its `explanation` says why.

    Raises:
        InputError: If an argument breaks a rule.
        MotionError: If the arms cannot follow the object.
        SolverError: If no solver answers.
    """
    question = _checked_question(cell, sharing, load, start_speed, end_speed, progress)
    rule = DistributionRule(sharing, "wrench", weights, distribute)
    asked = _smooth_request(
        cell, rates, distribute, weigh=weigh, least_energy_in=least_energy_in,
        start_torque=start_torque, end_torque=end_torque,
    )  # fmt: skip
    _check_held(cell, asked, question)
    compared = factor_question(
        cell, motion, "auto", rule, solver=DEFAULT_SOLVER, load=question, reserve=reserve, closure=closure,
        between=between, rates=rates,
    )  # fmt: skip
    speeds, kept = (start_speed, end_speed), compared.tolerance
    adds, tolerance = kept is not None, BETWEEN if kept is None else kept
    fastest = _fastest(compared, speeds, tolerance, progress, adds=adds)
    if asked is None:
        return fastest
    whole = SmoothQuestion(
        compared=compared,
        loads=fastest.loads,
        rates=asked.rates,
        goal=asked.goal,
        end_speeds=speeds,
        end_torques=asked.held,
        fastest=fastest.duration,
        solver=KernelSolver(),
    )
    return smooth_retiming(fastest, whole, tolerance, progress, adds=adds)


def _fastest(
    compared: FactorQuestion, speeds: tuple[float, float], tolerance: float, progress: Progress, *, adds: bool
) -> RetimingResult:
    """The fastest timing without limits of rates, with its torques."""
    cell, given, rule = compared.cell, compared.motion, replace(compared.rule, rates=None)
    if adds:
        check_held_between(cell, given)
    remarks = timing_remarks(cell, given, lambda: compared.factor.bare.range)

    def timed(path: CoordinatedMotion, *, refined: bool = True) -> RetimingResult:
        found = fastest_timing(compared, path, speeds, progress, refined=refined)
        if not found.pieces:
            return found
        played = played_result(cell, path, rule, found.pieces, "fastest timing", warnings=remarks)
        return replace(found, retimed=played)

    first = timed(given, refined=False)
    fastest = refined_timing(first, timed, lambda one: excess_by_segment(one, tolerance), tolerance, adds=adds)
    if fastest.retimed is None or first.duration is None or fastest.duration is None:
        return fastest
    added = interpolated_timing(given, first.duration, fastest.duration)
    return replace(fastest, retimed=replace(fastest.retimed, warnings=fastest.retimed.warnings + added))


@dataclass(frozen=True)
class _SmoothRequest:
    """What is asked with limits of rates.

    Attributes:
        rates: The limits.
        goal: What is to be least.
        held: Torques that hold still at both ends, where they are given.
    """

    rates: RateLimits
    goal: Goal
    held: GivenTorques


def _smooth_request(cell: Cell, rates: Rates, distribute: DistributionName, **given: Any) -> _SmoothRequest | None:
    """The arguments that go with rates, checked; None without rates."""
    if rates is False:
        for name, value in given.items():
            if value is not None:
                raise InputError(name, "needs limits of rates: give rates too.", value=value)
        return None
    goal = smooth_goal(given["weigh"], given["least_energy_in"])
    check_type("distribute", distribute, str)
    if distribute != "least-torque":
        rule = "does not go with rates: where torques change slowly they are the least ones."
        raise InputError("distribute", rule, value=distribute)
    joints, held = sum(len(robot.joints) for robot in cell.robots), []
    for name in ("start_torque", "end_torque"):
        torque = None if given[name] is None else as_array(name, given[name])
        if torque is not None and (torque.shape != (joints,) or not np.all(np.isfinite(torque))):
            raise InputError(name, f"must be finite with Shape ({joints},), one a joint.", value=given[name])
        held.append(torque)
    return _SmoothRequest(rate_limits(cell, rates), goal, (held[0], held[1]))


def _check_held(cell: Cell, asked: _SmoothRequest | None, question: str) -> None:
    """Torques that hold still are those of one load."""
    if asked is None or question != "guaranteed" or cell.load_box is None:
        return
    for name, torque in zip(("start_torque", "end_torque"), asked.held, strict=True):
        if torque is not None:
            raise InputError(name, "holds one load, but the cell's varies: ask for load='nominal'.")


def _checked_question(
    cell: Cell, sharing: LoadSharing | None, load: str, start_speed: float, end_speed: float, progress: Progress
) -> str:
    """The question asked of the load, if all arguments keep their rules."""
    check_type("cell", cell, Cell)
    check_type("sharing", sharing, LoadSharing, NoneType)
    check_callable("progress", progress)
    for name, speed in (("start_speed", start_speed), ("end_speed", end_speed)):
        if not is_number(speed, 0, LARGEST_NUMBER):
            rule = f"must be a number from 0 to {LARGEST_NUMBER:.0e}, a multiple of the given motion's speed."
            raise InputError(name, rule, value=speed)
    if sharing is not None and sharing.internal_wrench is not None and np.ndim(sharing.internal_wrench) > 1:
        raise InputError("sharing", "its internal wrench must be one for all samples where the speed varies.")
    question = load_question(cell, load, "auto")
    if question not in {"guaranteed", "nominal"}:
        raise InputError("load", "must be guaranteed or nominal where the speed varies.", value=load)
    return question
