# SPDX-License-Identifier: MIT
"""`contact` of the cell file: what each hand can exert on the object, and the rows that it becomes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.pose import Finite, Vector3
from mrts.base.formats.record import Record, Rule
from mrts.cell.hands import KINDS, NOT_IN_PLANE, Bounds, Contact, numbered, tip_components

MOST_CONTACTS = 20
"""Of one robot."""


class BoxDescription(Bounds):
    """The same in chosen axes."""

    frame: Literal["tip", "base", "object"] = "tip"


class PadDescription(Record):
    """A rectangular pad that is pressed on the object."""

    friction: Finite
    normal: Vector3
    half_width: list[Finite]
    force: list[Finite]
    pull: bool = False


class SuctionDescription(Record):
    """A suction cup."""

    holding_force: Finite
    friction: Finite
    radius: Finite
    normal: Vector3
    pull: bool = False


class GripperDescription(Record):
    """Two pads that squeeze the object."""

    force: Finite
    friction: Finite
    half_width: list[Finite]
    axis: Vector3


class RowsDescription(Record):
    """Rows A F <= upper."""

    A: Annotated[list[list[Finite]], Rule(min_length=1)]
    upper: Annotated[list[Finite], Rule(min_length=1)]


class ContactDescription(Record):
    """One contact, of one kind; see docs/cell_file.md."""

    box: BoxDescription | None = None
    pad: PadDescription | None = None
    suction: SuctionDescription | None = None
    gripper: GripperDescription | None = None
    rows: RowsDescription | None = None

    def problem(self) -> str:
        """The rule that it breaks unless it is of one kind; empty if none."""
        if sum(value is not None for _, value in self) == 1:
            return ""
        return (
            f"each entry of 'contact' is one of {', '.join(self.model_fields)}, such as "
            "'- pad: {friction: 0.5, normal: [0, 0, 1], half_width: [0.03, 0.02], force: [0, 100]}'"
        )

    @property
    def kind(self) -> str:
        """Which it is."""
        return next(kind for kind, value in self if value is not None)


def build_contacts(
    path: Path,
    key: str,
    descriptions: Sequence[ContactDescription],
    components: Sequence[str],
    R_object_tip: Array,
) -> tuple[Contact, ...]:
    """The contacts of one robot."""
    in_tip = tip_components(components, R_object_tip)
    contacts = []
    for place, (given, name) in enumerate(
        zip(descriptions, numbered([given.kind for given in descriptions]), strict=True)
    ):
        values = getattr(given, given.kind).model_dump()
        here = f"{key}[{place}].{given.kind}"
        there = in_tip if values.get("frame", "tip") == "tip" else components
        if there is None:
            raise InputError(path, NOT_IN_PLANE, key=here)
        try:
            contacts.append(KINDS[given.kind](**values, components=there, name=name))
        except InputError as error:
            raise error.inside(path, here) from None
    return tuple(contacts)
