# SPDX-License-Identifier: MIT
"""Limits of the joints' and the object's velocities."""

import numpy as np

from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import LimitRows, RowName, row_names


def velocity_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """-v <= q' ṙ <= v, one row a joint, and the sizes of the object's velocity; no rows if they are not enforced.

    Args:
        cell: The cell.
        motion: Its motion.
    """
    joints, wrenches = motion.dq.shape[1], len(cell.robots) * len(cell.wrench_components)
    if not cell.enforces_velocity_limits:
        none = np.zeros(0)
        return LimitRows(
            names=(),
            lower=none,
            upper=none,
            torque_matrix=np.zeros((0, joints)),
            wrench_matrix=np.zeros((0, wrenches)),
        )
    names: list[RowName] = []
    for robot in cell.robots:
        units = tuple(f"{unit}/s" for unit in robot.position_units)
        names += row_names("velocity", robot.name, robot.joints, units)
    names += row_names("velocity", "object", ("linear", "angular"), ("m/s", "rad/s"))
    x, y, z = motion.object.twist.reshape(-1, 2, 3).transpose(2, 0, 1)
    limit = np.concatenate([*(robot.velocity_limit for robot in cell.robots), cell.object_velocity_limit])
    return LimitRows(
        names=tuple(names),
        lower=np.append(-limit[:joints], [-np.inf, -np.inf]),  # the object's are sizes
        upper=limit,
        torque_matrix=np.zeros((len(names), joints)),
        wrench_matrix=np.zeros((len(names), wrenches)),
        speed=np.column_stack([motion.dq, np.sqrt(x**2 + y**2 + z**2)]),
    )
