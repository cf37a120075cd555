# SPDX-License-Identifier: MIT
"""One arm in its base frame: kinematics, recursive Newton-Euler dynamics, and the terms of its time-scaled motion.

The wrench that the carried object needs, P ṙ² + S r̈ + Q, and what contact wrenches give of it: grasp maps.

SX folds constant zeros and ones away, so exact constants here are what keeps the generated C short.
"""

from typing import Any

import casadi as ca
import numpy as np
from mrts_codegen.urdf.robot_model import Joint, RobotModel

from mrts.base.arrays import Array
from mrts.base.manifest import LOAD_ENTRIES


def axis_rotation(axis: Array, angle: Any) -> Any:
    """Rotation by `angle` [rad] about a constant unit `axis`, Shape (3, 3) (Rodrigues' formula)."""
    c, s = ca.cos(angle), ca.sin(angle)
    cross = ca.skew(ca.SX(np.asarray(axis)))
    R = s * cross
    for row in range(3):
        for column in range(3):
            outer = float(axis[row] * axis[column])
            if row != column:
                R[row, column] += outer * (1 - c)
            elif outer == 1.0:
                R[row, column] = 1
            else:
                R[row, column] += c + outer * (1 - c)
    return R


ChainMotion = list[tuple[Any, Any, Any, Any, Any]]
"""Of each joint's moved frame: its rotation, Shape (3, 3), and origin, Shape (3,) [m], in the frame before; in its own
axes angular velocity [rad/s] and acceleration [rad/s²], and the acceleration of its origin [m/s²], each Shape (3,)."""


Steps = list[tuple[Any, Any]]
"""Pose of each joint's moved frame in the frame before it: rotation, Shape (3, 3), and position, Shape (3,) [m]."""


def joint_steps(robot: RobotModel, q: Any) -> Steps:
    """Those of an arm at joint positions q, Shape (n,) [rad or m], which all that is told of it takes."""
    return [_joint_step(joint, q[index]) for index, joint in enumerate(robot.joints)]


def _joint_step(joint: Joint, q: Any) -> tuple[Any, Any]:
    R, p = ca.SX(joint.placement.R), ca.SX(joint.placement.p)
    if joint.kind == "revolute":
        return R @ axis_rotation(joint.axis, q), p
    return R, p + R @ (ca.SX(joint.axis) * q)


def forward_kinematics(robot: RobotModel, steps: Steps) -> list[tuple[Any, Any]]:
    """Rotation, Shape (3, 3), and origin, Shape (3,) [m], of all joints' moved frames and the tip in the base frame."""
    R, p = ca.SX.eye(3), ca.SX.zeros(3)
    frames = []
    for R_step, p_step in (*steps, (ca.SX(robot.tip.R), ca.SX(robot.tip.p))):
        p = p + R @ p_step
        R = R @ R_step
        frames.append((R, p))
    return frames


def frame_jacobian(robot: RobotModel, steps: Steps) -> Any:
    """Jacobian J of the tip: [v; ω] = J q̇ in base axes, Shape (6, n)."""
    *frames, (_, p_tip) = forward_kinematics(robot, steps)
    columns = []
    for joint, (R, p) in zip(robot.joints, frames, strict=True):
        axis = R @ ca.SX(joint.axis)
        if joint.kind == "revolute":
            columns.append(ca.vertcat(ca.cross(axis, p_tip - p), axis))
        else:
            columns.append(ca.vertcat(axis, ca.SX.zeros(3)))
    return ca.horzcat(*columns)


def chain_motion(robot: RobotModel, steps: Steps, dq: Any, ddq: Any, base_acceleration: Any) -> ChainMotion:
    """Forward recursion of velocities and accelerations (Featherstone 2008, ch. 5.3, in three-vectors).

    Args:
        robot: The arm.
        steps: Of its joints, see `joint_steps`.
        dq: Joint velocities, Shape (n,) [rad/s or m/s].
        ddq: Joint accelerations, Shape (n,) [rad/s² or m/s²].
        base_acceleration: Acceleration of the base in base axes, Shape (3,) [m/s²].
    """
    motion: ChainMotion = []
    w, dw, a = ca.SX.zeros(3), ca.SX.zeros(3), ca.SX(base_acceleration)
    for index, (joint, (R, p)) in enumerate(zip(robot.joints, steps, strict=True)):
        axis = ca.SX(joint.axis)
        a = R.T @ (a + spin(w, dw) @ p)
        w, dw = R.T @ w, R.T @ dw
        if joint.kind == "revolute":
            dw = dw + axis * ddq[index] + ca.cross(w, axis) * dq[index]
            w = w + axis * dq[index]
        else:
            a = a + axis * ddq[index] + 2 * ca.cross(w, axis) * dq[index]
        motion.append((R, p, w, dw, a))
    return motion


def spin(w: Any, dw: Any) -> Any:
    """The matrix of a ↦ ω̇ × a + ω × (ω × a), Shape (3, 3)."""
    products = w @ w.T
    return ca.skew(dw) + products - ca.trace(products) * ca.SX.eye(3)


def bias_acceleration(robot: RobotModel, steps: Steps, dq: Any) -> Any:
    """J̇q̇ of the tip, the acceleration [v̇; ω̇] at q̈ = 0, in base axes, Shape (6,)."""
    rest = ca.SX.zeros(len(robot.joints))
    *_, w, dw, a = chain_motion(robot, steps, dq, rest, ca.SX.zeros(3))[-1]
    p = ca.SX(robot.tip.p)
    R = forward_kinematics(robot, steps)[-2][0]
    return ca.vertcat(R @ (a + spin(w, dw) @ p), R @ dw)


def inverse_dynamics(robot: RobotModel, steps: Steps, dq: Any, ddq: Any, gravity: Any) -> Any:
    """Eq. (1): joint torques of the free arm (F = 0), Shape (n,) [N m or N].

    Luh, Walker and Paul (1980); Featherstone (2008), ch. 5.3.

    Args:
        robot: The arm.
        steps: Of its joints, see `joint_steps`.
        dq: Joint velocities, Shape (n,) [rad/s or m/s].
        ddq: Joint accelerations, Shape (n,) [rad/s² or m/s²].
        gravity: Downward gravity in base axes, Shape (3,) [m/s²].
    """
    motion = chain_motion(robot, steps, dq, ddq, -ca.SX(gravity))
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
    for joint, (R, p, w, dw, a) in zip(reversed(robot.joints), reversed(motion), strict=True):
        com, inertia = ca.SX(joint.body.com), ca.SX(joint.body.at_com)
        own_f = joint.body.mass * (a + spin(w, dw) @ com)
        own_n = inertia @ dw + ca.cross(w, inertia @ w) + ca.cross(com, own_f)
        f, n = f + own_f, n + own_n
        axis = ca.SX(joint.axis)
        torques.insert(0, ca.dot(axis, n if joint.kind == "revolute" else f))
        f = R @ f
        n = R @ n + ca.cross(p, f)
    return torques


def scaled_arm_terms(robot: RobotModel, steps: Steps, dq: Any, ddq: Any, gravity: Array) -> tuple[Any, Any, Any]:
    """Eqs. (11), (12), (13): with q̇ = q' ṙ and q̈ = q'' ṙ² + q' r̈ the torque is E ṙ² + A r̈ + G (+ JᵀF).

    E = D q'' + q' C q' [N m], A = D q' [N m s²], G the gravity torque [N m], each Shape (n,).

    Args:
        robot: The arm.
        steps: Of its joints, see `joint_steps`.
        dq: q', velocities of the given motion, Shape (n,) [rad/s or m/s].
        ddq: q'', accelerations of the given motion, Shape (n,) [rad/s² or m/s²].
        gravity: Downward gravity in base axes, Shape (3,) [m/s²].
    """
    rest, weightless = ca.SX.zeros(len(robot.joints)), np.zeros(3)
    return (
        inverse_dynamics(robot, steps, dq, ddq, weightless),
        inverse_dynamics(robot, steps, rest, dq, weightless),
        inverse_dynamics(robot, steps, rest, rest, gravity),
    )


def mass_matrix(robot: RobotModel, steps: Steps) -> Any:
    """Mass matrix D(q), Shape (n, n) [kg m² for revolute pairs]: what the torque of an arm at rest is linear in."""
    count = len(robot.joints)
    acceleration = ca.SX.sym("ddq", count)
    torque = inverse_dynamics(robot, steps, ca.SX.zeros(count), acceleration, np.zeros(3))
    return ca.densify(ca.jacobian(torque, acceleration))


def coriolis_torque(robot: RobotModel, steps: Steps, dq: Any) -> Any:
    """Coriolis and centrifugal torque q̇ C(q) q̇, Shape (n,) [N m or N]."""
    return inverse_dynamics(robot, steps, dq, ca.SX.zeros(len(robot.joints)), np.zeros(3))


def load_inertia(load: Any) -> Any:
    """Inertia about the object frame's origin in its axes from a load vector, Shape (3, 3) [kg m²]."""
    ixx, iyy, izz, ixy, ixz, iyz = (load[LOAD_ENTRIES.index(name)] for name in LOAD_ENTRIES[4:])
    return ca.vertcat(ca.horzcat(ixx, ixy, ixz), ca.horzcat(ixy, iyy, iyz), ca.horzcat(ixz, iyz, izz))


def linear_balance(mass: Any, h: Any, acceleration: Any, w: Any, dw: Any) -> Any:
    """Eq. (3): inertial force m p̈ + ω̇ × h + ω × (ω × h), Shape (3,) [N]; h = 0 where the com is the origin.

    Args:
        mass: [kg].
        h: First moment m (com - origin) in world axes, Shape (3,) [kg m].
        acceleration: p'' of the origin in world axes, Shape (3,) [m/s²].
        w: Angular velocity in world axes, Shape (3,) [rad/s].
        dw: Angular acceleration in world axes, Shape (3,) [rad/s²].
    """
    return mass * acceleration + ca.cross(dw, h) + ca.cross(w, ca.cross(w, h))


def angular_balance(inertia: Any, h: Any, acceleration: Any, w: Any, dw: Any) -> Any:
    """Eq. (4): moment about the origin, I_w ω̇ + ω × I_w ω + h × p̈, Shape (3,) [N m]; h = 0 in the paper.

    Args:
        inertia: Inertia about the origin in world axes, Shape (3, 3) [kg m²].
        h: First moment m (com - origin) in world axes, Shape (3,) [kg m].
        acceleration: p'' of the origin in world axes, Shape (3,) [m/s²].
        w: Angular velocity in world axes, Shape (3,) [rad/s].
        dw: Angular acceleration in world axes, Shape (3,) [rad/s²].
    """
    return inertia @ dw + ca.cross(w, inertia @ w) + ca.cross(h, acceleration)


def object_terms(
    load: Any, R_world_object: Any, twist: Any, acceleration: Any, gravity: Array, components: list[int]
) -> tuple[Any, Any, Any]:
    """Eqs. (5), (15), (16), (17), (18): P, S and Q, each Shape (w,) [N, N m, of S times s²], linear in the load.

    Both balances stacked, forces on top of moments about the object frame's origin, world axes: P ṙ² + S r̈ + Q is the
    wrench that the object needs.

    Args:
        load: Load vector, `LOAD_ENTRIES`.
        R_world_object: Rotation of the object, Shape (3, 3).
        twist: p' and φ' of the given motion in world axes, Shape (6,) [m/s, rad/s].
        acceleration: p'' and φ'' in world axes, Shape (6,) [m/s², rad/s²].
        gravity: Downward gravity in world axes, Shape (3,) [m/s²].
        components: Rows of the six-component wrench in use.
    """
    I_w = R_world_object @ load_inertia(load) @ R_world_object.T
    m, h = load[0], R_world_object @ load[1:4]
    v, w = twist[:3], twist[3:]
    a, dw = acceleration[:3], acceleration[3:]
    upward = -ca.SX(gravity)  # the weight acts like an acceleration upward
    P = ca.vertcat(linear_balance(m, h, a, w, dw), angular_balance(I_w, h, a, w, dw))
    S = ca.vertcat(m * v + ca.cross(w, h), I_w @ w + ca.cross(h, v))
    Q = ca.vertcat(m * upward, ca.cross(h, upward))
    return ca.densify(P[components]), ca.densify(S[components]), ca.densify(Q[components])


def contact_offset(R_world_object: Any, r_object_tip: Array) -> Any:
    """Eq. (2): contact point minus com in world axes, R r_i, Shape (3,) [m]."""
    return R_world_object @ ca.SX(r_object_tip)


def grasp_map(offset: Any, R_world_base: Array, components: list[int]) -> Any:
    """Eqs. (6), (7): B_i with [force; moment about the com] = B_i F_i, of S_i u = r_i × u, Shape (w, w).

    Args:
        offset: Contact point minus com in world axes, Shape (3,) [m].
        R_world_base: Base of the robot in the world, Shape (3, 3).
        components: Rows of the six-component wrench in use.
    """
    R = ca.SX(R_world_base)
    B = ca.vertcat(ca.horzcat(R, ca.SX.zeros(3, 3)), ca.horzcat(ca.skew(offset) @ R, R))
    return ca.densify(B[components, components])


def grasp_map_inverse(offset: Any, R_world_base: Array, components: list[int]) -> Any:
    """Inverse of `grasp_map`, exact for every grasp: [Rᵀ, 0; -Rᵀ S, Rᵀ], Shape (w, w)."""
    R = ca.SX(R_world_base)
    inverse = ca.vertcat(ca.horzcat(R.T, ca.SX.zeros(3, 3)), ca.horzcat(-R.T @ ca.skew(offset), R.T))
    return ca.densify(inverse[components, components])
