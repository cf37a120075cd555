# SPDX-License-Identifier: MIT
"""Rows that are the sides of a regular polygon, taken as the circle that goes through its corners: norms and cones."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array

if TYPE_CHECKING:
    from mrts.limits.rows import RowName


def polygons(names: Sequence["RowName"]) -> dict["RowName", NDArray[np.intp]]:
    """Places of the rows of each name whose rows are sides of a polygon."""
    places: dict[RowName, list[int]] = {}
    for place, name in enumerate(names):
        if name.sides:
            places.setdefault(name, []).append(place)
    return {name: np.array(own, dtype=np.intp) for name, own in places.items()}


def circle(sides: Array) -> tuple[Array, Array]:
    """√(zᵀ gram z) <= bound z of the circle through the corners of a regular polygon, sides s z <= 0.

    Args:
        sides: Shape (…, number of sides, k).

    Returns:
        gram, Shape (…, k, k), and bound, (…, k).
    """
    count = sides.shape[-2]
    mean = np.mean(sides, axis=-2)
    across = sides - mean[..., None, :]
    gram: Array = (2 / count * np.cos(np.pi / count) ** 2) * np.swapaxes(across, -1, -2) @ across
    return gram, -mean


def in_circles(names: Sequence["RowName"], above: Array, below: Array) -> None:
    """Put what the circle of each polygon is passed by at all its sides, above.

    Args:
        names: One a row.
        above: By what each row passes its upper limit, minus infinity where there is none, Shape (…, r).
        below: Likewise its lower limit.
    """
    for own in polygons(names).values():
        sides = np.concatenate([above[..., own], below[..., own]], axis=-1)
        gram, bound = circle(sides[..., np.isfinite(sides[(0,) * (sides.ndim - 1)]), None])
        above[..., own], below[..., own] = np.sqrt(gram[..., 0]) - bound, -np.inf
