# SPDX-License-Identifier: MIT
"""Arms that hold the object or come as near as they can: of a cell that stands, or along a motion out of reach."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.collisions.bodies import tip_at_posture
from mrts.following.tracking import FURTHER_STEPS, reached, solve_grasps
from mrts.motion.object_motion import ObjectMotion
from mrts.scene.scene import Scene

MOST_SAMPLES = 41
"""Samples that are looked at: a picture of where arms end needs no more."""


@dataclass(frozen=True, eq=False, kw_only=True)
class HeldPoses:
    """Where arms are at k poses of the object, by joint positions that come nearest.

    Attributes:
        gap: What is left between tip and grasp, Shape (k, robots) [m].
        reached: Whether an arm holds its grasp, Shape (k, robots); by itself, perhaps in another branch.
        message: Why some arm cannot follow the motion, with robot, sample and amount; empty where none was given.
    """

    scene: Scene
    gap: Array
    reached: NDArray[np.bool_]
    message: str = ""


def still_motion(cell: Cell) -> ObjectMotion:
    """The object at rest where the first arm holds it at its posture."""
    robot = cell.robots[0]
    held = tip_at_posture(robot) @ robot.T_object_tip.inverse()
    rest = np.zeros((2, 6))
    return ObjectMotion(np.array([0.0, 1.0]), np.tile(held.p, (2, 1)), np.tile(held.R, (2, 1, 1)), rest, rest)


def held_poses(cell: Cell, motion: ObjectMotion, message: str = "") -> HeldPoses:
    """How near arms come to their grasps along a motion that they cannot follow, or one as of `still_motion`."""
    count = min(MOST_SAMPLES, len(motion.time))
    samples = np.unique(np.linspace(0, len(motion.time) - 1, count).round().astype(np.intp))
    held = solve_grasps(cell, motion, samples, np.tile(cell.posture, (len(samples), 1)), FURTHER_STEPS, near=None)
    holds = reached(held)
    carried = motion.time[samples], held.q, motion.position[samples], motion.rotation[samples]
    scene = Scene(cell, *carried, passed=~np.all(holds, axis=1))
    return HeldPoses(scene=scene, gap=held.gap, reached=holds, message=message)
