# SPDX-License-Identifier: MIT
"""A parallel gripper: two pads that squeeze the object from both sides."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from mrts.base.arrays import Array
from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.cell.hands.contact import Contact, as_given
from mrts.cell.hands.contact_axes import contact_axes, in_tip_axes
from mrts.cell.hands.friction import half_widths, positive, pyramid


def gripper_contact(
    *,
    force: float,
    friction: float,
    half_width: Sequence[float],
    axis: Sequence[float],
    components: Sequence[str] = WRENCH_COMPONENTS,
    name: str = "gripper",
) -> Contact:
    """Two pads, one from each side, whose normal forces add up to twice the grip force: 30 rows, in a plane 3.

    What the object pulls along the axis one pad bears more and the other less, as where the jaws are coupled. The pads
    count as lying in one plane at the tip's origin: how far the jaws are open adds no lever. The rows are in N: the sum
    of both normal forces that it takes.

    Args:
        force: Grip force: with which each pad presses when nothing pulls [N].
        friction: Coefficient of friction of the pads with the object, > 0.
        half_width: Of a pad along the axes a and b (`mrts.cell.hands.contact_axes.contact_axes`) [m]; planar: [a].
        axis: Along which the jaws close, in tip axes, Shape (3,).
        components: Of the wrench in tip axes.
        name: Of the contact.

    Raises:
        InputError: If a value breaks a rule.
    """
    axes = contact_axes("axis", axis, components)
    both = 2 * positive("force", force)
    mu, widths = pyramid(friction, components), half_widths("half_width", half_width, components)
    rows = _in_plane(mu, *widths) if len(widths) == 1 else _in_space(mu, *widths)
    return Contact(
        name=name,
        frame="tip",
        rows=tuple(rows),
        units=("N",) * len(rows),
        A=in_tip_axes(np.array(list(rows.values())), axes),
        lower=np.full(len(rows), -both),
        upper=np.full(len(rows), both),
        given=as_given("gripper", force=force, friction=friction, half_width=half_width, axis=axis),
    )


def _in_plane(mu: float, width: float) -> dict[str, Array]:
    """Rows over (f_a, f_n, m)."""
    f_a, f_n, m = np.eye(3)
    return {"friction a": f_a / mu, "along the axis": f_n, "tilt": m / width}


def _in_space(mu: float, X: float, Y: float) -> dict[str, Array]:
    """Rows over (f_a, f_b, f_n, m_a, m_b, m_n): the sum of normal forces that each demand takes, of both signs.

    Corner i at (x_i, y_i) carries d_i n along the axis, |d_i| <= s_i, and friction |f_a|, |f_b| <= μ s_i, where the
    s_i >= 0 add up to both normal forces. These rows are the facets of what the corners reach together. Reflection of
    a, of b and of the axis, and friction the other way, turn one facet into others: of each kind one is written down.
    """
    f_a, f_b, f_n, m_a, m_b, m_n = np.eye(6)
    found = {
        "friction a": f_a / mu,
        "friction b": f_b / mu,
        "along the axis": f_n,
        "tilt a": m_a / Y,
        "tilt b": m_b / X,
        "torsion": m_n / (mu * (X + Y)),
    }
    around = Y * f_a / mu + X * f_b / mu + m_n / mu
    kinds = (
        (Y * (f_a / mu + f_n) + m_a + m_n / mu) / (2 * Y + X),
        (X * (f_b / mu + f_n) + m_b + m_n / mu) / (2 * X + Y),
        (around + (X + Y) * f_n + m_a + m_b) / (2 * (X + Y)),
        (around + (X - Y) * f_n - m_a + m_b) / (2 * (X + Y)),
    )
    reflections = np.array([[-1, 1, 1, 1, -1, -1], [1, -1, 1, -1, 1, -1], [1, 1, -1, -1, -1, 1], [-1, -1, 1, 1, 1, -1]])
    for kind in kinds:
        for chosen in product((False, True), repeat=4):
            row = kind * np.prod(reflections[list(chosen)], axis=0)
            if not any(np.array_equal(row, side) or np.array_equal(row, -side) for side in found.values()):
                found[f"combined {len(found) - 5}"] = row
    return found
