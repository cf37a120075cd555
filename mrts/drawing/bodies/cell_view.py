# SPDX-License-Identifier: MIT
"""Where to look at a cell from: upright against gravity, all of its motion in view."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.drawing.bodies.cell_shapes import joint_points
from mrts.drawing.bodies.held_body import held_body

FIELD_OF_VIEW = np.deg2rad(45.0)
"""From the lower to the upper edge of the picture [rad]."""

ELEVATION, AZIMUTH = np.deg2rad(15.0), np.deg2rad(25.0)
"""From the front, so that depth shows: moments of a planar cell point at the viewer [rad]."""


@dataclass(frozen=True)
class CellView:
    """A camera and a floor, world axes.

    Attributes:
        up: Unit vector against gravity, Shape (3,).
        direction: Unit vector from the target to the camera, Shape (3,).
        target: The point looked at, the middle of all parts at all times, Shape (3,) [m].
        floor: A point below all bases, at the height of the lowest, Shape (3,) [m].
        size: Radius of a ball that holds all parts at all times [m].
        aside: How much farther to both sides of the target there is something to see [m].
    """

    up: Array
    direction: Array
    target: Array
    floor: Array
    size: float
    aside: float = 0.0

    def camera(self, aspect: float = 1.0) -> Array:
        """Where to look from so that all parts are in the picture, Shape (3,) [m].

        Args:
            aspect: Width of the picture by its height.
        """
        half = FIELD_OF_VIEW / 2
        sideways = np.arctan(np.tan(half) * aspect)
        distance = max(self.size / np.sin(half), (self.size + self.aside) / np.sin(sideways))
        return np.asarray(self.target + distance * self.direction)


def look_at_cell(cell: Cell, q: Array, position: Array) -> CellView:
    """Look at a cell from the front: along the level line that is normal to its widest extent.

    Args:
        cell: The cell.
        q: Joint positions along its motion, Shape (N, m) [rad or m].
        position: Of the object, Shape (N, 3) [m].
    """
    slices = cell.joint_slices
    lines = [joint_points(robot, q[:, slices[robot.name]]).reshape(-1, 3) for robot in cell.robots]
    reach = np.linalg.norm(held_body(cell).vertices, axis=1).max()
    points = np.concatenate([*lines, position - reach, position + reach])
    middle = (np.min(points, axis=0) + np.max(points, axis=0)) / 2
    size = float(np.max(np.linalg.norm(points - middle, axis=1)))
    up = _up(cell)
    across = _widest_level_axis(points, up)
    front = np.cross(across, up)
    level = np.cos(AZIMUTH) * front + np.sin(AZIMUTH) * across
    direction = np.cos(ELEVATION) * level + np.sin(ELEVATION) * up
    bases = np.array([robot.T_world_base.p for robot in cell.robots])
    floor = middle + up * (np.min(bases @ up) - middle @ up)
    return CellView(up, direction, middle, floor, size)


def _up(cell: Cell) -> Array:
    """Against gravity; without any, the second axis of a planar cell's plane, or z."""
    strength = float(np.linalg.norm(cell.gravity))
    if strength > 0:
        return np.asarray(-cell.gravity / strength)
    axis: Array = np.eye(3)["xyz".index(cell.plane[1]) if cell.plane else 2]
    return axis


def _widest_level_axis(points: Array, up: Array) -> Array:
    """Unit vector normal to `up` along which the points spread most; its largest component is positive."""
    level = points - np.mean(points, axis=0)
    level = level - np.outer(level @ up, up)
    axis = np.linalg.eigh(level.T @ level)[1][:, -1]
    axis = axis - axis @ up * up
    length = float(np.linalg.norm(axis))
    if length < 0.5:  # noqa: PLR2004 (all points on one upright line: any level axis will do)
        axis = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
        length = float(np.linalg.norm(axis))
    axis = axis / length
    return np.asarray(axis * np.sign(axis[np.argmax(np.abs(axis))]))
