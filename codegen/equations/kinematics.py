# SPDX-License-Identifier: MIT
"""Forward kinematics, frame Jacobian and J̇q̇ of one arm, all in the arm's base frame."""

from dataclasses import dataclass
from typing import Any

import casadi as ca
from mrts_codegen.equations.spatial_algebra import axis_rotation, skew
from mrts_codegen.urdf.robot_model import Joint, RobotModel


@dataclass(frozen=True)
class ChainMotion:
    """Velocities and accelerations of the joint frames, each in its own moved frame.

    Attributes:
        R: Rotation of each joint's moved frame in the frame before, each Shape (3, 3).
        p: Its origin in the frame before, each Shape (3,) [m].
        w: Angular velocity, each Shape (3,) [rad/s].
        dw: Angular acceleration, each Shape (3,) [rad/s²].
        a: Acceleration of the origin, each Shape (3,) [m/s²].
    """

    R: list[Any]
    p: list[Any]
    w: list[Any]
    dw: list[Any]
    a: list[Any]


def joint_transform(joint: Joint, q: Any) -> tuple[Any, Any]:
    """Pose of a joint's moved frame in the frame before it.

    Returns:
        Rotation, Shape (3, 3), and position, Shape (3,) [m].
    """
    R, p = ca.SX(joint.placement.R), ca.SX(joint.placement.p)
    if joint.kind == "revolute":
        return R @ axis_rotation(joint.axis, q), p
    return R, p + R @ (ca.SX(joint.axis) * q)


def forward_kinematics(robot: RobotModel, q: Any) -> list[tuple[Any, Any]]:
    """Rotation, Shape (3, 3), and origin, Shape (3,) [m], of all joints' moved frames and the tip in the base frame."""
    R, p = ca.SX.eye(3), ca.SX.zeros(3)
    frames = []
    steps = [joint_transform(joint, q[index]) for index, joint in enumerate(robot.joints)]
    for R_step, p_step in (*steps, (ca.SX(robot.tip.R), ca.SX(robot.tip.p))):
        p = p + R @ p_step
        R = R @ R_step
        frames.append((R, p))
    return frames


def frame_jacobian(robot: RobotModel, q: Any) -> Any:
    """Jacobian J of the tip: [v; ω] = J q̇ in base axes, Shape (6, n)."""
    *frames, (_, p_tip) = forward_kinematics(robot, q)
    columns = []
    for joint, (R, p) in zip(robot.joints, frames, strict=True):
        axis = R @ ca.SX(joint.axis)
        if joint.kind == "revolute":
            columns.append(ca.vertcat(ca.cross(axis, p_tip - p), axis))
        else:
            columns.append(ca.vertcat(axis, ca.SX.zeros(3)))
    return ca.horzcat(*columns)


def chain_motion(robot: RobotModel, q: Any, dq: Any, ddq: Any, base_acceleration: Any) -> ChainMotion:
    """Forward recursion of velocities and accelerations (Featherstone 2008, ch. 5.3, in three-vectors).

    Args:
        robot: The arm.
        q: Joint positions, Shape (n,) [rad or m].
        dq: Joint velocities, Shape (n,) [rad/s or m/s].
        ddq: Joint accelerations, Shape (n,) [rad/s² or m/s²].
        base_acceleration: Acceleration of the base in base axes, Shape (3,) [m/s²].
    """
    motion = ChainMotion([], [], [], [], [])
    w, dw, a = ca.SX.zeros(3), ca.SX.zeros(3), ca.SX(base_acceleration)
    for index, joint in enumerate(robot.joints):
        R, p = joint_transform(joint, q[index])
        axis = ca.SX(joint.axis)
        a = R.T @ (a + spin(w, dw) @ p)
        w, dw = R.T @ w, R.T @ dw
        if joint.kind == "revolute":
            dw = dw + axis * ddq[index] + ca.cross(w, axis) * dq[index]
            w = w + axis * dq[index]
        else:
            a = a + axis * ddq[index] + 2 * ca.cross(w, axis) * dq[index]
        for values, value in zip((motion.R, motion.p, motion.w, motion.dw, motion.a), (R, p, w, dw, a), strict=True):
            values.append(value)
    return motion


def spin(w: Any, dw: Any) -> Any:
    """The matrix of a ↦ ω̇ × a + ω × (ω × a), Shape (3, 3)."""
    products = w @ w.T
    return skew(dw) + products - ca.trace(products) * ca.SX.eye(3)


def bias_acceleration(robot: RobotModel, q: Any, dq: Any) -> Any:
    """J̇q̇ of the tip, the acceleration [v̇; ω̇] at q̈ = 0, in base axes, Shape (6,)."""
    rest = ca.SX.zeros(len(robot.joints))
    motion = chain_motion(robot, q, dq, rest, ca.SX.zeros(3))
    w, dw, a = motion.w[-1], motion.dw[-1], motion.a[-1]
    p = ca.SX(robot.tip.p)
    R = forward_kinematics(robot, q)[-2][0]
    return ca.vertcat(R @ (a + spin(w, dw) @ p), R @ dw)
