# SPDX-License-Identifier: MIT
"""Rotation matrices and rigid transforms of constant frames, reproducible bit for bit; frames that keep to a plane.

The generated C carries these numbers, so products avoid BLAS, whose kernels differ between processors.
"""

from dataclasses import dataclass
from math import atan2, copysign, cos, hypot, pi, sin
from typing import Any

import numpy as np

from mrts.base.arrays import Array, EqualByNumbers

SNAP = 1e-15
"""Entries this close to 0 or ±1 are rounding of cos(π/2) and the like; exact ones vanish from the C."""

ROUNDED_ANGLE = 1e-15
"""Rounding of an angle of 1 rad, by its sine and cosine."""

ANGLE_DIGITS = 15
"""Decimals of an angle: more are rounding."""

LONG_DECIMAL = 15
"""Characters of a number that nobody typed."""

ROTATION_TOLERANCE = 1e-9
"""Largest entry of R Rᵀ - I of a constant rotation, far above the rounding of a product."""

PLANE_TOLERANCE = 1e-9
"""Largest entry of a rotation that still counts as zero: 1 nm at 1 m, far below any calibration."""

SAME_PLACE = 1e-9
"""Two frames are one if no entry of their poses differs by more [m, 1]: rounding of angles in a file."""


@dataclass(frozen=True, eq=False)
class RigidTransform(EqualByNumbers):
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

    def inverse(self) -> "RigidTransform":
        """Pose of frame a in frame b."""
        return RigidTransform(self.R.T, -multiply(self.R.T, self.p))

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


def snap_rotation(R: Array, within: float = SNAP) -> Array:
    """Round entries that are as near to 0 and ±1."""
    nearest = np.round(R)
    return np.where(np.abs(R - nearest) <= within, nearest, R) + 0.0


def rotation_from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """Rotation Rz(yaw) Ry(pitch) Rx(roll), Shape (3, 3); angles in rad (URDF's convention)."""
    return snap_rotation(np.array(rpy_entries(cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw))))


def rotations_from_rpy(rpy: Array) -> Array:
    """`rotation_from_rpy` of many roll, pitch, yaw [rad], Shape (…, 3): Shape (…, 3, 3)."""
    parts = (turn(rpy[..., axis]) for axis in range(3) for turn in (np.cos, np.sin))
    return np.moveaxis(snap_rotation(np.array(rpy_entries(*parts))), (0, 1), (-2, -1))


def rpy_entries(cr: Any, sr: Any, cp: Any, sp: Any, cy: Any, sy: Any) -> list[list[Any]]:
    """Rows of that rotation, of cosines and sines of roll, pitch and yaw: numbers, arrays or symbols."""
    return [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]


def rpy_from_rotation(R: Array) -> list[float]:
    """Roll, pitch, yaw [rad] of a rotation, Shape (3, 3), to rounding; short decimals where these are as near.

    Of the two triples that any rotation has, the one with more zeros. Where pitch is ±π/2 yaw is 0.
    """
    level = hypot(R[0, 0], R[1, 0])
    pitch = atan2(-R[2, 0], level)
    yaw = atan2(R[1, 0], R[0, 0]) if level > ROUNDED_ANGLE else 0.0
    c, s = cos(yaw), sin(yaw)  # roll of what yaw leaves: near a pitch of ±π/2 it is as exact as elsewhere
    roll = atan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1])
    other = (roll - copysign(pi, roll), copysign(pi, pitch) - pitch, yaw - copysign(pi, yaw))
    least = min((roll, pitch, yaw), other, key=lambda triple: sum(abs(angle) > ROUNDED_ANGLE for angle in triple))
    short = [round(angle, ANGLE_DIGITS) for angle in least]
    return [one + 0.0 if len(repr(one)) < LONG_DECIMAL else angle for one, angle in zip(short, least, strict=True)]


def rotations_from_quaternions(quaternions: Array) -> Array:
    """Rotations, Shape (…, 3, 3), of quaternions x, y, z, w of any length but 0, Shape (…, 4)."""
    x, y, z, w = np.moveaxis(quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True), -1, 0)
    R = np.empty((*quaternions.shape[:-1], 3, 3))
    R[..., 0, 0], R[..., 0, 1], R[..., 0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    R[..., 1, 0], R[..., 1, 1], R[..., 1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    R[..., 2, 0], R[..., 2, 1], R[..., 2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    return R


def quaternions_from_rotations(R: Array) -> Array:
    """Unit quaternions x, y, z, w with w >= 0, Shape (…, 4), of rotations, Shape (…, 3, 3).

    By the largest entry of the quaternion, so that none loses digits (S. W. Shepperd, Quaternion from rotation
    matrix, Journal of Guidance and Control 1, 1978).
    """
    xx, yy, zz = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    square = np.empty((*R.shape[:-2], 4, 4))  # 4 q qᵀ
    square[..., 0, 0], square[..., 1, 1], square[..., 2, 2] = 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz
    square[..., 3, 3] = 1 + xx + yy + zz
    square[..., 0, 1] = square[..., 1, 0] = R[..., 0, 1] + R[..., 1, 0]
    square[..., 0, 2] = square[..., 2, 0] = R[..., 0, 2] + R[..., 2, 0]
    square[..., 1, 2] = square[..., 2, 1] = R[..., 1, 2] + R[..., 2, 1]
    square[..., 0, 3] = square[..., 3, 0] = R[..., 2, 1] - R[..., 1, 2]
    square[..., 1, 3] = square[..., 3, 1] = R[..., 0, 2] - R[..., 2, 0]
    square[..., 2, 3] = square[..., 3, 2] = R[..., 1, 0] - R[..., 0, 1]
    largest = np.argmax(np.diagonal(square, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(square, largest[..., None, None], axis=-2)[..., 0, :]
    q = np.where(q[..., 3:] < 0, -q, q)
    unit: Array = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return unit


def rotations_from_vectors(vectors: Array) -> Array:
    """Rotations, Shape (…, 3, 3), by rotation vectors: axis times angle, Shape (…, 3) [rad]."""
    half = np.linalg.norm(vectors, axis=-1, keepdims=True) / 2
    share = np.divide(np.sin(half), half, out=np.ones_like(half), where=half > 0)
    return rotations_from_quaternions(np.concatenate([vectors / 2 * share, np.cos(half)], axis=-1))


def vectors_from_rotations(R: Array) -> Array:
    """Rotation vectors of angles from 0 to π, Shape (…, 3) [rad], of rotations, Shape (…, 3, 3)."""
    q = quaternions_from_rotations(R)
    length = np.linalg.norm(q[..., :3], axis=-1, keepdims=True)
    turn = 2 * np.arctan2(length, q[..., 3:])
    vectors: Array = q[..., :3] * np.divide(turn, length, out=np.full_like(length, 2.0), where=length > 0)
    return vectors


def is_rotation(R: Array) -> bool:
    """Whether a matrix, Shape (3, 3), is a rotation."""
    x, y, z = R.tolist()  # numbers of Python: cells are made by the thousand
    off = [sum(a * b for a, b in zip(one, two, strict=True)) for one, two in ((x, y), (x, z), (y, z))]
    off += [sum(a * a for a in row) - 1 for row in (x, y, z)]
    volume = sum(x[i] * (y[i - 2] * z[i - 1] - y[i - 1] * z[i - 2]) for i in range(3))
    return all(abs(entry) <= ROTATION_TOLERANCE for entry in off) and volume > 0


def in_one_place(one: RigidTransform, other: RigidTransform) -> bool:
    """Whether two poses in one frame are the same."""
    return bool(max(np.max(np.abs(one.R - other.R)), np.max(np.abs(one.p - other.p))) <= SAME_PLACE)


def plane_normal(plane: str) -> Array:
    """First × second coordinate axis of a plane, Shape (3,): 'xz' has -y."""
    first, second = (np.eye(3)["xyz".index(axis)] for axis in plane)
    return np.cross(first, second)
