# SPDX-License-Identifier: MIT
"""Symbolic rotations and cross products of three-vectors.

SX folds constant zeros and ones away, so exact constants here are what keeps the generated C short.
"""

from typing import Any

import casadi as ca
import numpy as np

from mrts.base.arrays import Array


def skew(v: Any) -> Any:
    """Eq. (7): matrix S(v) with S(v) u = v × u, Shape (3, 3)."""
    return ca.skew(v)


def axis_rotation(axis: Array, angle: Any) -> Any:
    """Rotation by `angle` [rad] about a constant unit `axis`, Shape (3, 3) (Rodrigues' formula)."""
    c, s = ca.cos(angle), ca.sin(angle)
    cross = skew(ca.SX(np.asarray(axis)))
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


def block_diagonal(blocks: list[Any]) -> Any:
    """Dense block-diagonal matrix of rectangular blocks."""
    return ca.densify(ca.diagcat(*blocks))
