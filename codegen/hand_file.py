# SPDX-License-Identifier: MIT
"""`contact` of the cell file: what each hand can exert on the object, as arguments of what makes contacts in Python."""

from collections.abc import Callable, Sequence
from inspect import Parameter, signature
from pathlib import Path
from typing import Annotated, Any

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.record import Record, Rule, checked_fields
from mrts.cell.hands import KINDS, NOT_IN_PLANE, Contact, numbered, tip_components

MOST_CONTACTS = 20
"""Of one robot."""


class Arguments(Rule):
    """That the keys of a mapping are those of a function that makes contacts, and its values of the annotated kinds."""

    def __init__(self, function: Callable[..., Contact]) -> None:
        own = [one for name, one in signature(function).parameters.items() if name not in {"components", "name"}]
        self._kinds = {one.name: one.annotation for one in own}
        self._defaults = {one.name: one.default for one in own if one.default is not Parameter.empty}

    def check(self, value: Any, _given: object) -> None:
        """Check a mapping."""
        checked_fields(self._kinds, self._defaults, value)


class ContactDescription(Record):
    """One contact, of one kind; see docs/cell_file.md."""

    box: Annotated[dict[str, Any], Arguments(KINDS["box"])] | None = None
    pad: Annotated[dict[str, Any], Arguments(KINDS["pad"])] | None = None
    suction: Annotated[dict[str, Any], Arguments(KINDS["suction"])] | None = None
    gripper: Annotated[dict[str, Any], Arguments(KINDS["gripper"])] | None = None
    rows: Annotated[dict[str, Any], Arguments(KINDS["rows"])] | None = None

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
        values = getattr(given, given.kind)
        here = f"{key}[{place}].{given.kind}"
        there = in_tip if values.get("frame", "tip") == "tip" else components
        if there is None:
            raise InputError(path, NOT_IN_PLANE, key=here)
        try:
            contacts.append(KINDS[given.kind](**values, components=there, name=name))
        except InputError as error:
            raise error.inside(path, here) from None
    return tuple(contacts)
