# SPDX-License-Identifier: MIT
"""Rotation matrices and rigid transforms of constant frames, reproducible bit for bit.

The generated C carries these numbers, so products avoid BLAS, whose kernels differ between processors.
"""

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from mrts.base.arrays import Array

SNAP = 1e-15
"""Entries this close to 0 or ±1 are rounding of cos(π/2) and the like; exact ones vanish from the C."""


@dataclass(frozen=True)
class RigidTransform:
    """Pose of frame b in frame a: `x_a = R x_b + p`.

    Attributes:
        R: Rotation, Shape (3, 3).
        p: Position, Shape (3,) [m].
    """

    R: Array
    p: Array

    def __matmul__(self, other: "RigidTransform") -> "RigidTransform":
        return RigidTransform(multiply(self.R, other.R), self.p + multiply(self.R, other.p))

    @property
    def numbers(self) -> Array:
        """R by rows, then p, Shape (12,)."""
        return np.concatenate([self.R.ravel(), self.p])

    @staticmethod
    def identity() -> "RigidTransform":
        """The frame itself."""
        return RigidTransform(np.eye(3), np.zeros(3))

    @staticmethod
    def from_xyz_rpy(xyz: list[float], rpy: list[float]) -> "RigidTransform":
        """Pose from a position [m] and roll, pitch, yaw [rad] in URDF's convention."""
        return RigidTransform(rotation_from_rpy(*rpy), np.array(xyz, dtype=float))


def multiply(a: Array, b: Array) -> Array:
    """Product of a matrix, Shape (r, 3), with a matrix or vector; each sum runs in index order."""
    if b.ndim == 1:
        b = b[:, None]
        return multiply(a, b)[:, 0]
    product: Array = a[:, 0:1] * b[0:1] + a[:, 1:2] * b[1:2] + a[:, 2:3] * b[2:3]
    return product


def snap_rotation(R: Array) -> Array:
    """Round entries within `SNAP` of 0 and ±1."""
    nearest = np.round(R)
    return np.where(np.abs(R - nearest) <= SNAP, nearest, R) + 0.0


def rotation_from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """Rotation Rz(yaw) Ry(pitch) Rx(roll), Shape (3, 3); angles in rad (URDF's convention)."""
    cr, sr, cp, sp, cy, sy = cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    R = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    return snap_rotation(R)
