# SPDX-License-Identifier: MIT
"""A contact: the wrenches that a hand can exert on the object, as named two-sided rows."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from types import NoneType
from typing import Any, Literal, TypeGuard

import numpy as np

from mrts.base.argument_types import check_list, check_type
from mrts.base.arrays import Array, freeze_array
from mrts.base.errors import InputError, as_array
from mrts.base.input_file import plain
from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.base.rigid_transform import multiply

Frame = Literal["tip", "object", "base"]

FRAMES: tuple[Frame, ...] = ("tip", "object", "base")
"""Axes in which a contact may be told."""

SHORTEST_DIRECTION = 1e-9
"""A direction is given by numbers near 1: what is shorter is zero, misprinted."""

OUT_OF_PLANE = 1e-9
"""Largest entry of a rotation or direction that still counts as zero."""

NOT_IN_PLANE = (
    "is in tip axes, of which one must be normal to the plane of a planar cell. Turn the tip frame in the URDF and the "
    "grasp with it, or give a box in the frame of the object or the base."
)


@dataclass(frozen=True, repr=False, eq=False)
class Contact:
    """r rows lower <= A F <= upper over the wrench F that a hand exerts **on the object** at its contact point.

    The contact point is the tip frame's origin: moments are about it in every frame. Several contacts of one robot
    must all hold for its one wrench. Make them by `mrts.pad_contact` and its neighbours, or row by row.

    Attributes:
        name: Such as "pad", without blanks; each contact of a robot has its own.
        frame: In which axes F is: of the "tip" link, of the "object", or of the robot's "base".
        rows: What each row limits, such as "friction +a".
        units: One a row.
        A: Shape (r, w).
        lower: Minus infinity where unbounded, Shape (r,).
        upper: Infinity where unbounded, Shape (r,). A row whose limit is 0 is measured by the largest limit of the
            contact that has its unit.
        given: The entry of a cell file that says the same, such as {"pad": {…}}; None where there is none.

    Raises:
        InputError: If an array has another shape, holds what is no number, or a row limits nothing.
    """

    name: str
    frame: Frame
    rows: tuple[str, ...]
    units: tuple[str, ...]
    A: Array
    lower: Array
    upper: Array
    given: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        check_type("contact: name", self.name, str)
        check_type("contact: given", self.given, Mapping, NoneType)
        where = f"contact '{self.name}'"
        if not self.name or self.name != "".join(self.name.split()):
            raise InputError("contact", "its name must be text without blanks.", key="name", value=self.name)
        if not isinstance(self.frame, str) or self.frame not in FRAMES:
            raise InputError(where, f"must be {', '.join(FRAMES)}.", key="frame", value=self.frame)
        for key in ("rows", "units"):
            check_list(f"{where}: {key}", getattr(self, key), str)
            object.__setattr__(self, key, tuple(getattr(self, key)))
        count = len(self.rows)
        if len({*self.rows}) < count or len(self.units) != count or not count:
            raise InputError(where, "must name at least one row, each by its own name, with a unit a row.", key="rows")
        columns = as_array(f"{where}: A", self.A).shape[-1:]
        if columns not in {(3,), (len(WRENCH_COMPONENTS),)}:
            rule = "must have 6 columns (fx, fy, fz, nx, ny, nz), in a planar cell 3."
            raise InputError(where, rule, key="A", value=self.A)
        freeze_array(self, "A", where, (count, *columns), finite=True)
        for key in ("lower", "upper"):
            freeze_array(self, key, where, (count,), finite=False)
        limited = np.isfinite(self.lower) | np.isfinite(self.upper)
        sound = limited & (self.lower <= self.upper) & (self.lower < np.inf) & (self.upper > -np.inf)
        sound &= np.any(self.A != 0, axis=1)
        if not np.all(sound):
            row = int(np.argmin(sound))
            rule = f"row '{self.rows[row]}' must hold a number beside 0 and have limits, lower <= upper."
            raise InputError(where, rule, key="lower, upper", value=[float(self.lower[row]), float(self.upper[row])])

    def __reduce__(self) -> tuple[Any, ...]:
        return Contact, tuple(getattr(self, entry.name) for entry in fields(self))  # arrays come back validated, frozen

    def __repr__(self) -> str:
        return f"<Contact '{self.name}': {len(self.rows)} rows in {self.frame} axes>"


def holds(values: object, count: int) -> TypeGuard[Sequence[Any]]:
    """Whether values are a list, a tuple or an array of so many entries."""
    if isinstance(values, np.ndarray):
        return bool(values.shape[:1] == (count,))
    return isinstance(values, list | tuple) and len(values) == count


def check_components(components: object) -> None:
    """Refuse what does not name the components of a wrench."""
    known = isinstance(components, list | tuple) and {*map(str, components)} <= {*WRENCH_COMPONENTS}
    if not known or not any(holds(components, count) for count in (3, len(WRENCH_COMPONENTS))):
        rule = f"must be {', '.join(WRENCH_COMPONENTS)}, or in a plane three of them."
        raise InputError("contact", rule, key="components", value=components)


def as_given(kind: str, **values: Any) -> dict[str, Any]:
    """The entry of a cell file that stands for a contact made in Python."""
    plain_values = {key: plain("contact", value) for key, value in values.items() if value is not None}
    return {kind: plain_values}


def numbered(kinds: Sequence[str]) -> list[str]:
    """Names of a robot's contacts from their kinds: "pad", and a second one "pad2"."""
    seen: Counter[str] = Counter()
    names = []
    for kind in kinds:
        seen[kind] += 1
        names.append(kind if seen[kind] == 1 else f"{kind}{seen[kind]}")
    return names


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
    """Rows over a wrench in tip axes as rows over it in object axes, Shape (r, w)."""
    there = tip_components(components, R_object_tip)
    if there is None:
        raise InputError("contact", NOT_IN_PLANE, key="frame", value="tip")
    turn = R_object_tip[np.ix_(triple_axes(components), triple_axes(there))].T
    return in_tip_axes(rows, turn)


def in_tip_axes(rows: Array, axes: Array) -> Array:
    """Rows over a wrench in contact axes as rows over it in tip axes, Shape (r, w)."""
    return np.hstack([multiply(part, axes) for part in np.split(rows, rows.shape[1] // 3, axis=1)])
