# SPDX-License-Identifier: MIT
"""Whether the arms take the joints of a motion by themselves: then they may follow again where something has moved."""

import numpy as np

from mrts.base.errors import MotionError
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion, follow_object
from mrts.following.null_space import is_redundant

SAME_JOINTS = 1e-6
"""Largest difference of joints that are followed again, as a share of the largest of them: what Newton steps leave."""

SAME_CHOICE = 1e-4
"""The same of a redundant arm's positions: at samples that were added it is near its choice (3e-7 off of 12)."""

SAME_CHOICE_RATES = 1e-2
"""The same of its velocities and accelerations (7e-4 off)."""


def following_again(cell: Cell, motion: CoordinatedMotion) -> tuple[Cell | None, CoordinatedMotion]:
    """The cell with postures from which its arms follow the object as in a motion: its own, or where that starts.

    Where the motion starts is found again sooner, but a redundant arm stays near its posture, whatever has moved.

    Args:
        cell: The cell.
        motion: Its motion.

    Returns:
        The cell, None if its arms take other joints, as where redundant ones were given; and what they take: the motion
        as it was given where that is the same, or no cell takes it.
    """
    parts = cell.joint_slices.items()
    starts = (cell.with_postures({name: motion.q[0, part].tolist() for name, part in parts}), cell)
    redundant = any(is_redundant(cell, robot) for robot in cell.robots)
    if redundant:
        starts = starts[::-1]
    for start in starts:
        try:
            again = follow_object(start, motion.object)
        except MotionError:
            continue
        if _same(again, motion, (SAME_JOINTS,) * 3):
            return start, motion
        if redundant and _same(again, motion, (SAME_CHOICE, SAME_CHOICE_RATES, SAME_CHOICE_RATES)):
            return start, again
    return None, motion


def _same(ours: CoordinatedMotion, given: CoordinatedMotion, shares: tuple[float, float, float]) -> bool:
    """Whether q, q' and q'' differ by no more than these shares of the largest."""
    pairs = ((ours.q, given.q), (ours.dq, given.dq), (ours.ddq, given.ddq))
    return all(
        np.max(np.abs(one - other)) <= share * max(1.0, np.max(np.abs(other)))
        for (one, other), share in zip(pairs, shares, strict=True)
    )
