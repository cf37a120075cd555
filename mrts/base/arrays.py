# SPDX-License-Identifier: MIT
"""Arrays of floating-point numbers: what nobody may write to, what JSON says of them, and products at every sample."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Owner = TypeVar("Owner")


def freeze(owner: object) -> None:
    """Make all arrays of a value such that nobody can write to them."""
    for value in vars(owner).values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)


def with_part(owner: Owner, arrays: Iterable[str], part: Any, **changes: Any) -> Owner:
    """A dataclass with a part of each of these arrays, where they are not None, and other changes; as numpy indexes."""
    for name in arrays:
        array = getattr(owner, name)
        if array is not None:
            changes[name] = array[part]
    return replace(owner, **changes)  # type: ignore[type-var]  # it is a dataclass


def changed(owner: Owner, **values: Any) -> Owner:
    """A dataclass with other values, which are not checked; nobody can write to its arrays."""
    ours = object.__new__(type(owner))
    vars(ours).update(vars(owner) | values)
    freeze(ours)
    return ours


class EqualByNumbers:
    """A dataclass whose values are equal if their fields are, arrays by their numbers."""

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and all(
            np.array_equal(value, getattr(other, name)) for name, value in vars(self).items()
        )

    __hash__ = None  # type: ignore[assignment]  # it holds arrays


def apply(matrix: NDArray[np.floating[Any]], vector: Array) -> Array:
    """Matrix times vector sample by sample: Shape (N, r, k) and (N, k) to (N, r)."""
    return np.asarray(np.einsum("nrk,nk->nr", matrix, vector), dtype=np.float64)


def row_products(first: Array, second: Array) -> Array:
    """Scalar products row by row, of two of Shape (N, k): Shape (N,)."""
    products: Array = np.einsum("nk,nk->n", first, second)
    return products


def rotated(rotation: Array, vector: Array) -> Array:
    """One vector, Shape (3,), or matrix, Shape (3, k), turned by many rotations, Shape (N, 3, 3): Shape (N, 3, …)."""
    turned: Array = (rotation.reshape(-1, 3) @ vector).reshape(len(rotation), 3, *vector.shape[1:])
    return turned


def cross(first: Array, second: Array) -> Array:
    """Cross products sample by sample, Shape (…, 3): the same numbers as numpy's, without its handling of axes."""
    a, b, c = first[..., 0], first[..., 1], first[..., 2]
    d, e, f = second[..., 0], second[..., 1], second[..., 2]
    found: Array = np.empty(
        first.shape if first.shape == second.shape else np.broadcast_shapes(first.shape, second.shape)
    )
    found[..., 0] = b * f - c * e
    found[..., 1] = c * d - a * f
    found[..., 2] = a * e - b * d
    return found


def median(values: Array) -> float:
    """The median of numbers, Shape (N,), N at least 1; numpy's imports numpy.ma, a tenth of a start."""
    middle = len(values) // 2
    ordered = np.partition(values, (middle - 1, middle))
    return float(ordered[middle] if len(values) % 2 else (ordered[middle - 1] + ordered[middle]) / 2)


def without_infinity(values: Array) -> list[float | None]:
    """Values as JSON has them: None stands for an infinite one."""
    return [value if np.isfinite(value) else None for value in values.tolist()]
