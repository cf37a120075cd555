# SPDX-License-Identifier: MIT
"""Where arms do not reach their grasps: how near every one comes at every sample, to be shown as gaps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.inverse_kinematics.grasp_tracking import POSE_TOLERANCE, solve_grasps
from mrts.inverse_kinematics.starting_positions import FURTHER_STEPS
from mrts.motion.object_motion import ObjectMotion

MOST_SAMPLES = 41
"""Samples that are looked at: a picture of where arms end needs no more."""


@dataclass(frozen=True, eq=False)
class Unreached:
    """A motion that some arm cannot follow.

    Attributes:
        cell: The cell.
        motion: Motion of the object.
        message: Why, with robot, sample and amount.
        time: Of the samples looked at, k of them, Shape (k,) [s].
        position: Of the object there, Shape (k, 3) [m].
        rotation: Likewise, Shape (k, 3, 3).
        q: Joint positions that come nearest, Shape (k, m) [rad or m].
        gap: What is left between tip and grasp, Shape (k, robots) [m].
        reached: Whether an arm holds its grasp, Shape (k, robots); by itself, perhaps in another branch.
    """

    cell: Cell
    motion: ObjectMotion
    message: str
    time: Array
    position: Array
    rotation: Array
    q: Array
    gap: Array
    reached: NDArray[np.bool_]

    @property
    def first(self) -> int | None:
        """The first sample looked at where some arm does not reach; None where each could be reached by itself."""
        lost = np.flatnonzero(~np.all(self.reached, axis=1))
        return int(lost[0]) if lost.size else None

    def nearest(self, time: float) -> int:
        """Index of the sample looked at that is nearest to a time [s]."""
        return int(np.argmin(np.abs(self.time - time)))


def find_unreached(cell: Cell, motion: ObjectMotion, message: str) -> Unreached:
    """How near the arms come to their grasps.

    Args:
        cell: The cell.
        motion: Motion of the object, which the arms cannot follow.
        message: Why.
    """
    count = min(MOST_SAMPLES, len(motion.time))
    samples = np.unique(np.linspace(0, len(motion.time) - 1, count).round().astype(np.intp))
    start = np.concatenate([robot.posture for robot in cell.robots])
    starts = np.tile(start, (len(samples), 1))
    held = solve_grasps(cell, motion, samples, starts, FURTHER_STEPS, None)
    return Unreached(
        cell=cell,
        motion=motion,
        message=message,
        time=motion.time[samples],
        position=motion.position[samples],
        rotation=motion.rotation[samples],
        q=held.q,
        gap=held.gap,
        reached=np.maximum(held.gap, held.turn) <= POSE_TOLERANCE,
    )
