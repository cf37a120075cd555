# SPDX-License-Identifier: MIT
"""Limits of the joint torques."""

import numpy as np

from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import LimitRows, row_names


def torque_limits(cell: Cell, _motion: CoordinatedMotion) -> LimitRows:
    """Eq. (8): τ⁻ <= τ <= τ⁺, one row a joint."""
    names = tuple(
        name for robot in cell.robots for name in row_names("torque", robot.name, robot.joints, robot.torque_units)
    )
    return LimitRows(
        names=names,
        lower=np.concatenate([robot.torque_lower for robot in cell.robots]),
        upper=np.concatenate([robot.torque_upper for robot in cell.robots]),
        torque_matrix=np.eye(len(names)),
        wrench_matrix=np.zeros((len(names), len(cell.robots) * len(cell.wrench_components))),
    )
