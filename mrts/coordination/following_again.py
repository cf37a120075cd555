# SPDX-License-Identifier: MIT
"""Whether the arms take the joints of a motion by themselves: then they may follow again where something has moved."""

import numpy as np

from mrts.base.errors import MotionError
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion, follow_object
from mrts.inverse_kinematics.null_space import is_redundant

SAME_JOINTS = 1e-6
"""Largest difference of joints that are followed again, as a share of the largest of them: what Newton steps leave."""


def following_again(cell: Cell, motion: CoordinatedMotion) -> Cell | None:
    """The cell with postures from which its arms follow the object as in a motion: its own, or where that starts.

    Where the motion starts is found again sooner, but a redundant arm stays near its posture, whatever has moved.

    Args:
        cell: The cell.
        motion: Its motion.

    Returns:
        None if the arms take other joints, as where redundant ones were given.
    """
    parts = cell.joint_slices.items()
    starts = (cell.with_postures({name: motion.q[0, part].tolist() for name, part in parts}), cell)
    if any(is_redundant(cell, robot) for robot in cell.robots):
        starts = starts[::-1]
    for start in starts:
        try:
            again = follow_object(start, motion.object)
        except MotionError:
            continue
        pairs = ((again.q, motion.q), (again.dq, motion.dq), (again.ddq, motion.ddq))
        if all(np.max(np.abs(ours - given)) <= SAME_JOINTS * max(1.0, np.max(np.abs(given))) for ours, given in pairs):
            return start
    return None
