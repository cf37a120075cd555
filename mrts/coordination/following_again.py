# SPDX-License-Identifier: MIT
"""Whether the arms take the joints of a motion by themselves: then they may follow again where something has moved."""

import numpy as np

from mrts.base.errors import MotionError
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion, follow_object

SAME_JOINTS = 1e-6
"""Largest difference of joints that are followed again, as a share of the largest of them: what Newton steps leave."""


def following_again(cell: Cell, motion: CoordinatedMotion) -> Cell | None:
    """The cell with postures from which its arms follow the object as in a motion: its own, or where that starts.

    Args:
        cell: The cell.
        motion: Its motion.

    Returns:
        None if the arms take other joints, as where redundant ones were given.
    """
    parts = cell.joint_slices.items()
    for start in (cell, cell.with_postures({name: motion.q[0, part].tolist() for name, part in parts})):
        try:
            again = follow_object(start, motion.object)
        except MotionError:
            continue
        pairs = ((again.q, motion.q), (again.dq, motion.dq), (again.ddq, motion.ddq))
        if all(np.max(np.abs(ours - given)) <= SAME_JOINTS * max(1.0, np.max(np.abs(given))) for ours, given in pairs):
            return start
    return None
