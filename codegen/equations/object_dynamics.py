# SPDX-License-Identifier: MIT
"""The wrench that the carried object needs, P ṙ² + S r̈ + Q, and what contact wrenches give of it: grasp maps."""

from typing import Any

import casadi as ca

from mrts.base.arrays import Array
from mrts.base.manifest import LOAD_ENTRIES


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
