# SPDX-License-Identifier: MIT
"""Recursive Newton-Euler inverse dynamics of one arm and the terms of its time-scaled motion."""

from typing import Any

import casadi as ca
import numpy as np
from mrts_codegen.equations.kinematics import ChainMotion, chain_motion, spin
from mrts_codegen.urdf.robot_model import RobotModel

from mrts.base.arrays import Array


def inverse_dynamics(robot: RobotModel, q: Any, dq: Any, ddq: Any, gravity: Any) -> Any:
    """Eq. (1): joint torques of the free arm (F = 0), Shape (n,) [N m or N].

    Luh, Walker and Paul (1980); Featherstone (2008), ch. 5.3.

    Args:
        robot: The arm.
        q: Joint positions, Shape (n,) [rad or m].
        dq: Joint velocities, Shape (n,) [rad/s or m/s].
        ddq: Joint accelerations, Shape (n,) [rad/s² or m/s²].
        gravity: Downward gravity in base axes, Shape (3,) [m/s²].
    """
    motion = chain_motion(robot, q, dq, ddq, -ca.SX(gravity))
    return ca.vertcat(*transmitted_torques(robot, motion, ca.SX.zeros(3), ca.SX.zeros(3)))


def transmitted_torques(robot: RobotModel, motion: ChainMotion, force: Any, moment: Any) -> list[Any]:
    """The backward recursion: torques of the joints of an arm that moves so, and exerts a wrench at its tip [N m or N].

    Args:
        robot: The arm, n joints.
        motion: Of its joint frames, gravity as an acceleration of the base.
        force: In tip axes, Shape (3,) [N].
        moment: About the tip, in its axes, Shape (3,) [N m].
    """
    torques: list[Any] = []
    f = ca.SX(robot.tip.R) @ force
    n = ca.SX(robot.tip.R) @ moment + ca.cross(ca.SX(robot.tip.p), f)
    for index in reversed(range(len(robot.joints))):
        joint = robot.joints[index]
        w, dw = motion.w[index], motion.dw[index]
        com, inertia = ca.SX(joint.body.com), ca.SX(joint.body.at_com)
        own_f = joint.body.mass * (motion.a[index] + spin(w, dw) @ com)
        own_n = inertia @ dw + ca.cross(w, inertia @ w) + ca.cross(com, own_f)
        f, n = f + own_f, n + own_n
        axis = ca.SX(joint.axis)
        torques.insert(0, ca.dot(axis, n if joint.kind == "revolute" else f))
        R, p = motion.R[index], motion.p[index]
        f = R @ f
        n = R @ n + ca.cross(p, f)
    return torques


def scaled_arm_terms(robot: RobotModel, q: Any, dq: Any, ddq: Any, gravity: Array) -> tuple[Any, Any, Any]:
    """Eqs. (11), (12), (13): with q̇ = q' ṙ and q̈ = q'' ṙ² + q' r̈ the torque is E ṙ² + A r̈ + G (+ JᵀF).

    E = D q'' + q' C q' [N m], A = D q' [N m s²], G the gravity torque [N m], each Shape (n,).

    Args:
        robot: The arm.
        q: Joint positions, Shape (n,) [rad or m].
        dq: q', velocities of the given motion, Shape (n,) [rad/s or m/s].
        ddq: q'', accelerations of the given motion, Shape (n,) [rad/s² or m/s²].
        gravity: Downward gravity in base axes, Shape (3,) [m/s²].
    """
    rest, weightless = ca.SX.zeros(len(robot.joints)), np.zeros(3)
    return (
        inverse_dynamics(robot, q, dq, ddq, weightless),
        inverse_dynamics(robot, q, rest, dq, weightless),
        inverse_dynamics(robot, q, rest, rest, gravity),
    )


def mass_matrix(robot: RobotModel, q: Any) -> Any:
    """Mass matrix D(q), Shape (n, n) [kg m² for revolute pairs]: what the torque of an arm at rest is linear in."""
    count = len(robot.joints)
    acceleration = ca.SX.sym("ddq", count)
    torque = inverse_dynamics(robot, q, ca.SX.zeros(count), acceleration, np.zeros(3))
    return ca.densify(ca.jacobian(torque, acceleration))


def coriolis_torque(robot: RobotModel, q: Any, dq: Any) -> Any:
    """Coriolis and centrifugal torque q̇ C(q) q̇, Shape (n,) [N m or N]."""
    return inverse_dynamics(robot, q, dq, ca.SX.zeros(len(robot.joints)), np.zeros(3))
