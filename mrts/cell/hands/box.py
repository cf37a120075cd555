# SPDX-License-Identifier: MIT
"""Limits of each component of a contact wrench."""

from collections.abc import Sequence

import numpy as np

from mrts.base.arrays import without_infinity
from mrts.base.errors import InputError, as_array
from mrts.base.manifest import WRENCH_COMPONENTS, WRENCH_UNITS
from mrts.cell.hands.contact import Contact, Frame, as_given, check_components, holds


def box_contact(
    *,
    lower: Sequence[float | None] | None = None,
    upper: Sequence[float | None] | None = None,
    frame: Frame = "tip",
    components: Sequence[str] = WRENCH_COMPONENTS,
    name: str = "box",
) -> Contact:
    """Two-sided limits lower <= F <= upper, component by component; those without a limit make no row.

    Args:
        lower: None is unbounded, a component or the whole side; equal sides fix a component, Shape (w,) [N, N m].
        upper: Likewise.
        frame: Axes of F: "tip", "object" or "base".
        components: Of the wrench in these axes.
        name: Of the contact.

    Raises:
        InputError: If a side has another length, nothing is limited, or a lower limit exceeds the upper one.
    """
    check_components(components)
    size = len(components)
    sides = []
    for key, given, unbounded in (("lower", lower, -np.inf), ("upper", upper, np.inf)):
        values = [None] * size if given is None else given
        if not holds(values, size):
            rule = f"must have {size} values ({', '.join(components)}); null is unbounded."
            raise InputError("contact", rule, key=key, value=given)
        sides.append(as_array(key, [unbounded if value is None else value for value in values]))
    least, most = sides
    wrong = ~((least <= most) & (least < np.inf) & (most > -np.inf))
    if np.any(wrong):
        place = int(np.argmax(wrong))
        rule = (
            f"its lower limit of {components[place]}, {least[place]:g}, must be at most the upper one, {most[place]:g}."
        )
        raise InputError("contact", rule, key="lower", value=lower)
    limited = np.flatnonzero(np.isfinite(least) | np.isfinite(most)).tolist()
    if not limited:
        raise InputError("contact", "must limit something: give numbers in lower or upper, or leave the box out.")
    return Contact(
        name=name,
        frame=frame,
        rows=tuple(components[place] for place in limited),
        units=tuple(WRENCH_UNITS[components[place]] for place in limited),
        A=np.eye(size)[limited],
        lower=least[limited],
        upper=most[limited],
        given=as_given("box", lower=without_infinity(least), upper=without_infinity(most), frame=frame),
    )
