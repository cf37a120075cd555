"""Torque-speed curves as rows."""

from dataclasses import replace

import numpy as np
import pytest

import mrts
from mrts.cell.motors import JointMotors
from mrts.limits.cell_limits import motor_limits

CURVE = np.array([[0.0, 90.0], [2.0, 90.0], [4.0, 60.0], [5.0, 10.0]])


@pytest.mark.quick
def test_rows_hold_exactly_what_the_curve_admits(planar_cell, lift):
    """By membership, with the plain limits of the torque: 10⁴ torques and speeds in both directions."""
    robot = planar_cell.robots[0]
    unknown = JointMotors.unknown(3)
    names = [name for name in JointMotors.__dataclass_fields__ if name != "torque_speed"]
    motors = JointMotors(torque_speed=(CURVE, None, None), **{name: getattr(unknown, name) for name in names})
    limit = np.array([90.0, 80.0, 50.0])
    robots = (replace(robot, motors=motors, torque_lower=-limit, torque_upper=limit), *planar_cell.robots[1:])
    cell, motion = replace(planar_cell, robots=robots), mrts.follow_object(planar_cell, lift)
    rows = motor_limits(cell, motion)
    assert [name.kind for name in rows.names] == ["torque-speed", "torque-speed", "motor speed"]
    rng, joints = np.random.default_rng(3), motion.q.shape[1]
    for _ in range(100):
        torque, speed = np.zeros((motion.samples, joints)), rng.uniform(0, 12)
        torque[:, 0] = rng.uniform(-90, 90, motion.samples)
        value = rows.value(torque, np.zeros((motion.samples, 6)), 0.0, speed)
        kept = np.all((value >= rows.lower) & (value <= rows.upper), axis=1)
        velocity = speed * motion.dq[:, 0]
        most = np.interp(np.abs(velocity), CURVE[:, 0], CURVE[:, 1])
        drives = torque[:, 0] * velocity > 0
        admitted = (np.abs(velocity) <= 5.0) & (~drives | (np.abs(torque[:, 0]) <= most))
        assert np.array_equal(kept, admitted)
