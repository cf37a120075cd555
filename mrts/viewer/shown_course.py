# SPDX-License-Identifier: MIT
"""Where everything that is drawn of a motion stands, at its samples and, while it plays, between them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.drawing.bodies.cell_shapes import body_poses
from mrts.viewer.player_state import PlayerState
from mrts.viewer.workbench.held_poses import HeldPoses


@dataclass(frozen=True, eq=False)
class ShownCourse:
    """Poses along a motion, as far as a scene is concerned; k of them.

    Attributes:
        cell: The cell.
        q: Joint positions, Shape (k, m) [rad or m].
        position: Of the object, Shape (k, 3) [m].
        rotation: Of the object, Shape (k, 3, 3).
        passed: Where a limit is passed, or an arm does not reach, Shape (k,).
    """

    cell: Cell
    q: Array
    position: Array
    rotation: Array
    passed: NDArray[np.bool_]

    @cached_property
    def bodies(self) -> tuple[tuple[Array, Array], ...]:
        """By arm, where its bodies are: Shape (k, n_i + 1, 3, 3), and Shape (k, n_i + 1, 3) [m]."""
        return tuple(
            body_poses(robot, self.q[:, joints])
            for robot, joints in zip(self.cell.robots, self.cell.joint_slices.values(), strict=True)
        )

    def moment(self, place: float) -> "ShownMoment":
        """Where everything is.

        Args:
            place: A sample, or between two of them: every point of a body is then on the line between where it is at
                both, so that hands stay at their grasps.
        """
        return ShownMoment(
            position=blended(self.position, place),
            rotation=blended(self.rotation, place),
            bodies=tuple((blended(R, place), blended(p, place)) for R, p in self.bodies),
        )


@dataclass(frozen=True, eq=False)
class ShownMoment:
    """Poses at one moment; between samples rotations are so only to the square of the step.

    Attributes:
        position: Of the object, Shape (3,) [m].
        rotation: Of the object, Shape (3, 3).
        bodies: By arm, Shape (n_i + 1, 3, 3), and Shape (n_i + 1, 3) [m].
    """

    position: Array
    rotation: Array
    bodies: tuple[tuple[Array, Array], ...]


def blended(values: Array, place: float) -> Array:
    """Values of a course at a sample, or linear between two.

    Args:
        values: Of every sample, Shape (k, …).
        place: Index of a sample, or between two.
    """
    first = min(int(place), len(values) - 1)
    share = place - first
    here: Array = values[first]
    return here if share == 0 else here + share * (values[first + 1] - here)


def course_of(shown: PlayerState | HeldPoses) -> ShownCourse:
    """The poses of what is shown."""
    if isinstance(shown, HeldPoses):
        passed = ~np.all(shown.reached, axis=1)
        return ShownCourse(shown.cell, shown.q, shown.position, shown.rotation, passed)
    motion = shown.result.motion
    return ShownCourse(shown.result.cell, motion.q, motion.object.position, motion.object.rotation, shown.excess > 0)
