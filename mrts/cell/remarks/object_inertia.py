# SPDX-License-Identifier: MIT
"""An inertia of the object that does not fit its mass and its size."""

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from mrts.base.arrays import Array
from mrts.base.remark import Remark

if TYPE_CHECKING:
    from mrts.cell.cell import Cell
    from mrts.cell.record import ShapeRecord

MOST = 2.0
"""Times the moment of inertia of a body whose mass is all at the corners of the box around its shape, which no body
inside exceeds; a drawn shape may leave parts out."""

LEAST = 1 / 300
"""Of the same: a uniform box has 1/3, so this one has its mass within a tenth of its size."""

WIDEST = 3.0
"""Radius of gyration as a multiple of the half distance between the two grasps that are farthest apart: a beam that two
arms hold an eighth of its length from its middle has 2.3."""

NARROWEST = 1 / 30
"""Of the same: hands hold what they reach around, not what is a thirtieth of it."""


def inertia_remarks(cell: "Cell") -> Iterator[Remark]:
    """That the inertia does not fit mass and shape or, without a shape, the distance of the grasps."""
    if cell.object_shape is not None:
        ratio = _ratio_to_shape(cell, cell.object_shape)
        fits, against = LEAST <= ratio <= MOST, "a body of this shape has at most"
    else:
        grasps = [robot.T_object_tip.p for robot in cell.robots]
        reach = max((float(np.linalg.norm(one - other)) for one, other in combinations(grasps, 2)), default=0.0) / 2
        if reach == 0:
            return
        widest = float(np.sqrt(np.max(_moments(cell, cell.inertia)) / cell.mass)) / reach
        ratio, fits = widest**2, NARROWEST <= widest <= WIDEST
        against = "the same mass at the distance of its grasps has"
    if not fits:
        moments = ", ".join(f"{moment:.4g}" for moment in np.linalg.eigvalsh(cell.inertia))
        yield Remark.hint(
            "inertia-unlike-shape",
            f"the object's inertia, principal moments {moments} kg m², does not fit its mass of {cell.mass:g} kg: it "
            f"is {ratio:.3g} times what {against}. Without 'inertia', a 'shape' gives that of a uniform body; 1 kg mm² "
            "is 1e-6 kg m².",
        )


def _moments(cell: "Cell", inertia: Array) -> Array:
    """Principal moments; in a planar cell that about the normal alone, which is all that counts there."""
    if cell.plane is None:
        return np.asarray(np.linalg.eigvalsh(inertia))
    normal = {"yz": 0, "xz": 1, "xy": 2}[cell.plane]
    return np.asarray(inertia[normal, normal, None])


def _ratio_to_shape(cell: "Cell", shape: "ShapeRecord") -> float:
    """Of the inertia to that of the mass at the corners of a box around the shape.

    It is the largest about any axis of the shape, or that of the largest moments if that is not too large.
    """
    R, p = shape.pose.R, shape.pose.p
    squares = (np.abs(R.T @ p) + _half_sides(shape)) ** 2
    corners = cell.mass * (np.sum(squares) - squares)
    if cell.plane is None:
        moments = np.diag(R.T @ cell.inertia @ R)
        most, least = float(np.max(moments / corners)), float(np.max(moments) / np.max(corners))
    else:
        most = least = float(_moments(cell, cell.inertia)[0] / _moments(cell, R @ np.diag(corners) @ R.T)[0])
    return most if most > MOST else least


def _half_sides(shape: "ShapeRecord") -> Array:
    """Of a box around the shape, in its axes, about its frame's origin, Shape (3,) [m]."""
    if shape.box is not None:
        return np.array(shape.box) / 2
    if shape.cylinder is not None:
        radius = shape.cylinder.radius
        return np.array([radius, radius, shape.cylinder.length / 2])
    from mrts.base.formats.surface_text import unpacked_surface  # noqa: PLC0415 (for meshes alone)

    assert shape.mesh is not None  # noqa: S101 (one kind is given)
    return np.asarray(np.max(np.abs(unpacked_surface(shape.mesh.vertices, shape.mesh.triangles)[0]), axis=0))
