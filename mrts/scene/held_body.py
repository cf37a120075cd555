# SPDX-License-Identifier: MIT
"""The carried object as a body that hands are seen to hold, as triangles in its own frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.formats.surface_text import MOST_DRAWN
from mrts.cell.cell import Cell
from mrts.scene.cell_shapes import object_box
from mrts.scene.object_surface import CORNERS, TRIANGLES, object_surface

WAIST = 0.4
"""A side of the box is drawn as short as this share of what its inertia gives it, so that a hand is at its surface."""

REACHED = 0.02
"""A contact this near to the box, as a share of the box's diagonal, is at its surface."""

HANDLE = 0.04
"""Half width of a bar from the box to a contact beside it, as a share of the box's diagonal."""


@dataclass(frozen=True, eq=False)
class HeldBody:
    """Triangles in the object's frame.

    Attributes:
        vertices: Shape (V, 3) [m].
        faces: Indices of vertices, Shape (F, 3).
    """

    vertices: Array
    faces: NDArray[np.int_]

    def __add__(self, other: "HeldBody") -> "HeldBody":
        return HeldBody(
            np.concatenate([self.vertices, other.vertices]),
            np.concatenate([self.faces, other.faces + len(self.vertices)]),
        )


def held_body(cell: Cell, most: int = MOST_DRAWN) -> HeldBody:
    """The object as it is drawn: its shape, or a box with about its inertia that its hands touch, or hold by handles.

    Such a box that reaches beyond a contact is drawn narrower, so that the hand is at its surface; a contact beside it
    is joined to it by a bar.

    Args:
        cell: The cell.
        most: Triangles of a mesh, which is drawn coarser than it is known where it has more.
    """
    if cell.object_shape is not None:
        return HeldBody(*object_surface(cell, most))
    contacts = np.array([robot.T_object_tip.p for robot in cell.robots])
    half = _narrowed(object_box(cell) / 2, contacts)
    size = 2 * float(np.linalg.norm(half))
    body = HeldBody(CORNERS * 2 * half, TRIANGLES)
    for contact in contacts:
        nearest = np.clip(contact, -half, half)
        if np.linalg.norm(contact - nearest) > REACHED * size:
            body = body + _bar(nearest, contact, HANDLE * size)
    return body


def _narrowed(half: Array, contacts: Array) -> Array:
    """Half sides of a box with no contact deep inside, unless that took more than `WAIST` leaves."""
    half = half.copy()
    for contact in contacts:
        depth = half - np.abs(contact)
        if np.all(depth > 0):
            axis = int(np.argmin(depth / half))
            half[axis] = max(abs(contact[axis]), WAIST * half[axis])
    return half


def _bar(start: Array, end: Array, half_width: float) -> HeldBody:
    """A square bar from a point to another, which differ."""
    along = (end - start) / np.linalg.norm(end - start)
    across = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    across = across / np.linalg.norm(across)
    axes = np.stack([2 * half_width * across, 2 * half_width * np.cross(along, across), end - start])
    return HeldBody((start + end) / 2 + CORNERS @ axes, TRIANGLES)
