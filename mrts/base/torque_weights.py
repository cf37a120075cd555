# SPDX-License-Identifier: MIT
"""What squares of torques weigh where nothing else is asked for, on the desktop and in an exported library."""

import numpy as np

from mrts.base.arrays import Array

WEIGHT_SPREAD = 1e6
"""Largest ratio of weights: the programs are solved to 1e-9, and the lightest torque must still be felt."""


def weights_by_limits(lower: Array, upper: Array) -> Array:
    """The diagonal of W = diag(1 / τ̂²), τ̂ the larger side of each limit, within `WEIGHT_SPREAD`, Shape (m,).

    Args:
        lower: Of torques, Shape (m,) [N m or N]; a joint without a limit has the largest of the others, or 1.
        upper: Likewise.
    """
    limit = np.maximum(np.abs(lower), np.abs(upper))
    most = float(np.max(limit[np.isfinite(limit)], initial=0.0)) or 1.0
    return np.asarray(1 / np.clip(limit, most / np.sqrt(WEIGHT_SPREAD), most) ** 2, dtype=np.float64)
