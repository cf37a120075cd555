# SPDX-License-Identifier: MIT
"""Where to look at a cell from: upright against gravity, all of its motion in view."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.scene.held_body import held_body, perpendicular
from mrts.scene.scene import Scene

FIELD_OF_VIEW = np.deg2rad(45.0)
"""From the lower to the upper edge of the picture [rad]."""

ELEVATION, AZIMUTH = np.deg2rad(15.0), np.deg2rad(25.0)
"""From the front, so that depth shows: moments of a planar cell point at the viewer [rad]."""

MARGIN = 1.15
"""How much farther away a camera stands than it must."""


@dataclass(frozen=True)
class Camera:
    """Where a picture is taken from.

    Attributes:
        position: [m], world, Shape (3,).
        axes: Right, up and forward, rows of Shape (3, 3).
        target: The point looked at, Shape (3,) [m].
    """

    position: Array
    axes: Array
    target: Array


@dataclass(frozen=True)
class CellView:
    """What there is to see, world axes.

    Attributes:
        up: Unit vector against gravity, Shape (3,).
        direction: Unit vector from the cell to the camera, Shape (3,).
        points: That must be in the picture, Shape (P, 3) [m].
        floor: A point below all, at the height of the lowest base, or of what hangs lower, Shape (3,) [m].
        size: Radius of a ball that holds all parts of one cell at all times [m].
    """

    up: Array
    direction: Array
    points: Array
    floor: Array
    size: float

    @property
    def level(self) -> Array:
        """Axes of the floor, the third one upward, as columns of Shape (3, 3)."""
        across = perpendicular(self.up)
        return np.stack([across, np.cross(self.up, across), self.up], axis=1)

    def camera(self, aspect: float = 1.0) -> Camera:
        """The nearest camera that has all points in a picture whose width is `aspect` times its height."""
        back = self.direction
        right = np.cross(self.up, back)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(back, right), -back])
        x, y, forward = (self.points @ axes.T).T
        half = np.tan(FIELD_OF_VIEW / 2)
        slopes = np.array([half * aspect, half])
        across = np.stack([x, y])
        # all are between the edges where slope (distance + forward) >= ± (across - middle)
        high, low = (np.max(sign * across - slopes[:, None] * forward, axis=1) for sign in (1, -1))
        distance, middle = MARGIN * float(np.max((high + low) / 2 / slopes)), (high - low) / 2
        depth = (np.min(forward) + np.max(forward)) / 2
        return Camera(np.array([*middle, -distance]) @ axes, axes, np.array([*middle, depth]) @ axes)


def look_at(scene: Scene) -> CellView:
    """Look at a cell from the front: along the level line that is normal to its widest extent."""
    cell, position = scene.cell, scene.position
    lines = [line.reshape(-1, 3) for line in scene.lines]
    reach = float(np.max(np.linalg.norm(held_body(cell)[0], axis=1)))
    around = [position + sign * reach * axis for sign in (-1, 1) for axis in np.eye(3)]
    points = np.concatenate([*lines, *around])
    middle = (np.min(points, axis=0) + np.max(points, axis=0)) / 2
    size = float(np.max(np.linalg.norm(points - middle, axis=1)))
    up = _up(cell)
    across = _widest_level_axis(points, up)
    front = np.cross(across, up)
    level = np.cos(AZIMUTH) * front + np.sin(AZIMUTH) * across
    direction = np.cos(ELEVATION) * level + np.sin(ELEVATION) * up
    bases = np.array([robot.T_world_base.p for robot in cell.robots])
    floor = middle + up * (np.min([*bases @ up, *points @ up]) - middle @ up)
    return CellView(up, direction, points, floor, size)


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
    # with all points on one upright line any level axis will do
    axis = axis / length if length > 0.5 else perpendicular(up)  # noqa: PLR2004
    return np.asarray(axis * np.sign(axis[np.argmax(np.abs(axis))]))
