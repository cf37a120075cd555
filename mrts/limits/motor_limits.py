# SPDX-License-Identifier: MIT
"""What motors give at a speed: torque falls with it, and it ends."""

import numpy as np

from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import LimitRows, RowName
from mrts.motors.joint_motors import torque_speed_lines


def motor_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """|τ| <= a - m |q̇| for each falling line of a motor's torque-speed curve, and |q̇| up to the curve's end.

    A line holds while the motor drives, where τ and q̇ have one sign: -a <= τ + m q' ṙ <= a. Where it brakes that
    leaves more than the plain limit of the torque, which is a limit of its own.

    Args:
        cell: The cell.
        motion: Its motion.
    """
    names: list[RowName] = []
    limit: list[float] = []
    joints, driving, speed = motion.q.shape[1], [], []
    for robot, start in zip(cell.robots, (part.start for part in cell.joint_slices.values()), strict=True):
        for j, curve in enumerate(robot.motors.torque_speed):
            if curve is None:
                continue
            unit = f"{robot.position_units[j]}/s"
            lines = [(a, m, 1.0, "torque-speed", robot.torque_units[j]) for a, m in torque_speed_lines(curve)]
            for a, m, with_torque, kind, measured in [*lines, (float(curve[-1, 0]), 1.0, 0.0, "motor speed", unit)]:
                names.append(RowName(kind, robot.name, robot.joints[j], measured))
                limit.append(a)
                driving.append(with_torque * np.eye(joints)[start + j])
                speed.append(m * motion.dq[:, start + j])
    return LimitRows(
        names=tuple(names),
        lower=-np.array(limit),
        upper=np.array(limit),
        torque_matrix=np.reshape(driving, (len(names), joints)),
        wrench_matrix=np.zeros((len(names), len(cell.robots) * len(cell.wrench_components))),
        speed=np.reshape(speed, (len(names), motion.samples)).T if names else None,
    )
