# SPDX-License-Identifier: MIT
"""Which variants of a study are the best."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array


def fastest_first(variant: NDArray[np.int_], duration: Array) -> NDArray[np.intp]:
    """Rows of the variants that have a duration, the shortest first; of equals, that with the lower number.

    Args:
        variant: Their numbers, Shape (V,).
        duration: NaN or infinite where there is none, Shape (V,) [s].
    """
    rows = np.flatnonzero(np.isfinite(duration))
    return rows[np.lexsort((variant[rows], duration[rows]))]
