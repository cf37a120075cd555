# SPDX-License-Identifier: MIT
"""Kinds of values that formats share, and the pose."""

from math import hypot, pi, radians
from typing import Annotated, Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.formats.record import Record, Rule
from mrts.base.input_file import IDENTIFIER, LARGEST_NUMBER, LONGEST_NAME, SMALLEST_NUMBER
from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform, rotation_from_rpy, rotations_from_quaternions, snap_rotation

Name = Annotated[str, Rule(pattern=IDENTIFIER, max_length=LONGEST_NAME)]
"""Of a cell or a robot: it stands in C text and in paths."""

Coordinate = Annotated[float, Rule(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER)]
Finite = Annotated[float, Rule(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER, smallest=SMALLEST_NUMBER)]
Positive = Annotated[float, Rule(gt=0, le=LARGEST_NUMBER, smallest=SMALLEST_NUMBER)]
Angle = Annotated[float, Rule(ge=-1e4, le=1e4)]
Angles3 = Annotated[list[Angle], Rule(min_length=3, max_length=3)]
Vector3 = Annotated[list[Coordinate], Rule(min_length=3, max_length=3)]


Quaternion = Annotated[list[Coordinate], Rule(min_length=4, max_length=4)]

ROTATIONS = ("rpy", "quaternion_wxyz", "quaternion_xyzw")
"""Keys that give a rotation; a pose has one of them."""

FEW_DIGITS = 1e-3
"""Largest difference of a unit quaternion's length from 1: printed with few digits."""

WHOLE_TURN = 2 * pi
"""An angle beyond it [rad] is rather meant in degrees."""


class Pose(Record):
    """A frame: position and rotation, which is none where none is given.

    Attributes:
        xyz: Position, Shape (3,) [m].
        rpy: Rotation R = Rz(yaw) Ry(pitch) Rx(roll), URDF's roll, pitch, yaw, Shape (3,) [rad].
        quaternion_wxyz: Rotation as a unit quaternion, its real part first, Shape (4,).
        quaternion_xyzw: The same with its real part last, as in ROS.
    """

    xyz: Vector3 = [0.0, 0.0, 0.0]  # noqa: RUF012 (each record has its own copy)
    rpy: Angles3 | None = None
    quaternion_wxyz: Quaternion | None = None
    quaternion_xyzw: Quaternion | None = None

    @property
    def transform(self) -> RigidTransform:
        """The frame."""
        return RigidTransform(self.rotation(), np.array(self.xyz, dtype=np.float64))

    def rotation(self) -> Array:
        """Of the frame, Shape (3, 3)."""
        if self.rpy is not None:
            return rotation_from_rpy(*self.rpy)
        x_to_w = self._x_to_w()
        return np.eye(3) if x_to_w is None else snap_rotation(rotations_from_quaternions(np.array(x_to_w)))

    def degrees_remarks(self, where: str) -> tuple[Remark, ...]:
        """That its angles seem to be in degrees, if one is beyond a whole turn."""
        if self.rpy is None or all(abs(angle) <= WHOLE_TURN for angle in self.rpy):
            return ()
        given, meant = (", ".join(f"{angle:.6g}" for angle in angles) for angles in (self.rpy, map(radians, self.rpy)))
        text = f"{where}.rpy is [{given}] rad: if degrees are meant, it is [{meant}]."
        return (Remark.hint("rpy-degrees", text),)

    def problem(self) -> str:
        """The rule that its keys break with each other; empty if none."""
        given = [key for key in ROTATIONS if getattr(self, key) is not None]
        if len(given) > 1:
            return f"a rotation is given once, here by {' and '.join(given)}"
        quaternion = self._x_to_w()
        length = 1.0 if quaternion is None else hypot(*quaternion)
        if abs(length - 1) > FEW_DIGITS:
            return f"a quaternion of a rotation has the length 1; the length of {given[0]} is {length:.6g}"
        return ""

    def model_dump(self) -> dict[str, Any]:
        """Keys that it has, and angles of 0 where no rotation is given."""
        known = {key: value for key, value in super().model_dump().items() if value is not None}
        return known if len(known) > 1 else known | {"rpy": [0.0, 0.0, 0.0]}

    def _x_to_w(self) -> list[float] | None:
        if self.quaternion_wxyz is not None:
            return [*self.quaternion_wxyz[1:], self.quaternion_wxyz[0]]
        return self.quaternion_xyzw
