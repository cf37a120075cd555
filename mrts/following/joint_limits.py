# SPDX-License-Identifier: MIT
"""Position limits of the joints along a motion."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import MotionError
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.following.tracking_messages import tracking_failure
from mrts.kernel.tracking import PAST_LIMIT

POSITION_TOLERANCE = 1e-9
"""How far a joint may pass its position limit [rad or m]: rounding."""

PRINTED_TOLERANCE = 1e-4
"""The same for positions that are given, which may carry few digits."""


def nearest_turns(robot: Robot, q: Array, posture: Array | None = None) -> Array:
    """The same joint positions with whole turns added to come nearest to the posture, Shape (n_i,) [rad or m].

    Args:
        posture: None for the robot's own; several, as of q, have Shape (V, n_i).
    """
    near = robot.posture if posture is None else posture
    return np.where(is_turning(robot), near + (q - near + np.pi) % (2 * np.pi) - np.pi, q)


def is_turning(robot: Robot) -> NDArray[np.bool_]:
    """Joints of which whole turns are the same position, Shape (n_i,)."""
    return np.array([kind == "revolute" for kind in robot.joint_types])


def within_limits(robot: Robot, q: Array) -> Array:
    """Whole turns added to or taken from a joint's path where that brings it inside its position limits.

    Args:
        q: Joint positions along a motion, Shape (N, n_i) [rad or m].
    """
    turn = np.where(is_turning(robot), 2 * np.pi, np.inf)
    low, high = np.min(q, axis=0), np.max(q, axis=0)
    down = np.ceil((high - robot.position_upper) / turn - POSITION_TOLERANCE).clip(min=0)
    up = np.ceil((robot.position_lower - low) / turn - POSITION_TOLERANCE).clip(min=0)
    shift = np.where(np.isfinite(turn), turn, 0.0)
    fits_down = low - shift * down >= robot.position_lower - POSITION_TOLERANCE
    fits_up = high + shift * up <= robot.position_upper + POSITION_TOLERANCE
    moved: Array = q + shift * (np.where(fits_up, up, 0.0) - np.where(fits_down, down, 0.0))
    return moved


def joint_limit_failure(robot: Robot, time: Array, q: Array, tolerance: float = POSITION_TOLERANCE) -> str | None:
    """The message for the first sample where a joint passes its position limit, None if none does.

    Args:
        time: Shape (N,) [s].
        q: Joint positions of this arm, Shape (N, n_i) [rad or m].
        tolerance: How far it may [rad or m].
    """
    beyond = np.maximum(robot.position_lower - q, q - robot.position_upper) > tolerance
    if not np.any(beyond):
        return None
    sample = int(np.argmax(np.any(beyond, axis=1)))
    joint = int(np.argmax(beyond[sample]))
    return tracking_failure(PAST_LIMIT, robot, time, sample, [float(q[sample, joint])], joint).message


def check_joint_limits(cell: Cell, time: Array, q: Array, tolerance: float = POSITION_TOLERANCE) -> None:
    """Check the position limits of all joints along a motion.

    Args:
        time: Shape (N,) [s].
        q: Shape (N, m) [rad or m].
        tolerance: How far a joint may pass [rad or m].

    Raises:
        MotionError: Names robot, joint, the first such sample, value and limits.
    """
    for robot in cell.robots:
        failure = joint_limit_failure(robot, time, q[:, cell.joint_slices[robot.name]], tolerance)
        if failure:
            raise MotionError(failure)
