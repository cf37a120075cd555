# SPDX-License-Identifier: MIT
"""Energy given since the start of a trajectory."""

import numpy as np

from mrts.base.arrays import Array


def accumulated_energy(time: Array, power: Array) -> Array:
    """Σ ∫ q̇ᵀ τ dt from the start to every sample, by the trapezoidal rule, Shape (N,) [J].

    Args:
        time: Shape (N,) [s].
        power: Of some joints, Shape (N, joints) [W].
    """
    total = np.sum(power, axis=1)
    steps = np.diff(time) * (total[1:] + total[:-1]) / 2
    return np.concatenate([[0.0], np.cumsum(steps)])
