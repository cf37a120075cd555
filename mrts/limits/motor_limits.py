# SPDX-License-Identifier: MIT
"""What motors give at a speed: torque falls with it, and it ends."""

from dataclasses import dataclass

import numpy as np

from mrts.cell.cell import Cell
from mrts.cell.motors.joint_motors import torque_speed_lines
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import TORQUE_SPEED, LimitRows, RowName


@dataclass(frozen=True, kw_only=True)
class CurveRow:
    """One straight part of a joint's torque-speed curve: |τ| <= limit - slope |q̇|, or its end: |q̇| <= limit.

    Attributes:
        name: Of the row.
        joint: Place among all joints of the cell.
        limit: Of the torque at standstill [N m], or of the speed [rad/s].
        slope: By how much the torque falls with the speed [N m s/rad]; None at the end of a curve.
    """

    name: RowName
    joint: int
    limit: float
    slope: float | None


def curve_rows(cell: Cell) -> tuple[CurveRow, ...]:
    """The rows of all torque-speed curves of a cell, joint by joint: falling lines, then the curve's end.

    Args:
        cell: The cell.
    """
    rows = []
    for robot, part in zip(cell.robots, cell.joint_slices.values(), strict=True):
        for j, curve in enumerate(robot.motors.torque_speed):
            if curve is None:
                continue
            line = RowName(TORQUE_SPEED, robot.name, robot.joints[j], robot.torque_units[j])
            end = RowName("motor speed", robot.name, robot.joints[j], f"{robot.position_units[j]}/s")
            place = part.start + j
            rows += [CurveRow(name=line, joint=place, limit=a, slope=m) for a, m in torque_speed_lines(curve)]
            rows.append(CurveRow(name=end, joint=place, limit=float(curve[-1, 0]), slope=None))
    return tuple(rows)


def motor_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """|τ| <= a - m |q̇| for each falling line of a motor's torque-speed curve, and |q̇| up to the curve's end.

    A line holds while the motor drives, where τ and q̇ have one sign: -a <= τ + m q' ṙ <= a. Where it brakes that
    leaves more than the plain limit of the torque, which is a limit of its own.

    Args:
        cell: The cell.
        motion: Its motion.
    """
    rows, joints = curve_rows(cell), motion.q.shape[1]
    limit, place = np.array([row.limit for row in rows]), [row.joint for row in rows]
    of_torque = np.array([row.slope is not None for row in rows], dtype=bool)
    slope = np.array([1.0 if row.slope is None else row.slope for row in rows])
    return LimitRows(
        names=tuple(row.name for row in rows),
        lower=-limit,
        upper=limit,
        torque_matrix=of_torque[:, None] * np.eye(joints)[place] if rows else np.zeros((0, joints)),
        wrench_matrix=np.zeros((len(rows), len(cell.robots) * len(cell.wrench_components))),
        speed=slope * motion.dq[:, place] if rows else None,
    )
