# SPDX-License-Identifier: MIT
"""Inverse kinematics of any arm: joint positions that hold the grasps, found by Newton steps in the kernel's C."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, cross, rotated
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.following.joint_limits import POSITION_TOLERANCE, is_turning
from mrts.following.null_space import FOLD, LIMIT_PUSH, limit_zone
from mrts.following.tracking_messages import CONDITION_LIMIT
from mrts.kernel.tracking import HeldGrasps, TrackingRule, hold_grasps
from mrts.motion.object_motion import ObjectMotion

POSE_TOLERANCE = 1e-10
"""Largest remaining pose error [m, rad]; Newton's quadratic convergence usually leaves 1e-15."""

SETTLED = 1e-12
"""Largest joint step [rad or m] at which the iteration ends: what is left is rounding."""

JUMP_LIMIT = 0.5
"""Largest correction of a predicted joint position [rad or m]; a larger one has changed the branch."""

STARTING_STEPS = 300
"""Steps from the posture to the grasp at t = 0; a few dozen are usual."""

FURTHER_STEPS = 60
"""Steps from each further start; those that take more lead nowhere."""

TRACKING_STEPS = 30
"""Steps from the predicted positions at a sample; two or three are usual."""

STEP_LIMIT = 0.3
"""Largest joint step [rad or m], so that a far start does not leap over its branch."""

SETTLED_PREFERENCE = 1e-8
"""Largest step left in the null space of a redundant arm [rad or m]; Newton's convergence usually leaves 1e-15."""


def tracking_rule(cell: Cell) -> TrackingRule:
    """How the arms of a cell hold their grasps."""
    robots = cell.robots
    return TrackingRule(
        steps=TRACKING_STEPS,
        start_steps=STARTING_STEPS,
        further_steps=FURTHER_STEPS,
        settled=SETTLED,
        longest=STEP_LIMIT,
        reached=POSE_TOLERANCE,
        condition=CONDITION_LIMIT,
        jump=JUMP_LIMIT,
        drift=SETTLED_PREFERENCE,
        fold=FOLD,
        past=POSITION_TOLERANCE,
        push=LIMIT_PUSH,
        components=cell.wrench_rows,
        lower=np.concatenate([robot.position_lower for robot in robots]),
        upper=np.concatenate([robot.position_upper for robot in robots]),
        zone=np.concatenate([limit_zone(robot) for robot in robots]),
        turns=np.concatenate([is_turning(robot) for robot in robots]),
    )


def tip_rates(cell: Cell, robot: Robot, motion: ObjectMotion) -> tuple[Array, Array]:
    """Velocity and acceleration of a grasp in the robot's base axes, cell components, each Shape (N, w)."""
    r = rotated(motion.rotation, robot.T_object_tip.p)
    v, w = motion.twist[:, :3], motion.twist[:, 3:]
    a, dw = motion.acceleration[:, :3], motion.acceleration[:, 3:]
    R = robot.T_world_base.R
    rows = cell.wrench_rows
    swing = cross(w, r)
    velocity = np.concatenate([(v + swing) @ R, w @ R], axis=1)
    linear = a + cross(dw, r) + cross(w, swing)
    acceleration = np.concatenate([linear @ R, dw @ R], axis=1)
    return velocity[:, rows], acceleration[:, rows]


def solve_grasps(
    cell: Cell, motion: ObjectMotion, sample: int | NDArray[np.intp], start: Array, steps: int, *, near: Array | None
) -> HeldGrasps:
    """Joint positions that hold the grasps at one sample.

    Args:
        sample: Which sample; or one for each set of positions, Shape (T,).
        start: Positions to start from, Shape (T, m) [rad or m].
        near: Positions that redundant arms stay near, Shape (m,); None moves them no further than needed.
    """
    samples = np.atleast_1d(sample)
    given = {"position": motion.position[samples], "rotation": motion.rotation[samples]}
    if near is not None:
        given["reference"] = near[None]
    return hold_grasps(cell.functions.motion_library, tracking_rule(cell), steps, start, given, cell.geometry)


def reached(held: HeldGrasps) -> NDArray[np.bool_]:
    """Which arms hold their grasps, Shape (T, n)."""
    found: NDArray[np.bool_] = np.maximum(held.gap, held.turn) <= POSE_TOLERANCE
    return found
