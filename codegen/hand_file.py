# SPDX-License-Identifier: MIT
"""`contact` of the cell file: what each hand can exert on the object, as arguments of what makes contacts in Python."""

from collections.abc import Sequence
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, Literal

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.pose import Finite
from mrts.base.formats.record import checked_fields
from mrts.cell.hands import KINDS, NOT_IN_PLANE, Contact, numbered, tip_components

MOST_CONTACTS = 20
"""Of one robot."""

ContactDescription = dict[
    Literal["box", "pad", "suction", "gripper", "rows"],
    dict[str, Finite | bool | str | list[Finite | None] | list[list[Finite]] | None],
]
"""One contact: its kind, and the arguments of `mrts.pad_contact` or its neighbours; see docs/cell_file.md."""


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
        zip(descriptions, numbered([next(iter(given), "") for given in descriptions]), strict=True)
    ):
        if len(given) != 1:
            rule = (
                f"each entry of 'contact' is one of {', '.join(KINDS)}, such as "
                "'- pad: {friction: 0.5, normal: [0, 0, 1], half_width: [0.03, 0.02], force: [0, 100]}'."
            )
            raise InputError(path, rule, key=f"{key}[{place}]")
        ((kind, values),) = given.items()
        here = f"{key}[{place}].{kind}"
        there = in_tip if values.get("frame", "tip") == "tip" else components
        if there is None:
            raise InputError(path, NOT_IN_PLANE, key=here)
        try:
            contacts.append(KINDS[kind](**_arguments(kind, values), components=there, name=name))
        except InputError as error:
            raise error.inside(path, here) from None
    return tuple(contacts)


def _arguments(kind: str, values: dict[str, Any]) -> dict[str, Any]:
    """Values of a file by argument, with those that they leave out."""
    taken = {name: of for name, of in signature(KINDS[kind]).parameters.items() if name not in {"components", "name"}}
    defaults = {name: of.default for name, of in taken.items() if of.default is not Parameter.empty}
    return checked_fields(dict.fromkeys(taken, Any), defaults, values)
