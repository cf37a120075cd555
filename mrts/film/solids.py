# SPDX-License-Identifier: MIT
"""Bodies as triangles: balls, tubes, boxes, arrows, and the meshes of arms."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array

Index = NDArray[np.int_]
Colour = tuple[int, int, int]
"""0 to 255."""

AROUND = 20
"""Sides of what is round."""


@dataclass(frozen=True)
class Solid:
    """Triangles of one colour.

    Attributes:
        points: Corners, Shape (P, 3) [m].
        normals: Outward at each corner, unit vectors, Shape (P, 3).
        faces: Three corners each, Shape (F, 3).
        colour: Of all of it.
        casts: Whether it casts a shadow.
    """

    points: Array
    normals: Array
    faces: Index
    colour: Colour
    casts: bool = True

    def moved(self, R: Array, p: Array) -> Self:
        """The same, turned by R, Shape (3, 3), then moved by p, Shape (3,) [m]."""
        return replace(self, points=self.points @ R.T + p, normals=self.normals @ R.T)


def ball(center: Array, radius: float, colour: Colour) -> Solid:
    """A ball.

    Args:
        center: Shape (3,) [m].
        radius: [m].
        colour: Of it.
    """
    points, faces = _unit_ball()
    return Solid(center + radius * points, points, faces, colour)


def tube(start: Array, end: Array, radius: tuple[float, float], colour: Colour, *, casts: bool = True) -> Solid:
    """A round bar, thicker or thinner towards its end; its ends are closed.

    Args:
        start: Shape (3,) [m].
        end: Another point, Shape (3,) [m].
        radius: At the start and at the end [m].
        colour: Of it.
        casts: Whether it casts a shadow.
    """
    along = end - start
    length = float(np.linalg.norm(along))
    axis = along / length
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side /= np.linalg.norm(side)
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    ring = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * np.cross(axis, side)
    first, last = start + radius[0] * ring, end + radius[1] * ring
    wall = ring + (radius[0] - radius[1]) / length * axis
    wall /= np.linalg.norm(wall, axis=1, keepdims=True)
    caps = np.broadcast_to(axis, ring.shape)
    points = np.concatenate([first, last, first, last, start[None], end[None]])
    normals = np.concatenate([wall, wall, -caps, caps, -axis[None], axis[None]])
    here, then = np.arange(AROUND), np.roll(np.arange(AROUND), -1)
    n = AROUND
    faces = np.concatenate(
        [
            np.column_stack([here, then, then + n]),
            np.column_stack([here, then + n, here + n]),
            np.column_stack([np.full(n, 4 * n), then + 2 * n, here + 2 * n]),
            np.column_stack([np.full(n, 4 * n + 1), here + 3 * n, then + 3 * n]),
        ]
    )
    return Solid(points, normals, faces, colour, casts)


def arrow(start: Array, step: Array, thickness: float, colour: Colour) -> list[Solid]:
    """A bar with a tip; one that is shorter than its tip is all tip.

    Args:
        start: Shape (3,) [m].
        step: From there to its point, not zero, Shape (3,) [m].
        thickness: Radius of the bar [m].
        colour: Of it.
    """
    length = float(np.linalg.norm(step))
    tip = min(5 * thickness, length)
    neck = start + step * (1 - tip / length)
    head = tube(neck, start + step, (2.2 * thickness, 0.0), colour, casts=False)
    return [head] if tip == length else [tube(start, neck, (thickness, thickness), colour, casts=False), head]


def faceted(vertices: Array, faces: Index, colour: Colour) -> Solid:
    """Triangles with edges that are seen, as those of a box.

    Args:
        vertices: Shape (V, 3) [m].
        faces: Three of them each, Shape (F, 3).
        colour: Of all.
    """
    corners = vertices[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    normals = across / np.where(length > 0, length, 1)
    return Solid(
        corners.reshape(-1, 3), np.repeat(normals, 3, axis=0), np.arange(3 * len(faces)).reshape(-1, 3), colour
    )


@cache
def _unit_ball() -> tuple[Array, Index]:
    rings = AROUND // 2
    height = np.pi * np.arange(rings + 1) / rings
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    down, round_ = np.meshgrid(height, turn, indexing="ij")
    points = np.stack([np.sin(down) * np.cos(round_), np.sin(down) * np.sin(round_), np.cos(down)], axis=-1)
    here = np.arange(rings)[:, None] * AROUND + np.arange(AROUND)
    beside = np.arange(rings)[:, None] * AROUND + (np.arange(AROUND) + 1) % AROUND
    faces = [np.stack([here, here + AROUND, beside + AROUND], -1), np.stack([here, beside + AROUND, beside], -1)]
    return points.reshape(-1, 3), np.concatenate(faces).reshape(-1, 3)
