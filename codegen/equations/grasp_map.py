# SPDX-License-Identifier: MIT
"""Grasp maps: from a contact wrench in base axes to its effect on the object in world axes."""

from typing import Any

import casadi as ca
from mrts_codegen.equations.spatial_algebra import skew

from mrts.base.arrays import Array


def contact_offset(R_world_object: Any, r_object_tip: Array) -> Any:
    """Eq. (2): contact point minus com in world axes, R r_i, Shape (3,) [m]."""
    return R_world_object @ ca.SX(r_object_tip)


def grasp_map(offset: Any, R_world_base: Array, components: tuple[int, ...]) -> Any:
    """Eq. (6): B_i with [force; moment about the com] = B_i F_i, Shape (w, w).

    Args:
        offset: Contact point minus com in world axes, Shape (3,) [m].
        R_world_base: Base of the robot in the world, Shape (3, 3).
        components: Rows of the six-component wrench in use.
    """
    R = ca.SX(R_world_base)
    B = ca.vertcat(ca.horzcat(R, ca.SX.zeros(3, 3)), ca.horzcat(skew(offset) @ R, R))
    return ca.densify(B[list(components), list(components)])


def grasp_map_inverse(offset: Any, R_world_base: Array, components: tuple[int, ...]) -> Any:
    """Inverse of `grasp_map`, exact for every grasp: [Rᵀ, 0; -Rᵀ S, Rᵀ], Shape (w, w)."""
    R = ca.SX(R_world_base)
    inverse = ca.vertcat(ca.horzcat(R.T, ca.SX.zeros(3, 3)), ca.horzcat(-R.T @ skew(offset), R.T))
    return ca.densify(inverse[list(components), list(components)])
