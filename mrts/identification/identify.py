# SPDX-License-Identifier: MIT
"""Armature and friction of an arm's motors from a recording of its free motion."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mrts.base.argument_types import check_type, is_number
from mrts.base.arrays import Array, apply
from mrts.base.errors import InputError
from mrts.base.remark import Remark
from mrts.cell.cell import Cell
from mrts.cell.robot import DEGREES_SUSPECTED, Robot
from mrts.following.coordinate import columns_by_joint, meant_instead
from mrts.following.tracking import PRINTED_TOLERANCE, within_limits
from mrts.identification.identified_motors import ArmMotors, MotorIdentification, MotorParameter
from mrts.identification.motor_regression import PARAMETERS, fit_joint
from mrts.identification.recorded_motion import RecordedMotion, smoothed_motion
from mrts.motion.joint_recording import JointRecording, RecordedJoint, load_recording

CHUNK = 4096
"""Samples whose mass matrices are held at once."""

EXPLAINED = 0.5
"""Share of an effort's variance that model and motors explain at least, or something is wrong with either."""

NOISY = 0.01
"""Share of a joint's squared accelerations that may be noise: its inertia is too small by as much."""

MOST_NAMED = 12
"""Columns named in a message; a humanoid has more."""


def identify(cell: Cell, recording: JointRecording | Path | str, *, cutoff: float | None = None) -> MotorIdentification:
    """Find armature, Coulomb and viscous friction of every joint from a recording of the arms' free motion.

    The arms move without the object, and nothing touches them. What the torque of the rigid bodies leaves of the
    measured effort is fitted by bounded least squares, joint by joint:

        effort - τ_rb(q, q̇, q̈) = I_a q̈ + b q̇ + τ_c sign(q̇) + offset,  I_a, b, τ_c >= 0

    Positions and efforts go through the same filter without delay (`mrts.identification.recorded_motion`); where a
    joint is so slow that its sign of travel is not known, nothing is asked of it. `motors` that the cell has already
    are not used.

    Args:
        cell: The cell; of its arms, links and gravity are used.
        recording: What was measured, or the file: `mrts.load_recording`. All arms, or some.
        cutoff: Of the filter [Hz]; None takes 20 Hz, or less where samples are too few.

    Raises:
        InputError: If the recording lacks a joint of an arm or its effort, is too short, or nothing moves in it.
    """
    check_type("cell", cell, Cell)
    if cutoff is not None and (not is_number(cutoff, 0) or cutoff == 0):
        raise InputError("cutoff", "must be a number > 0, in Hz.", value=cutoff)
    if not isinstance(recording, JointRecording):
        recording = load_recording(recording)
    found = _recorded_arms(cell, recording)
    remarks: list[Remark] = []
    arms = []
    for robot, joints in found:
        motion = smoothed_motion(recording.path, robot, joints, cutoff)
        _check_units(recording, robot, joints, motion)
        arms.append(_identify_arm(cell, robot, motion))
        remarks += [*_limit_remarks(robot, motion), *_remarks(arms[-1], motion.speed_noise)]
    if not any(np.any(arm.used) for arm in arms):
        raise InputError(
            recording.path,
            "nothing moves in this recording faster than what rest looks like: record a motion that turns every joint "
            "to and fro.",
        )
    if missing := [robot.name for robot in cell.robots if robot not in [robot for robot, _ in found]]:
        remarks.append(Remark("not-recorded", f"the recording says nothing of {', '.join(missing)}."))
    return MotorIdentification(cell.name, recording.path, tuple(arms), tuple(remarks))


def _recorded_arms(cell: Cell, recording: JointRecording) -> list[tuple[Robot, list[RecordedJoint]]]:
    columns = [*recording.joints, *recording.unusable]
    found = columns_by_joint(cell, recording.path, columns)
    extra = [name for name in columns if name not in found.values()]
    arms = []
    for robot in cell.robots:
        joints = [f"{robot.name}/{joint}" for joint in robot.joints]
        if not any(joint in found for joint in joints):
            continue
        for joint in joints:
            if joint not in found:
                rule = f"nothing is recorded of joint '{joint}' of cell '{cell.name}', but of others of this arm."
                raise InputError(recording.path, rule + meant_instead(cell, joint, extra))
            if found[joint] in recording.unusable:
                raise recording.unusable[found[joint]]
        arms.append((robot, [recording.joints[found[joint]] for joint in joints]))
    if not arms:
        names = ", ".join(sorted(columns)[:MOST_NAMED])
        first = f"{cell.robots[0].name}/{cell.robots[0].joints[0]}"
        raise InputError(
            recording.path,
            f"no arm of cell '{cell.name}' has joints of these names: {names}. Names are ROBOT/JOINT as in the cell "
            f"file and its URDF, such as '{first}'; in a bag, ROBOT is the first name of the topic.",
        )
    return arms


def _check_units(recording: JointRecording, robot: Robot, joints: list[RecordedJoint], motion: RecordedMotion) -> None:
    """Refuse positions in degrees, beyond two turns and limits, and an effort that stays while its joint moves."""
    limits = np.maximum(np.abs(robot.position_lower), np.abs(robot.position_upper))
    for place, (name, joint) in enumerate(zip(robot.joints, joints, strict=True)):
        furthest = float(np.max(np.abs(joint.position)))
        if robot.position_units[place] == "rad" and furthest > max(limits[place], DEGREES_SUSPECTED):
            raise InputError(
                recording.path,
                f"is more than two turns and its limit, {limits[place]:.4g}: positions are in rad, are these degrees?",
                key=f"position of {robot.name}/{name}",
                value=furthest,
            )
        if np.ptp(joint.effort) == 0 and np.any(motion.known[:, place]):
            raise InputError(
                recording.path,
                "is constant although the joint moves: no effort was measured.",
                key=f"effort of {robot.name}/{name}",
                value=float(joint.effort[0]),
            )


def _limit_remarks(robot: Robot, motion: RecordedMotion) -> list[Remark]:
    """Joints recorded beyond their position limits, by whole turns or not: their zero may not be that of the URDF."""
    q = within_limits(robot, motion.q)
    low, high = np.min(q, axis=0), np.max(q, axis=0)
    beyond = (low < robot.position_lower - PRINTED_TOLERANCE) | (high > robot.position_upper + PRINTED_TOLERANCE)
    return [
        Remark(
            "past-position-limit",
            f"'{robot.name}/{robot.joints[place]}' moves from {low[place]:.4g} to {high[place]:.4g} "
            f"{robot.position_units[place]}, its limits are [{robot.position_lower[place]:.4g}, "
            f"{robot.position_upper[place]:.4g}]: is its zero that of the URDF? Gravity depends on it.",
        )
        for place in np.flatnonzero(beyond)
    ]


def _identify_arm(cell: Cell, robot: Robot, motion: RecordedMotion) -> ArmMotors:
    left_over = motion.blocks(motion.effort - _rigid_torque(cell, robot, motion))
    effort, velocity, acceleration, sign = map(motion.blocks, (motion.effort, motion.dq, motion.ddq, motion.sign))
    used = motion.blocks(motion.known.astype(np.float64)) == 1
    limits = np.maximum(np.abs(robot.torque_lower), np.abs(robot.torque_upper))
    recorded = np.max(np.abs(motion.dq), axis=0)
    fastest = np.where(np.isfinite(robot.velocity_limit), robot.velocity_limit, recorded)
    parts = [
        fit_joint(
            np.column_stack([acceleration[:, place], velocity[:, place], sign[:, place]]),
            left_over[:, place],
            used[:, place],
            float(fastest[place]),
            float(limits[place]),
        )
        for place in range(len(robot.joints))
    ]
    fits, offset, columns, residual_rms = zip(*parts, strict=True)
    fitted = np.column_stack(columns)
    return ArmMotors(
        robot=robot,
        **{
            name: MotorParameter(**{key: np.array([fit[key][place] for fit in fits]) for key in fits[0]})
            for place, name in enumerate(PARAMETERS)
        },
        offset=np.array(offset),
        residual_rms=np.array(residual_rms),
        explained=_explained(effort, left_over - fitted, used),
        cutoff=motion.cutoff,
        time=motion.blocks(motion.time),
        used=used,
        velocity=velocity,
        acceleration=acceleration,
        left_over=left_over,
        fitted=fitted,
    )


def _rigid_torque(cell: Cell, robot: Robot, motion: RecordedMotion) -> Array:
    """Torque of the links alone along the smoothed motion, the other arms at rest, Shape (N, n) [N m or N]."""
    part = cell.joint_slices[robot.name]
    rest = np.concatenate([other.posture for other in cell.robots])
    parts = []
    for start in range(0, len(motion.time), CHUNK):
        some = slice(start, start + CHUNK)
        count = len(motion.q[some])
        q, dq = np.tile(rest, (count, 1)), np.zeros((count, len(rest)))
        q[:, part], dq[:, part] = motion.q[some], motion.dq[some]
        of = cell.functions("dynamics", count, {"q": q, "dq": dq})
        torque = apply(of["mass_matrix"][:, part, part], motion.ddq[some])
        parts.append(torque + of["coriolis_torque"][:, part] + of["gravity_torque"][:, part])
    return np.concatenate(parts)


def _explained(effort: Array, residual: Array, used: NDArray[np.bool_]) -> Array:
    shares = np.ones(effort.shape[1])
    for place, counted in enumerate(used.T):
        variance = float(np.var(effort[counted, place])) if np.any(counted) else 0.0
        if variance > 0:
            shares[place] = 1 - np.mean(residual[counted, place] ** 2) / variance
    return shares


def _remarks(arm: ArmMotors, speed_noise: Array) -> list[Remark]:
    """What to know of one arm.

    Least squares take accelerations for exact, so noisy ones leave too little inertia. The mean acceleration of a
    block is the difference of two velocities by the block's length.
    """
    remarks = []
    for place, joint in enumerate(arm.robot.joints):
        name = f"{arm.robot.name}/{joint}"
        for kind, found in arm.estimates.items():
            if found.reasons[place]:
                text = f"{kind} of '{name}' is not identified: {found.reasons[place]}."
                remarks.append(Remark("not-excited", text))
            if found.bounded[place]:
                text = (
                    f"{kind} of '{name}' is 0 because it cannot be negative; free, it were {found.free[place]:.3g} ± "
                    f"{found.half_width[place]:.2g}: where that is far from 0, masses of the URDF or efforts are wrong."
                )
                remarks.append(Remark("bound-active", text))
        if arm.explained[place] < EXPLAINED:
            text = (
                f"only {100 * max(arm.explained[place], 0.0):.2g} % of the effort of '{name}' is explained: is it in "
                "N m (N) and not in A, on the joint side of the gear, was nothing in the hand, is the URDF that of "
                "this arm?"
            )
            remarks.append(Remark("unexplained-effort", text))
        moving = arm.acceleration[arm.used[:, place], place]
        noise = 2 * (speed_noise[place] * arm.cutoff) ** 2
        share = noise / np.mean(moving**2) if len(moving) and np.any(moving) else 0.0
        if share > NOISY:
            text = (
                f"noise of the positions of '{name}' is {100 * share:.2g} % of its squared accelerations: its armature "
                "is too small by that share of the whole inertia that the joint turns. Lower the cutoff, or accelerate "
                "more."
            )
            remarks.append(Remark("noisy-positions", text))
    return remarks
