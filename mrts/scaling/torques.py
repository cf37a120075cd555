# SPDX-License-Identifier: MIT
"""The last steps of every answer, whatever c² was chosen for: torques, what holds at both ends, warnings, checks."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.remark import Remark
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.motion.rows_at_rest import pushing_ends
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.torque_distribution import TORQUE_WIDENING, torque_weights
from mrts.program.trajectory_programs import motion_torques
from mrts.program.widening import motion_widening
from mrts.scaling.limit_use import rate_uses
from mrts.scaling.options import Options
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import Holding, ScaledTrajectory

EXCEEDS_RATED_TORQUE = "above-rated"
"""Code of the remark on torques that a motor does not bear for ever."""

EXCEEDS_RATE_LIMIT = "rate-passed"
"""Code of the remark on rates that pass their limit, which nothing keeps."""

STEPS = "step-at-ends"
"""Code of the remark on torques that must jump where a motion starts or ends, whatever its speed."""

OF_TORQUES = (EXCEEDS_RATED_TORQUE, EXCEEDS_RATE_LIMIT, STEPS)
"""Codes of remarks that are found again with other torques."""

RATE_TOLERANCE = 1e-6
"""Share by which a rate may pass its limit before it is told: rounding, of differences of neighbouring samples."""

NAMED = 3
"""Further joints that it names."""


def with_torques(
    result: ScalingResult, given: tuple[Array, Array] | None = None, rows: MotionRows | None = None
) -> ScalingResult:
    """A result with the torques of its options at its c², and with what is to be said of them.

    Args:
        result: Any result, whose cell has the load that is carried; without a c² it stays as it is.
        given: Torques and wrenches that were distributed already, Shape (N, m) and (N, n w).
        rows: From `motion_rows`, where they are at hand; None puts them together.

    Raises:
        SolverError: If no solver answers, or the torques overstep a limit.
    """
    cell, motion, options, c2 = result.cell, result.motion, result.options, result.c2
    if c2 is None:
        return result
    rows = motion_rows(cell, motion) if rows is None else rows
    if given is not None:
        torque, wrench, fallbacks = *given, 0
    elif options.rates is None:
        torque, wrench, fallbacks = distributed_torques(cell, motion, options, c2, rows)
    else:
        from mrts.program.constant_rates import torques_within_rates  # noqa: PLC0415 (scipy is not needed otherwise)

        W = torque_weights(options.weights, cell)
        torque, wrench, fallbacks = *torques_within_rates(cell, motion, options.sharing, options.rates, c2, W), 0
    holding, unheld = _holding(cell, motion, options, rows)
    before = tuple(warning for warning in result.warnings if warning.code not in OF_TORQUES)
    done = ScaledTrajectory(cell, motion, c2, torque, wrench, holding)
    result = replace(result, trajectory=done, fallbacks=result.fallbacks + fallbacks)
    told = before + unheld + _overrated(done) + _fast_rates(result)
    return replace(result, warnings=tuple(dict.fromkeys(told))).checked(rows.given)


def distributed_torques(
    cell: Cell, motion: CoordinatedMotion, options: Options, c2: float, rows: MotionRows | None = None
) -> tuple[Array, Array, int]:
    """Torques, Shape (N, m), and wrenches, Shape (N, n w), at each sample by itself.

    Returns:
        Both, and how many programs were left by the chosen solver.
    """
    W = torque_weights(options.weights, cell)
    given = cell, motion, options.formulation, options.sharing, options.solver, c2, W, rows
    return motion_torques(*given, options.distribute)


def _holding(
    cell: Cell, motion: CoordinatedMotion, options: Options, rows: MotionRows
) -> tuple[Holding, tuple[Remark, ...]]:
    """What holds the object still at both ends, c² = 0, and what to say where a controller needs what there is not."""
    needed = np.array(pushing_ends(motion.dq, motion.ddq))
    torque, wrench = np.zeros((2, motion.q.shape[1])), np.zeros((2, len(cell.robots) * len(cell.wrench_components)))
    if not np.any(needed):
        return Holding((False, False), torque, wrench), ()
    places = np.array([0, motion.samples - 1])
    still, shared = _still(motion, options.sharing, places)
    at_rest = rows.at_rest(cell, still, places)
    widening = motion_widening(cell, still, np.zeros(2), formulation=options.formulation, sharing=shared, rows=at_rest)
    held = needed & (widening <= TORQUE_WIDENING)
    if np.any(held):
        if not np.all(held):  # the other end has no torques: the one that has them stands for both
            both = places[held][[0, -1]]
            still, shared = _still(motion, options.sharing, both)
            at_rest = rows.at_rest(cell, still, both)
        found = distributed_torques(cell, still, replace(options, sharing=shared), 0.0, at_rest)
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


def _still(
    motion: CoordinatedMotion, sharing: LoadSharing | None, samples: NDArray[np.intp]
) -> tuple[CoordinatedMotion, LoadSharing | None]:
    """Some samples at which the joints stand, so that no friction opposes a motion, with the distribution there."""
    stands = np.zeros((len(samples), motion.q.shape[1]))
    still = replace(motion.at(samples), dq=stands, ddq=stands, travel=None)
    internal = None if sharing is None else sharing.internal_wrench
    if sharing is None or internal is None or np.ndim(internal) == 1:
        return still, sharing
    return still, replace(sharing, internal_wrench=np.asarray(internal)[samples])


def _overrated(done: ScaledTrajectory) -> tuple[Remark, ...]:
    """What to say of joints whose motors bear their torque for a while only."""
    if not any(np.any(np.isfinite(robot.motors.rated)) for robot in done.cell.robots):
        return ()
    shares = {
        f"{robot.name}/{joint}": float(share)
        for robot, duty in zip(done.cell.robots, done.duty.values(), strict=True)
        for joint, share in zip(robot.joints, duty.rated_share, strict=True)
        if share > 1
    }
    if not shares:
        return ()
    worst, *others = sorted(shares, key=lambda joint: -shares[joint])
    more = f" and {len(others) - NAMED} more" if len(others) > NAMED else ""
    also = f"; above theirs too: {', '.join(others[:NAMED])}{more}" if others else ""
    text = (
        f"{worst}: its root mean square torque over the motion is {100 * shares[worst]:.0f} % of what its motor bears "
        f"for ever ('rated'{also}): repeated without a pause it overheats. Pause without the load, or carry "
        "less; to play the motion slower saves only what its accelerations take."
    )
    return (Remark(EXCEEDS_RATED_TORQUE, text),)


def _fast_rates(result: ScalingResult) -> tuple[Remark, ...]:
    """What to say of rates that are above their limits, at the samples or where the motion starts and ends."""
    if result.options.rates is not None:
        return _steps_at_ends(result.motion)
    passed = [use for use in rate_uses(result) if use.share > 1 + RATE_TOLERANCE]
    if not passed:
        return ()
    worst, *others = passed
    also = f"; {len(others)} more pass theirs" if others else ""
    text = (
        f"{worst.name} reaches {worst.size:.4g} {worst.name.unit} at t = {worst.time:.4g} s, "
        f"{100 * worst.share:.0f} % of its limit{also}. Rates are reported only; --rates cell keeps them, at a speed "
        "that varies --profile smooth (in Python rates=True)."
    )
    return (Remark(EXCEEDS_RATE_LIMIT, text),)


def _steps_at_ends(motion: CoordinatedMotion) -> tuple[Remark, ...]:
    """That a motion accelerates from standstill on, or until it stands."""
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
