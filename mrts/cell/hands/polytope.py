# SPDX-License-Identifier: MIT
"""Any polytope of contact wrenches, row by row."""

from collections.abc import Sequence

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, as_array
from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.cell.hands.contact import Contact, as_given, check_components, holds

INTERIOR = 1e-6
"""Least radius of a ball in a polytope, as a share of how far its rows are from the origin: HiGHS is right to 1e-7."""


def rows_contact(
    *,
    A: Sequence[Sequence[float]],
    upper: Sequence[float],
    components: Sequence[str] = WRENCH_COMPONENTS,
    name: str = "rows",
) -> Contact:
    """Rows A F <= upper over the wrench in tip axes.

    A row with the limit 0 is measured by the largest limit among the rows, by 1 if all are 0: scale its numbers to
    suit.

    Args:
        A: Shape (r, w).
        upper: Shape (r,).
        components: Of the wrench in tip axes.
        name: Of the contact.

    Raises:
        InputError: If rows have another length, hold zeros only, or leave no ball of wrenches inside.
    """
    check_components(components)
    size = len(components)
    if (not isinstance(A, list | tuple) and np.ndim(A) != 2) or not all(holds(row, size) for row in A):  # noqa: PLR2004
        raise InputError("contact", f"each row must have {size} numbers: {', '.join(components)}.", key="A", value=A)
    rows, limits = as_array("A", A), as_array("upper", upper)
    if limits.ndim != 1 or not limits.size or not np.all(np.isfinite(limits)):
        raise InputError("contact", "must be one finite number a row of A.", key="upper", value=upper)
    if len(rows) != len(limits) or not np.all(np.isfinite(rows)):
        rule = f"must be finite numbers in {len(limits)} rows, as many as upper has numbers."
        raise InputError("contact", rule, key="A", value=A)
    empty = ~np.any(rows, axis=1)
    if np.any(empty):
        rule = f"row {int(np.argmax(empty)) + 1} is zero, so it says nothing of the wrench. Leave it out."
        raise InputError("contact", rule, key="A", value=rows[empty][0].tolist())
    if not has_interior(rows, limits):
        rule = (
            "leaves no wrench with room on every side. Check signs and limits; to fix a component, give a box with "
            "equal sides."
        )
        raise InputError("contact", rule, key="A, upper")
    return Contact(
        name=name,
        frame="tip",
        rows=tuple(str(row) for row in range(1, len(rows) + 1)),
        units=("",) * len(rows),
        A=rows,
        lower=np.full(len(rows), -np.inf),
        upper=limits,
        given=as_given("rows", A=A, upper=upper),
    )


def has_interior(A: Array, upper: Array) -> bool:
    """Whether a ball lies in A x <= upper: its largest radius, at most the rows' distance from the origin, is not 0.

    Args:
        A: Rows that are not zero, Shape (r, w).
        upper: Shape (r,).
    """
    from scipy.optimize import linprog  # noqa: PLC0415 (build time only, and slow to import)

    column = np.max(np.abs(A), axis=0)
    scaled = A / np.where(column > 0, column, 1.0)
    length = np.linalg.norm(scaled, axis=1)
    distance = upper / length
    reach = float(np.max(np.abs(distance))) or 1.0
    found = linprog(
        np.append(np.zeros(A.shape[1]), -1.0),
        A_ub=np.column_stack([scaled / length[:, None], np.ones(len(A))]),
        b_ub=distance / reach,
        bounds=[(None, None)] * A.shape[1] + [(0, 1)],
    )
    return found.x is not None and bool(found.x[-1] > INTERIOR)
