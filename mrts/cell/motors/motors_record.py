# SPDX-License-Identifier: MIT
"""Motors as an entry of the manifest."""

from typing import Any

import numpy as np

from mrts.base.arrays import with_infinity, without_infinity
from mrts.base.manifest import MotorsRecord
from mrts.cell.motors.joint_motors import NONE_GIVEN, PER_JOINT, JointMotors


def motors_record(motors: JointMotors) -> MotorsRecord:
    """What the manifest says of the motors of an arm."""
    curves = [None if curve is None else curve.tolist() for curve in motors.torque_speed]
    columns: dict[str, Any] = {name: without_infinity(getattr(motors, name)) for name in PER_JOINT}
    return MotorsRecord(torque_speed=curves, **columns)


def motors_from_record(record: MotorsRecord) -> JointMotors:
    """The motors that an entry of a manifest describes.

    Raises:
        InputError: If a number breaks a rule of motors.
    """
    columns = {name: with_infinity(getattr(record, name), NONE_GIVEN[name]) for name in PER_JOINT}
    curves = tuple(None if curve is None else np.array(curve) for curve in record.torque_speed)
    return JointMotors(torque_speed=curves, **columns)
