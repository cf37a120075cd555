# SPDX-License-Identifier: MIT
"""Arrays of floating-point numbers, and products at every sample at once."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def apply(matrix: NDArray[np.floating[Any]], vector: Array) -> Array:
    """Matrix times vector sample by sample: Shape (N, r, k) and (N, k) to (N, r)."""
    return np.asarray(np.einsum("nrk,nk->nr", matrix, vector), dtype=np.float64)
