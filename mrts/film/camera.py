# SPDX-License-Identifier: MIT
"""A camera that has all of a motion in its picture, whatever the picture's shape."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.drawing.bodies.cell_view import FIELD_OF_VIEW
from mrts.film.solids import Index

MARGIN = 1.1
"""How much farther away it stands than it must."""

STEEPEST = 1e-2
"""Length of the level part of a unit vector below which it points upward or downward."""

HALVINGS = 30
"""Steps to the middle of what is seen, to a billionth of it."""


@dataclass(frozen=True)
class Camera:
    """Where a picture is taken from.

    Attributes:
        position: [m], world, Shape (3,).
        axes: Right, up and forward, rows of Shape (3, 3).
        size: Width and height of the picture [pixels].
    """

    position: Array
    axes: Array
    size: tuple[int, int]

    @property
    def focal(self) -> float:
        """Pixels that 1 m takes at a distance of 1 m."""
        return float(self.size[1] / 2 / np.tan(FIELD_OF_VIEW / 2))

    def seen(self, points: Array) -> Array:
        """Where points are in the picture: right and down [pixels], and their distance in front [m], Shape (P, 3).

        Args:
            points: Shape (P, 3) [m].
        """
        along = (points - self.position) @ self.axes.T
        away = along[:, 2]
        width, height = self.size
        right, up = (along[:, axis] * self.focal / away for axis in (0, 1))
        return np.column_stack([width / 2 + right, height / 2 - up, away])

    def rays(self, pixel: Index) -> Array:
        """Directions through the middles of pixels, each 1 m forward, Shape (P, 3).

        Args:
            pixel: Places in the picture, row after row, Shape (P,).
        """
        width, height = self.size
        right = (pixel % width + 0.5 - width / 2) / self.focal
        up = (height / 2 - pixel // width - 0.5) / self.focal
        along: Array = right[:, None] * self.axes[0] + up[:, None] * self.axes[1] + self.axes[2]
        return along


def framing_camera(points: Array, backward: Array, up: Array, size: tuple[int, int]) -> Camera:
    """The nearest camera with a direction that has all points in its picture.

    Args:
        points: Shape (P, 3) [m].
        backward: From what is looked at to the camera, Shape (3,).
        up: Unit vector that is upward in the picture, Shape (3,).
        size: Width and height of the picture [pixels].

    Raises:
        InputError: If the direction is none.
    """
    back = np.asarray(backward, dtype=np.float64)
    if not (np.all(np.isfinite(back)) and np.linalg.norm(back) > 0):
        raise InputError("backward", "must have a direction: look at the cell from somewhere.", value=back.tolist())
    back = back / np.linalg.norm(back)
    right = np.cross(up, back)
    if np.linalg.norm(right) < STEEPEST:
        right = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])  # from right above any level axis will do
        back = np.sign(back @ up) * up
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(back, right), -back])
    x, y, forward = (points @ axes.T).T
    half = np.tan(FIELD_OF_VIEW / 2)
    slopes = np.array([half * size[0] / size[1], half])
    across = np.stack([x, y])
    # all are between the edges where slope (distance + forward) >= ± (across - middle)
    high, low = (np.max(sign * across - slopes[:, None] * forward, axis=1) for sign in (1, -1))
    distance = MARGIN * float(np.max((high + low) / 2 / slopes))
    least, most = np.min(across, axis=1), np.max(across, axis=1)
    for _ in range(HALVINGS):  # to equal room on both sides in the picture
        middle = (least + most) / 2
        seen = (across - middle[:, None]) / (distance + forward)
        is_right = np.max(seen, axis=1) + np.min(seen, axis=1) > 0
        least, most = np.where(is_right, middle, least), np.where(is_right, most, middle)
    middle = (least + most) / 2
    return Camera(np.array([*middle, -distance]) @ axes, axes, size)
