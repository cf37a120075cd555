# SPDX-License-Identifier: MIT
"""Arrays of floating-point numbers: what nobody may write to, and products at every sample at once."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def freeze(owner: object) -> None:
    """Make all arrays of a value such that nobody can write to them."""
    for value in vars(owner).values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)


def apply(matrix: NDArray[np.floating[Any]], vector: Array) -> Array:
    """Matrix times vector sample by sample: Shape (N, r, k) and (N, k) to (N, r)."""
    return np.asarray(np.einsum("nrk,nk->nr", matrix, vector), dtype=np.float64)
