# SPDX-License-Identifier: MIT
"""Whether an arm reaches its grasp, from the lengths of its links alone.

The shoulder, where the second axis is nearest to the first, goes around the first axis; the wrist, where the last axis
but one is nearest to the last, goes around the last one, which the grasp holds. Between them lie links of fixed length.
Past axes that are parallel, a point keeps its place along them, and across them comes no further than the links reach.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.robot import Robot

FEWEST_JOINTS = 3
"""Of an arm with a shoulder and a wrist."""

PARALLEL = 1e-9
"""Sine of the angle between axes below which they are parallel."""

CLEARLY = 1e-6
"""Distance that no rounding makes [m]: a grasp nearer than this to what an arm reaches is left to the search."""


@dataclass(frozen=True)
class ArmPlaces:
    """Where one arm stands and holds, in one cell or, with the same first axes throughout, in many.

    Attributes:
        base_rotation: Of the base in the world, Shape (…, 3, 3).
        base_position: Shape (…, 3) [m].
        tip_rotation: Of the tip in the object frame, Shape (…, 3, 3).
        tip_position: Shape (…, 3) [m].
    """

    base_rotation: Array
    base_position: Array
    tip_rotation: Array
    tip_position: Array


@dataclass(frozen=True)
class Reach:
    """How far an arm reaches.

    Attributes:
        shoulder: Centre of the circle that it goes around, base frame, Shape (3,) [m].
        wrist: Likewise in the tip frame.
        longest: Largest distance of the two [m].
    """

    shoulder: Array
    wrist: Array
    longest: float

    def distance(self, places: ArmPlaces, position: Array, rotation: Array) -> Array:
        """How far the wrist would be from the shoulder, Shape (…) [m].

        Args:
            position: Of the object, Shape (…, 3) [m].
        """
        held = places.tip_position + _times(places.tip_rotation, self.wrist)
        wrist = position + _times(rotation, held)
        shoulder = places.base_position + _times(places.base_rotation, self.shoulder)
        return np.asarray(np.linalg.norm(wrist - shoulder, axis=-1), dtype=np.float64)

    def beyond(self, distance: Array) -> NDArray[np.bool_]:
        """Whether the grasp is surely out of reach, as `distance`."""
        return np.asarray(distance > self.longest + CLEARLY)

    def failure(self, robot: Robot, time: Array, distance: Array) -> str:
        """The message for a grasp that is out of reach along a motion, time and distances of Shape (N,) [s], [m]."""
        sample = int(np.argmax(distance))
        far = float(distance[sample])
        return (
            f"robot '{robot.name}' cannot reach its grasp at sample {sample} (t = {time[sample]:.6g} s): its wrist "
            f"would be {far:.6g} m from its shoulder and reaches {self.longest:.6g} m: {far - self.longest:.3g} m too "
            "far. Move the path, the base or the grasp."
        )


def arm_reach(robot: Robot) -> Reach | None:
    """How far an arm reaches; None for one with few joints, or with prismatic ones."""
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
    return Reach(first, tip.R.T @ (last - tip.p), longest)


def _nearest(axis: Array, point: Array, other: Array, through: Array) -> tuple[Array, Array]:
    """The points of two lines that are nearest to each other; of parallel ones any such pair."""
    across = np.cross(axis, other)
    square = float(across @ across)
    if square <= PARALLEL**2:
        return point, through + ((point - through) @ other) * other
    along = np.cross(through - point, other) @ across / square
    nearest = point + along * axis
    return nearest, through + ((nearest - through) @ other) * other


def _times(rotation: Array, vector: Array) -> Array:
    product: Array = (rotation @ vector[..., None])[..., 0]
    return product
