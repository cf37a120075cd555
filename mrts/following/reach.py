# SPDX-License-Identifier: MIT
"""Whether an arm reaches its grasp, from the lengths of its links alone.

The shoulder, where the second axis is nearest to the first, goes around the first axis; the wrist, where the last axis
but one is nearest to the last, goes around the last one, which the grasp holds. Between them lie links of fixed length.
Past axes that are parallel, a point keeps its place along them, and across them comes no further than the links reach.
"""

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.robot import Robot

FEWEST_JOINTS = 3
"""Of an arm with a shoulder and a wrist."""

PARALLEL = 1e-9
"""Sine of the angle between axes below which they are parallel."""

CLEARLY = 1e-6
"""Distance that no rounding makes [m]: a grasp nearer than this to what an arm reaches is left to the search."""


def arm_reach(robot: Robot) -> tuple[Array, Array, float] | None:
    """Shoulder in the base frame and wrist in the tip frame, each Shape (3,) [m], and their largest distance [m].

    None for an arm with few joints, or with prismatic ones.
    """
    if len(robot.joints) < FEWEST_JOINTS or set(robot.joint_types) != {"revolute"}:
        return None
    axes, points = robot.axes, robot.points
    shoulder, first = _nearest(axes[1], points[1], axes[0], points[0])
    wrist, last = _nearest(axes[-2], points[-2], axes[-1], points[-1])
    longest = float(np.linalg.norm(shoulder - first) + np.linalg.norm(wrist - last))
    at, joint, end = shoulder, 1, len(axes) - 2
    while joint < end:
        along, start, across = axes[joint], at, 0.0
        while joint + 1 < end and np.linalg.norm(np.cross(axes[joint + 1], along)) <= PARALLEL:
            across += float(np.linalg.norm(np.cross(points[joint + 1] - at, along)))
            at, joint = points[joint + 1], joint + 1
        to = wrist if joint + 1 == end else _nearest(axes[joint + 1], points[joint + 1], along, at)[0]
        across += float(np.linalg.norm(np.cross(to - at, along)))
        longest += float(np.hypot(across, (to - start) @ along))
        at, joint = to, joint + 1
    longest += float(np.linalg.norm(wrist - at))  # of three joints, along the axis between
    tip = robot.T_base_tip
    return first, tip.R.T @ (last - tip.p), longest


def _nearest(axis: Array, point: Array, other: Array, through: Array) -> tuple[Array, Array]:
    """The points of two lines that are nearest to each other; of parallel ones any such pair."""
    across = np.cross(axis, other)
    square = float(across @ across)
    if square <= PARALLEL**2:
        return point, through + ((point - through) @ other) * other
    along = np.cross(through - point, other) @ across / square
    nearest = point + along * axis
    return nearest, through + ((nearest - through) @ other) * other
