# SPDX-License-Identifier: MIT
"""A rectangular pad that is pressed on the object, with friction."""

from collections.abc import Sequence

from mrts.base.argument_types import check_type, is_number
from mrts.base.errors import InputError
from mrts.base.input_file import LARGEST_NUMBER
from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.cell.hands.contact import Contact, as_given, holds
from mrts.cell.hands.contact_axes import contact_axes
from mrts.cell.hands.friction import half_widths, normal_force_needed, pyramid, surface_contact


def pad_contact(
    *,
    friction: float,
    normal: Sequence[float],
    half_width: Sequence[float],
    force: Sequence[float],
    pull: bool = False,
    components: Sequence[str] = WRENCH_COMPONENTS,
    name: str = "pad",
) -> Contact:
    """A pad that presses with f_n = normal · f, least <= f_n <= most, and needs no more than that: 17 rows.

    The rows of friction, tilt and torsion are in N: the normal force that lacks, at most 0.

    Args:
        friction: Coefficient of friction with the object, > 0.
        normal: From the hand into the object, in tip axes, Shape (3,): pressing is positive.
        half_width: Of the pad along its axes a and b (`mrts.cell.hands.contact_axes.contact_axes`) [m]; planar: [a].
        force: Least and most normal force, 0 <= least < most [N].
        pull: That the normal is meant to point out of the object, as from inside a hollow: a cell file is refused where
            it does so without.
        components: Of the wrench in tip axes.
        name: Of the contact.

    Raises:
        InputError: If a value breaks a rule.
    """
    check_type("contact: pull", pull, bool)
    axes = contact_axes("normal", normal, components)
    needed = normal_force_needed(pyramid(friction, components), half_widths("half_width", half_width, components))
    pair = holds(force, 2)
    if not pair or not all(is_number(value, 0, LARGEST_NUMBER) for value in force) or not force[0] < force[1]:
        rule = "must be [least, most] normal force in N with 0 <= least < most: a pad presses and cannot pull."
        raise InputError("contact", rule, key="force", value=force)
    given = as_given("pad", friction=friction, normal=normal, half_width=half_width, force=force, pull=pull or None)
    return surface_contact(name, needed, axes, normal_force=(force[0], force[1]), pressed=0.0, given=given)
