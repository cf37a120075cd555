# SPDX-License-Identifier: MIT
"""A suction cup that holds the object."""

from collections.abc import Sequence

import numpy as np

from mrts.base.argument_types import check_type
from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.cell.hands.contact import Contact, as_given
from mrts.cell.hands.contact_axes import contact_axes
from mrts.cell.hands.friction import normal_force_needed, positive, pyramid, surface_contact


def suction_contact(
    *,
    holding_force: float,
    friction: float,
    radius: float,
    normal: Sequence[float],
    pull: bool = False,
    components: Sequence[str] = WRENCH_COMPONENTS,
    name: str = "suction",
) -> Contact:
    """A cup that the vacuum presses on the object with its holding force, so that f_n >= -holding_force: 17 rows.

    Its lip bears holding_force + f_n, f_n = normal · f, by friction, at the corners of the square inside its circle: so
    what the rows admit a round lip of that radius bears. They are in N: the normal force that it takes, at most the
    holding force.

    Args:
        holding_force: By which it can pull at most, underpressure times area [N].
        friction: Coefficient of friction of the lip with the object, > 0.
        radius: Of the lip [m].
        normal: From the hand into the object, in tip axes, Shape (3,).
        pull: That the normal is meant to point out of the object, as from inside a hollow: a cell file is refused where
            it does so without.
        components: Of the wrench in tip axes.
        name: Of the contact.

    Raises:
        InputError: If a value breaks a rule.
    """
    check_type("contact: pull", pull, bool)
    axes = contact_axes("normal", normal, components)
    holding, width = positive("holding_force", holding_force), positive("radius", radius)
    in_space = len(components) == len(WRENCH_COMPONENTS)
    widths = [width / np.sqrt(2)] * 2 if in_space else [width]
    needed = normal_force_needed(pyramid(friction, components), widths)
    given = as_given(
        "suction", holding_force=holding_force, friction=friction, radius=radius, normal=normal, pull=pull or None
    )
    return surface_contact(name, needed, axes, normal_force=(-holding, np.inf), pressed=holding, given=given)
