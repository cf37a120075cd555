# SPDX-License-Identifier: MIT
"""Wrenches of a surface that presses with friction: in every row, how much normal force they need."""

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from mrts.base.argument_types import is_number
from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.input_file import LARGEST_NUMBER
from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.cell.hands.contact import Contact, holds
from mrts.cell.hands.contact_axes import in_tip_axes

SMALLEST = 1e-6
"""Of a coefficient of friction, of a half width [m] and of a force [N]: what is smaller is a misprint, or zero."""

NORMAL_FORCE = "normal force"
"""Name of the row of how hard a surface presses."""


def positive(key: str, value: object) -> float:
    """A number that a hand needs.

    Raises:
        InputError: Unless it is at least `SMALLEST` and finite.
    """
    if not is_number(value, SMALLEST, LARGEST_NUMBER):
        raise InputError("contact", f"must be a number > 0, at least {SMALLEST:g}.", key=key, value=value)
    return float(value)  # type: ignore[arg-type]  # is_number has seen to it


def pyramid(friction: object, components: Sequence[str]) -> float:
    """Largest tangential over normal force along one contact axis, by itself.

    In space the pyramid is the one inside Coulomb's round cone, friction / √2 along each axis, so that a surface which
    keeps it keeps the cone. In a plane there is one direction, and both are the same.

    Args:
        friction: Coefficient of friction.
        components: Of the wrench.

    Raises:
        InputError: Unless it is a number > 0.
    """
    given = positive("friction", friction)
    return given / np.sqrt(2) if len(components) == len(WRENCH_COMPONENTS) else given


def half_widths(key: str, values: object, components: Sequence[str]) -> list[float]:
    """Half widths of a surface along its axes a and b; in a planar cell along a alone.

    Raises:
        InputError: If they are others, or not > 0.
    """
    count = 2 if len(components) == len(WRENCH_COMPONENTS) else 1
    if not holds(values, count):
        what = "[a, b], both half widths" if count > 1 else "[a]: in a planar cell the contact is a line"
        raise InputError("contact", f"must be {what}, in m.", key=key, value=values)
    return [positive(key, value) for value in values]


def normal_force_needed(mu: float, widths: Sequence[float]) -> dict[str, Array]:
    """What normal force each demand needs: a surface that presses with f_n can exert F if no row of F exceeds f_n.

    Of a rectangle the 16 rows of S. Caron, Q.-C. Pham, Y. Nakamura, "Stability of surface contacts for humanoid
    robots: closed-form formulae of the contact wrench cone for rectangular support areas", IEEE ICRA 2015; of a line in
    a plane 4. They are exactly the wrenches of forces at its corners inside friction pyramids.

    Args:
        mu: Of the pyramid, from `pyramid`.
        widths: Half widths of the surface.

    Returns:
        By name rows over (f_a, f_b, f_n, m_a, m_b, m_n) or (f_a, f_n, m), Shape (6,) or (3,), in N of normal force.
    """
    if len(widths) == 1:
        (width,) = widths
        rows = {f"friction {sign}a": [float(f"{sign}1") / mu, 0, 0] for sign in "+-"}
        rows |= {f"tilt {sign}": [0, 0, float(f"{sign}1") / width] for sign in "+-"}
        return {name: np.array(row, dtype=np.float64) for name, row in rows.items()}
    X, Y = widths
    f_a, f_b, _, m_a, m_b, m_n = np.eye(6)
    found: dict[str, Array] = {}
    for name, row in (("friction", f_a / mu), ("friction", f_b / mu), ("tilt", m_a / Y), ("tilt", m_b / X)):
        axis = "a" if row[0] or row[3] else "b"
        found |= {f"{name} {sign}{axis}": float(f"{sign}1") * row for sign in "+-"}
    for number, (turn, first, second) in enumerate(product((1, -1), repeat=3), start=1):
        row = turn * m_n + first * (Y * f_a + turn * mu * m_a) + second * (X * f_b + turn * mu * m_b)
        found[f"torsion {number}"] = row / (mu * (X + Y))
    return found


def surface_contact(
    name: str,
    needed: dict[str, Array],
    axes: Array,
    *,
    normal_force: tuple[float, float],
    pressed: float,
    given: dict[str, Any],
) -> Contact:
    """A surface that holds by friction what its normal force and what presses it besides can bear.

    Args:
        name: Of the contact.
        needed: Normal force that each demand needs, from `normal_force_needed`.
        axes: Turns a triple of a wrench from tip into contact axes (`mrts.cell.hands.contact_axes.contact_axes`).
        normal_force: Least and most f_n [N].
        pressed: What presses the surface besides f_n [N].
        given: Its entry in a cell file.
    """
    along = np.zeros(len(next(iter(needed.values()))))
    along[2 if len(along) == len(WRENCH_COMPONENTS) else 1] = 1.0
    rows = np.array([along, *(row - along for row in needed.values())])
    return Contact(
        name=name,
        frame="tip",
        rows=(NORMAL_FORCE, *needed),
        units=("N",) * len(rows),
        A=in_tip_axes(rows, axes),
        lower=np.array([normal_force[0], *(-np.inf for _ in needed)]),
        upper=np.array([normal_force[1], *(pressed for _ in needed)]),
        given=given,
    )
