# SPDX-License-Identifier: MIT
"""Rows that are the sides of a regular polygon, taken as the circle that goes through its corners: norms and cones."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array

if TYPE_CHECKING:
    from mrts.limits.rows import RowName

FEW = 8
"""Rows of a polygon that are enough to tell its circle."""


def polygons(names: Sequence["RowName"]) -> dict["RowName", NDArray[np.intp]]:
    """Places of the rows of each name whose rows are sides of a polygon."""
    places: dict[RowName, list[int]] = {}
    for place, name in enumerate(names):
        if name.sides:
            places.setdefault(name, []).append(place)
    return {name: np.array(own, dtype=np.intp) for name, own in places.items()}


def few_sides(names: Sequence["RowName"]) -> NDArray[np.bool_]:
    """Rows without those sides of polygons that their circles do not need, Shape (r,)."""
    kept = np.ones(len(names), dtype=bool)
    for own in polygons(names).values():
        if len(own) % FEW == 0:
            kept[own] = np.arange(len(own)) % (len(own) // FEW) == 0
    return kept


def circle(sides: Array, count: int) -> tuple[Array, Array]:
    """√(zᵀ gram z) <= bound z of the circle through the corners of a regular polygon, sides s z <= 0.

    Args:
        sides: All, or at least three as far from each other as the last from the first, Shape (…, some, k).
        count: Number of all.

    Returns:
        gram, Shape (…, k, k), and bound, (…, k).
    """
    mean = np.mean(sides, axis=-2)
    across = sides - mean[..., None, :]
    scale = 2 / sides.shape[-2] * np.cos(np.pi / count) ** 2
    gram: Array = scale * np.swapaxes(across, -1, -2) @ across
    return gram, -mean


def in_circles(names: Sequence["RowName"], above: Array, below: Array) -> None:
    """Put what the circle of each polygon is passed by at all its sides, above.

    Args:
        names: One a row.
        above: By what each row passes its upper limit, minus infinity where there is none, Shape (…, r).
        below: Likewise its lower limit.
    """
    for name, own in polygons(names).items():
        sides = np.concatenate([above[..., own], below[..., own]], axis=-1)
        gram, bound = circle(sides[..., np.isfinite(sides[(0,) * (sides.ndim - 1)]), None], name.sides)
        above[..., own], below[..., own] = np.sqrt(gram[..., 0]) - bound, -np.inf
