# SPDX-License-Identifier: MIT
"""What squares of torques weigh where nothing else is asked for, on the desktop and in an exported library."""

import numpy as np

from mrts.base.arrays import Array

WEIGHT_SPREAD = 1e6
"""Largest ratio of weights: the programs are solved to 1e-9, and the lightest torque must still be felt."""


def weights_by_limits(lower: Array, upper: Array) -> Array:
    """The diagonal of W = diag(1 / τ̂²), τ̂ the larger side of each limit, Shape (m,).

    Within `WEIGHT_SPREAD` about the middle limit: neither a placeholder nor a joint that may do nothing makes all
    others weigh alike.
    """
    limit = np.maximum(np.abs(lower), np.abs(upper))
    known = np.sort(limit[np.isfinite(limit) & (limit > 0)])
    middle, most = (known[len(known) // 2] if len(known) else 1.0), WEIGHT_SPREAD**0.25
    return np.asarray(1 / np.clip(limit, middle / most, middle * most) ** 2, dtype=np.float64)
