# SPDX-License-Identifier: MIT
"""Bounds of a contact wrench in the axes of its robot's base, as they are given."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.manifest import WRENCH_COMPONENTS


def given_wrench_limits(
    where: Path | str,
    key: str,
    lower: Sequence[float | None] | None,
    upper: Sequence[float | None] | None,
    size: int,
) -> tuple[Array, Array]:
    """Bounds of the wrench that a hand exerts, infinite where there is none, each Shape (w,) [N, N m].

    Args:
        where: The file, or what else they are given in, for messages.
        key: Of the bounds in it.
        lower: None is unbounded, a component or the whole side.
        upper: Likewise.
        size: Components of a wrench, 3 in a planar cell, else 6.

    Raises:
        InputError: If one side has another length, or a lower bound exceeds the upper one.
    """
    sides = []
    for name, values, unbounded in (("lower", lower, -np.inf), ("upper", upper, np.inf)):
        if values is not None and len(values) != size:
            planar = "two forces and the moment about the plane's normal"
            what = ", ".join(WRENCH_COMPONENTS) if size == len(WRENCH_COMPONENTS) else planar
            rule = f"must have {size} values ({what}); null is unbounded."
            raise InputError(where, rule, key=f"{key}.{name}", value=values)
        filled = [unbounded if value is None else value for value in values or [None] * size]
        sides.append(np.array(filled, dtype=float))
    least, most = sides
    if np.any(least > most):
        component = int(np.argmax(least > most))
        rule = f"its lower bound {least[component]:g} exceeds its upper bound {most[component]:g}."
        raise InputError(where, rule, key=f"{key}[{component}]")
    return least, most
