# SPDX-License-Identifier: MIT
"""Limits of the joint torques."""

import numpy as np

from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import LimitRows, RowName


def torque_limits(cell: Cell, _motion: CoordinatedMotion) -> LimitRows:
    """Eq. (8): τ⁻ <= τ <= τ⁺, one row a joint."""
    names = tuple(
        RowName("torque", robot.name, joint, unit)
        for robot in cell.robots
        for joint, unit in zip(robot.joints, robot.torque_units, strict=True)
    )
    return LimitRows(
        names=names,
        lower=np.concatenate([robot.torque_lower for robot in cell.robots]),
        upper=np.concatenate([robot.torque_upper for robot in cell.robots]),
        torque_matrix=np.eye(len(names)),
        wrench_matrix=np.zeros((len(names), len(cell.robots) * len(cell.wrench_components))),
    )
