# SPDX-License-Identifier: MIT
"""The carried object as triangles in its own frame: its shape, or a box with about its inertia that hands hold."""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.formats.surface_text import MOST_DRAWN, coarser_surface
from mrts.cell.cell import Cell
from mrts.cell.record import BodyShape, mesh_surface

THINNEST = 0.05
"""Least side of a drawn object, as a share of its longest: a planar object may have no thickness."""

SMALLEST = 1e-3
"""What counts as the longest side of an object whose inertia gives it none [m]."""

CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))
"""Of a box with sides of 1."""

TRIANGLES = np.array(
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]
)  # fmt: skip
"""Of a box, counterclockwise from outside."""

AROUND = 32
"""Corners of the circle that stands for a cylinder's end."""

FLAT = np.deg2rad(30.0)
"""Least angle between two triangles whose common side is drawn as an edge [rad]."""

WAIST = 0.4
"""A side of the box is drawn as short as this share of what its inertia gives it, so that a hand is at its surface."""

REACHED = 0.02
"""A contact this near to the box, as a share of the box's diagonal, is at its surface."""

HANDLE = 0.04
"""Half width of a bar from the box to a contact beside it, as a share of the box's diagonal."""


Surface = tuple[Array, NDArray[np.int64]]
"""Vertices in the frame of what carries them, Shape (V, 3) [m], and triangles of these, Shape (F, 3)."""


def held_body(cell: Cell, most: int = MOST_DRAWN) -> Surface:
    """The object as it is drawn: its shape, or a box with about its inertia that its hands touch, or hold by handles.

    Such a box that reaches beyond a contact is drawn narrower, so that the hand is at its surface; a contact beside it
    is joined to it by a bar. A mesh of more than `most` triangles is made coarser.
    """
    if cell.object_shape is not None:
        return shape_surface(cell, cell.object_shape, most)
    contacts = np.array([robot.T_object_tip.p for robot in cell.robots])
    half = _narrowed(object_box(cell) / 2, contacts)
    size = 2 * float(np.linalg.norm(half))
    boxes = [CORNERS * 2 * half]
    for contact in contacts:
        nearest = np.clip(contact, -half, half)
        if np.linalg.norm(contact - nearest) > REACHED * size:
            boxes.append(_bar(nearest, contact, HANDLE * size))
    triangles = [TRIANGLES + number * len(CORNERS) for number in range(len(boxes))]
    return np.concatenate(boxes), np.concatenate(triangles)


def object_box(cell: Cell) -> Array:
    """Sides of the uniform box along the object's axes with about its mass and inertia, Shape (3,) [m]."""
    diagonal = np.diag(cell.inertia)
    squares = 6 / cell.mass * (np.sum(diagonal) - 2 * diagonal)
    sides: Array = np.sqrt(np.maximum(squares, 0))
    return np.maximum(sides, THINNEST * max(float(np.max(sides)), SMALLEST))


def _narrowed(half: Array, contacts: Array) -> Array:
    """Half sides of a box with no contact deep inside, unless that took more than `WAIST` leaves."""
    half = half.copy()
    for contact in contacts:
        depth = half - np.abs(contact)
        if np.all(depth > 0):
            axis = int(np.argmin(depth / half))
            half[axis] = max(abs(contact[axis]), WAIST * half[axis])
    return half


def _bar(start: Array, end: Array, half_width: float) -> Array:
    along = (end - start) / np.linalg.norm(end - start)
    across = perpendicular(along)
    axes = np.stack([2 * half_width * across, 2 * half_width * np.cross(along, across), end - start])
    corners: Array = (start + end) / 2 + CORNERS @ axes
    return corners


def perpendicular(direction: Array) -> Array:
    """A unit vector at right angles to a direction, Shape (3,)."""
    across = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    return np.asarray(across / np.linalg.norm(across))


def shape_surface(cell: Cell, shape: BodyShape, most: int = MOST_DRAWN) -> Surface:
    """A shape in the frame that its pose is given in; a mesh of more than `most` triangles is made coarser."""
    if shape.box is not None:
        vertices, triangles = CORNERS * np.array(shape.box), TRIANGLES
    elif shape.cylinder is not None:
        from trimesh.creation import cylinder  # noqa: PLC0415 (half a second, for a shape that few cells have)

        drawn = cylinder(shape.cylinder.radius, shape.cylinder.length, sections=AROUND)
        vertices, triangles = np.asarray(drawn.vertices), np.asarray(drawn.faces)
    else:
        vertices, triangles = coarser_surface(*mesh_surface(shape, cell.surfaces), most)
    pose = shape.pose.transform
    return vertices @ pose.R.T + pose.p, triangles


def outlines(surface: Surface) -> Array:
    """Lines where it bends or ends, Shape (E, 2, 3) [m]; of a ball, which has none, along all of its triangles."""
    vertices, triangles = surface
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(lengths > 0, lengths, 1.0)
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    found, side, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    total = np.zeros((len(found), 3))
    np.add.at(total, side.ravel(), np.repeat(normals, 3, axis=0))
    flat = (count == 2) & (np.sum(total**2, axis=1) >= 2 + 2 * np.cos(FLAT))  # noqa: PLR2004 (the normals of both sides)
    lines: Array = vertices[triangles[:, :2] if np.all(flat) else found[~flat]]
    return lines
