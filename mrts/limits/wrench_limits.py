# SPDX-License-Identifier: MIT
"""Limits of the contact wrenches."""

import numpy as np

from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import LimitRows, row_names


def wrench_limits(cell: Cell, _motion: CoordinatedMotion) -> LimitRows:
    """Eq. (24): F_min <= F_i <= F_max in the axes of robot i's base, one row a component."""
    components, units = cell.wrench_components, cell.wrench_units
    names = tuple(name for robot in cell.robots for name in row_names("wrench", robot.name, components, units))
    joints = sum(len(robot.joints) for robot in cell.robots)
    return LimitRows(
        names=names,
        lower=np.concatenate([robot.wrench_lower for robot in cell.robots]),
        upper=np.concatenate([robot.wrench_upper for robot in cell.robots]),
        torque_matrix=np.zeros((len(names), joints)),
        wrench_matrix=np.eye(len(names)),
    )
