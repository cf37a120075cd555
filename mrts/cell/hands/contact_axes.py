# SPDX-License-Identifier: MIT
"""Axes of a contact in the axes of its tip link, and the components of a planar wrench there."""

from collections.abc import Sequence

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, as_array
from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.base.rigid_transform import multiply
from mrts.cell.hands.contact import check_components

SHORTEST_DIRECTION = 1e-9
"""A direction is given by numbers near 1: what is shorter is zero, misprinted."""

OUT_OF_PLANE = 1e-9
"""Largest entry of a rotation or direction that still counts as zero."""

NOT_IN_PLANE = (
    "is in tip axes, of which one must be normal to the plane of a planar cell. Turn the tip frame in the URDF and the "
    "grasp with it, or give a box in the frame of the object or the base."
)


def triple_axes(components: Sequence[str]) -> list[int]:
    """The axes that a triple of a wrench belongs to: all three, or of a planar one its forces' and its moment's."""
    return ["xyz".index(component[1]) for component in components[:3]]


def tip_components(components: Sequence[str], R_object_tip: Array) -> tuple[str, ...] | None:
    """Components of a wrench in tip axes: of a planar one the forces along both tip axes in the plane, and its moment.

    Args:
        components: Of the cell's wrenches.
        R_object_tip: Rotation of the grasp, Shape (3, 3).

    Returns:
        Names; None if a planar cell's tip link has no axis along the plane's normal.
    """
    if len(components) == len(WRENCH_COMPONENTS):
        return tuple(components)
    normal = R_object_tip[triple_axes(components)[2]]
    along = int(np.argmax(np.abs(normal)))
    if np.max(np.abs(np.delete(normal, along))) > OUT_OF_PLANE:
        return None
    first, second = (axis for axis in range(3) if axis != along)
    return f"f{'xyz'[first]}", f"f{'xyz'[second]}", f"n{'xyz'[along]}"


def contact_axes(key: str, direction: object, components: Sequence[str]) -> Array:
    """Turns each triple of a wrench from tip into contact axes: (a, b, normal), of a planar one (a, normal, moment).

    a lies along the tip's x axis, or along its y axis where the normal is nearest to x, projected along the normal;
    b = normal × a. In a planar cell a is normal to the normal, in the plane.

    Args:
        key: What the direction is called, for messages.
        direction: The normal in tip axes, of any length, Shape (3,).
        components: Of the wrench in tip axes.

    Returns:
        Shape (3, 3).

    Raises:
        InputError: If the direction is none, or leaves the plane.
    """
    check_components(components)
    given = as_array(key, direction)
    if given.shape != (3,) or not np.all(np.isfinite(given)):
        raise InputError("contact", "must be three finite numbers in tip axes.", key=key, value=direction)
    length = float(np.linalg.norm(given))
    if length < SHORTEST_DIRECTION:
        rule = "must not have zero length: it is a direction in tip axes, such as [0, 0, 1]."
        raise InputError("contact", rule, key=key, value=direction)
    n = given / length
    if len(components) < len(WRENCH_COMPONENTS):
        first, second, out = triple_axes(components)
        if abs(n[out]) > OUT_OF_PLANE:
            rule = (
                f"must lie in the plane of the planar cell: the tip's {'xyz'[out]} axis is normal to it. Give what "
                "holds out of the plane as a box."
            )
            raise InputError("contact", rule, key=key, value=direction)
        return np.array([[n[second], -n[first], 0.0], [n[first], n[second], 0.0], [0.0, 0.0, 1.0]])
    a = np.eye(3)[1 if np.argmax(np.abs(n)) == 0 else 0]
    a = a - (a @ n) * n
    a /= np.linalg.norm(a)
    return np.array([a, np.cross(n, a), n])


def in_object_axes(rows: Array, R_object_tip: Array, components: Sequence[str]) -> Array:
    """Rows over a wrench in tip axes as rows over it in object axes, Shape (r, w).

    Args:
        rows: Shape (r, w).
        R_object_tip: Rotation of the grasp, Shape (3, 3).
        components: Of the cell's wrenches.

    Raises:
        InputError: If a planar cell's tip link has no axis along the plane's normal.
    """
    there = tip_components(components, R_object_tip)
    if there is None:
        raise InputError("contact", NOT_IN_PLANE, key="frame", value="tip")
    turn = R_object_tip[np.ix_(triple_axes(components), triple_axes(there))].T
    return in_tip_axes(rows, turn)


def in_tip_axes(rows: Array, axes: Array) -> Array:
    """Rows over a wrench in contact axes as rows over it in tip axes, Shape (r, w).

    Args:
        rows: Shape (r, w).
        axes: From `contact_axes`.
    """
    return np.hstack([multiply(part, axes) for part in np.split(rows, rows.shape[1] // 3, axis=1)])
