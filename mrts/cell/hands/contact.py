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
from mrts.base.notebook.in_notebooks import InNotebooks

Frame = Literal["tip", "object", "base"]

FRAMES: tuple[Frame, ...] = ("tip", "object", "base")
"""Axes in which a contact may be told."""


@dataclass(frozen=True, repr=False, eq=False)
class Contact(InNotebooks):
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
    """Refuse what does not name the components of a wrench.

    Raises:
        InputError: Unless it is all six names, or three of them for a plane.
    """
    known = isinstance(components, list | tuple) and {*map(str, components)} <= {*WRENCH_COMPONENTS}
    if not known or not any(holds(components, count) for count in (3, len(WRENCH_COMPONENTS))):
        rule = f"must be {', '.join(WRENCH_COMPONENTS)}, or in a plane three of them."
        raise InputError("contact", rule, key="components", value=components)


def as_given(kind: str, **values: Any) -> dict[str, Any]:
    """The entry of a cell file that stands for a contact made in Python.

    Args:
        kind: Such as "pad".
        **values: What it was made of; None stands for what is left out.
    """
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
