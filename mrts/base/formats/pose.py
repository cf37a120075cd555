# SPDX-License-Identifier: MIT
"""Kinds of values that formats share, and the pose."""

from typing import Annotated

from mrts.base.formats.record import Record, Rule
from mrts.base.input_file import IDENTIFIER, LARGEST_NUMBER, LONGEST_NAME

Name = Annotated[str, Rule(pattern=IDENTIFIER, max_length=LONGEST_NAME)]
"""Of a cell or a robot: it stands in C text and in paths."""

Finite = Annotated[float, Rule(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER, allow_inf_nan=False)]
Positive = Annotated[float, Rule(gt=0, le=LARGEST_NUMBER, allow_inf_nan=False)]
Angle = Annotated[float, Rule(ge=-1e4, le=1e4, allow_inf_nan=False)]
Angles3 = Annotated[list[Angle], Rule(min_length=3, max_length=3)]
Vector3 = Annotated[list[Finite], Rule(min_length=3, max_length=3)]


class Pose(Record):
    """A frame: position and URDF roll, pitch, yaw.

    Attributes:
        xyz: Position, Shape (3,) [m].
        rpy: Rotation R = Rz(yaw) Ry(pitch) Rx(roll), Shape (3,) [rad].
    """

    xyz: Vector3 = [0.0, 0.0, 0.0]  # noqa: RUF012 (each record has its own copy)
    rpy: Angles3 = [0.0, 0.0, 0.0]  # noqa: RUF012 (likewise)
