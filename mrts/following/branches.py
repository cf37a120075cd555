# SPDX-License-Identifier: MIT
"""All the ways in which an arm can hold its grasp at t = 0."""

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.following.tracking import (
    POSITION_TOLERANCE,
    SETTLED_PREFERENCE,
    STARTING_STEPS,
    is_redundant,
    nearest_turns,
    reached,
    solve_grasps,
    starting_reference,
    within_limits,
)
from mrts.motion.object_motion import ObjectMotion

MULTI_STARTS = 400
"""Seeded random starts: each of up to 16 branches is then found many times."""

SEED = 20
SAME_BRANCH = 1e-6
"""Joint positions closer than this, whole turns aside, are one branch [rad or m]."""


def branches_at_start(cell: Cell, index: int, motion: ObjectMotion, starts: int = MULTI_STARTS) -> Array:
    """Joint positions of one arm that hold its grasp at t = 0 inside its limits, each branch once, Shape (k, n_i)."""
    robot = cell.robots[index]
    joints = cell.joint_slices[robot.name]
    redundant = is_redundant(cell, robot)
    start = np.tile(cell.posture, (starts, 1))
    start[:, joints] = _random_starts(robot, starts)
    held = solve_grasps(cell, motion, 0, start, STARTING_STEPS, near=starting_reference(cell))
    settled = reached(held) & (held.drift <= SETTLED_PREFERENCE)
    distinct: list[Array] = []
    for candidate in held.q[settled[:, index]][:, joints]:
        # a redundant arm has settled where its null space points, whole turns and all
        near = candidate if redundant else nearest_turns(robot, candidate, robot.posture)
        near = within_limits(robot, near[None])[0]
        inside = np.all(np.maximum(robot.position_lower - near, near - robot.position_upper) <= POSITION_TOLERANCE)
        if inside and not any(np.max(np.abs(_apart(robot, near, other))) < SAME_BRANCH for other in distinct):
            distinct.append(near)
    return np.array(distinct).reshape(-1, len(robot.joints))


def _random_starts(robot: Robot, count: int) -> Array:
    rng = np.random.default_rng(SEED)
    low = np.where(np.isfinite(robot.position_lower), np.maximum(robot.position_lower, -np.pi), -np.pi)
    high = np.where(np.isfinite(robot.position_upper), np.minimum(robot.position_upper, np.pi), np.pi)
    starts = rng.uniform(low, high, (count, len(robot.joints)))
    starts[0] = robot.posture
    return starts


def _apart(robot: Robot, a: Array, b: Array) -> Array:
    turns = robot.turns
    return np.where(turns, (a - b + np.pi) % (2 * np.pi) - np.pi, a - b)
