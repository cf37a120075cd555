# SPDX-License-Identifier: MIT
"""The wrench that the carried object needs: P ṙ² + S r̈ + Q."""

from dataclasses import dataclass
from typing import Any

import casadi as ca
from mrts_codegen.spatial_algebra import cross

from mrts.rigid_transform import Array

LOAD_ENTRIES = ("mass", "ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Layout of the load vector: kg and kg m², at the com in the object frame."""


@dataclass(frozen=True)
class ObjectTerms:
    """Balance of the object, forces on top of moments about the com, world axes.

    Attributes:
        P: Inertial wrench of the given motion, Shape (w,) [N, N m].
        S: Wrench per time-warp acceleration, Shape (w,) [N s², N m s²].
        Q: Wrench that carries the weight, Shape (w,) [N, N m].
    """

    P: Any
    S: Any
    Q: Any


def load_inertia(load: Any) -> Any:
    """Inertia at the com in the object frame from a load vector (`LOAD_ENTRIES`), Shape (3, 3) [kg m²]."""
    _, ixx, iyy, izz, ixy, ixz, iyz = (load[index] for index in range(len(LOAD_ENTRIES)))
    return ca.vertcat(ca.horzcat(ixx, ixy, ixz), ca.horzcat(ixy, iyy, iyz), ca.horzcat(ixz, iyz, izz))


def linear_balance(mass: Any, acceleration: Any, gravity: Array) -> tuple[Any, Any]:
    """Eq. (3): force that the contacts give, m p̈ + m g with g upward positive.

    Args:
        mass: [kg].
        acceleration: p'' of the com in world axes, Shape (3,) [m/s²].
        gravity: Downward gravity in world axes, Shape (3,) [m/s²].

    Returns:
        Inertial force and force that carries the weight, each Shape (3,) [N].
    """
    return mass * acceleration, -mass * ca.SX(gravity)


def angular_balance(inertia: Any, w: Any, dw: Any) -> Any:
    """Eq. (4): moment about the com that the contacts give, I_w ω̇ + ω × I_w ω, Shape (3,) [N m].

    Args:
        inertia: Inertia in world axes, Shape (3, 3) [kg m²].
        w: Angular velocity in world axes, Shape (3,) [rad/s].
        dw: Angular acceleration in world axes, Shape (3,) [rad/s²].
    """
    return inertia @ dw + cross(w, inertia @ w)


def object_terms(
    load: Any, R_world_object: Any, twist: Any, acceleration: Any, gravity: Array, components: tuple[int, ...]
) -> ObjectTerms:
    """Eqs. (5), (15), (16), (17), (18): both balances stacked, split by powers of ṙ and r̈.

    Args:
        load: Load vector, `LOAD_ENTRIES`.
        R_world_object: Rotation of the object, Shape (3, 3).
        twist: p' and φ' of the given motion in world axes, Shape (6,) [m/s, rad/s].
        acceleration: p'' and φ'' in world axes, Shape (6,) [m/s², rad/s²].
        gravity: Downward gravity in world axes, Shape (3,) [m/s²].
        components: Rows of the six-component wrench in use.
    """
    I_w = R_world_object @ load_inertia(load) @ R_world_object.T
    inertial, weight = linear_balance(load[0], acceleration[:3], gravity)
    P = ca.vertcat(inertial, angular_balance(I_w, twist[3:], acceleration[3:]))
    S = ca.vertcat(load[0] * twist[:3], I_w @ twist[3:])
    Q = ca.vertcat(weight, ca.SX.zeros(3))
    rows = list(components)
    return ObjectTerms(ca.densify(P[rows]), ca.densify(S[rows]), ca.densify(Q[rows]))
