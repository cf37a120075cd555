# SPDX-License-Identifier: MIT
"""One arm with another pose or other limits, under the rules of the cell file."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.broken_record import BrokenRecordError, broken_record
from mrts.base.formats.pose import Angles3, Finite, Vector3
from mrts.base.formats.record import checked
from mrts.base.input_file import plain
from mrts.base.rigid_transform import RigidTransform, rotation_from_rpy
from mrts.cell.hands.wrench_limits import given_wrench_limits
from mrts.cell.motors.torque_limits import given_torque_limits
from mrts.cell.robot import Robot

Numbers = Sequence[float] | Array
Bounds = Sequence[float | None] | Array | None


def vector(where: str, key: str, value: object) -> Array:
    """A vector as a cell file has it, Shape (3,).

    Args:
        where: What it belongs to, for messages.
        key: What it is called there.
        value: What was given.

    Raises:
        InputError: Unless it is three finite numbers.
    """
    return np.array(_given(where, key, value, Vector3))


def pose_from(where: str, xyz: Numbers, rpy: Numbers) -> RigidTransform:
    """A pose as a cell file has it.

    Args:
        where: What it belongs to, for messages.
        xyz: Position, Shape (3,) [m].
        rpy: Roll, pitch, yaw in URDF's convention, Shape (3,) [rad].

    Raises:
        InputError: If a value breaks a rule of the cell file.
    """
    return RigidTransform(rotation_from_rpy(*_given(where, "rpy", rpy, Angles3)), vector(where, "xyz", xyz))


def posed(robot: Robot, key: str, T: RigidTransform, xyz: Numbers | None, rpy: Numbers | None) -> RigidTransform:
    """A pose with another position, another rotation, or both.

    Args:
        robot: Whose it is.
        key: What it is called in a cell file.
        T: The pose.
        xyz: Position, Shape (3,) [m]; None keeps it.
        rpy: Roll, pitch, yaw in URDF's convention, Shape (3,) [rad]; None keeps the rotation.

    Raises:
        InputError: If a value breaks a rule of the cell file.
    """
    where = _where(robot)
    R = T.R if rpy is None else rotation_from_rpy(*_given(where, f"{key}.rpy", rpy, Angles3))
    return RigidTransform(R, T.p if xyz is None else vector(where, f"{key}.xyz", xyz))


def torque_limited(robot: Robot, upper: Numbers, lower: Numbers | None) -> Robot:
    """A robot with other torque limits; see `mrts.Cell.with_torque_limits`.

    Raises:
        InputError: If a value breaks a rule of the cell file.
    """
    where = _where(robot)
    most = _given(where, "torque.upper", upper, list[Finite])
    least = None if lower is None else _given(where, "torque.lower", lower, list[Finite])
    limits = given_torque_limits(where, "torque", least, most, robot.joints)
    return replace(robot, torque_lower=limits[0], torque_upper=limits[1])


def wrench_limited(robot: Robot, lower: Bounds, upper: Bounds) -> Robot:
    """A robot with other bounds of its contact wrench; see `mrts.Cell.with_wrench_limits`.

    Raises:
        InputError: If a value breaks a rule of the cell file.
    """
    where = _where(robot)
    least = _given(where, "wrench.lower", _without(lower, -np.inf), list[Finite | None] | None)
    most = _given(where, "wrench.upper", _without(upper, np.inf), list[Finite | None] | None)
    limits = given_wrench_limits(where, "wrench", least, most, len(robot.wrench_lower))
    return replace(robot, wrench_lower=limits[0], wrench_upper=limits[1])


def _where(robot: Robot) -> str:
    return f"robot '{robot.name}'"


def _without(values: object, unbounded: float) -> object:
    """Bounds with None in place of the infinity that stands for none."""
    listed = values.tolist() if isinstance(values, np.ndarray) else values
    if not isinstance(listed, list | tuple):
        return listed
    return [None if isinstance(value, float) and value == unbounded else value for value in listed]


def _given(where: str, key: str, value: object, kind: Any) -> Any:
    """A value as a cell file would have it."""
    try:
        return checked(kind, plain(where, value))
    except BrokenRecordError as error:
        broken = broken_record(where, error)
    raise InputError(where, broken.rule, key=key + broken.key, value=broken.value)
