# SPDX-License-Identifier: MIT
"""Where the search for joint positions at t = 0 begins."""

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot

FURTHER_STARTS = 40
"""Starts tried where the posture leads to nothing: an arm of six joints has up to 16 branches."""

SEED = 13

SPREAD = 2.0
"""The further starts reach from the posture to this far from it in every joint, evenly [rad or m]."""


def starting_reference(cell: Cell) -> Array:
    """The postures of all arms, moved inside their limits where they are not, Shape (m,) [rad or m]."""
    inside = [np.clip(robot.posture, robot.position_lower, robot.position_upper) for robot in cell.robots]
    return np.concatenate(inside)


def further_starts(robot: Robot, posture: Array) -> Array:
    """Where the search goes on from where an arm's posture leads to nothing, Shape (…, FURTHER_STARTS, n_i).

    Always the same: the middle of its limits, and random ones farther and farther from the posture.

    Args:
        robot: The arm.
        posture: Shape (…, n_i) [rad or m].
    """
    low, high = robot.position_lower, robot.position_upper
    steps = np.linspace(0, SPREAD, FURTHER_STARTS)[:, None]
    turns = np.random.default_rng(SEED).uniform(-1, 1, (FURTHER_STARTS, len(robot.joints)))
    starts: Array = np.clip(posture[..., None, :] + steps * turns, low, high)
    limited = np.isfinite(low) & np.isfinite(high)
    starts[..., 0, limited] = (low[limited] + high[limited]) / 2
    return starts
