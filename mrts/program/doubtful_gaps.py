# SPDX-License-Identifier: MIT
"""Between which samples a quantity may be larger than at any of them."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array

RESOLUTION = 1e-6
"""Share of the duration below which no two samples are told apart: what jumps there has been seen on both sides."""


def doubtful_gaps(time: Array, value: Array, allowed: float) -> NDArray[np.intp]:
    """Gaps between samples in which a quantity may exceed its largest sample by more than is allowed.

    A quantity that turns inside a gap, smoothly or at a corner, lies above its samples by at most a quarter of the gap
    times the change of slope around it.

    Args:
        time: Of N >= 2 samples, Shape (N,) [s].
        value: Shape (N,), finite.
        allowed: By how much.

    Returns:
        Indices of the samples before the gaps.
    """
    step = np.diff(time)
    above = np.maximum(value[:-1], value[1:]) + turning(step, value) > np.max(value) + allowed
    return np.flatnonzero(above & (step > RESOLUTION * time[-1]))


def turning(step: Array, value: Array) -> Array:
    """By how much a quantity may exceed its samples in each gap, Shape (N - 1,).

    Args:
        step: Widths of the gaps, Shape (N - 1,) [s].
        value: At the samples, Shape (N,).
    """
    slope = np.diff(value) / step
    change = np.abs(np.diff(slope))
    if not len(change):
        return np.full(len(step), np.inf)
    before, after = np.concatenate([change[:1], change]), np.concatenate([change, change[-1:]])
    bump: Array = step * (before + after) / 4
    return bump
