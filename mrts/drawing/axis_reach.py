# SPDX-License-Identifier: MIT
"""How far the vertical axis of a plot reaches, so that what matters fills it."""

import numpy as np

from mrts.base.arrays import Array
from mrts.scaling.range import ScalingRange

FARTHEST_LIMIT = 4.0
"""Limits beyond this many times the largest value are left outside: the values would be flat lines."""

ABOVE_THE_RANGE = 4.0
"""c²⁺(t) near rest can be thousands of times the range over the motion; it is followed up to this many times."""

MARGIN = 0.06
"""Left free above and below, as a share of what is shown."""


def value_reach(values: Array, limits: Array) -> tuple[float, float]:
    """Ends of an axis that shows values and their limits.

    Args:
        values: Finite, any shape.
        limits: Any shape, infinity where unbounded.
    """
    size = float(np.max(np.abs(values), initial=0.0))
    near = limits[np.isfinite(limits) & ((np.abs(limits) <= FARTHEST_LIMIT * size) | (size == 0))]
    shown = np.concatenate([values.ravel(), near.ravel(), [0.0]])
    low, high = float(np.min(shown)), float(np.max(shown))
    margin = MARGIN * (high - low) or 1.0
    return low - margin, high + margin


def c2_reach(found: ScalingRange) -> tuple[float, float]:
    """Ends of an axis that shows c²⁻(t), c²⁺(t) and the range over the motion.

    Args:
        found: The range over the motion.
    """
    upper, lower = (side[np.isfinite(side)] for side in (found.samples.upper, found.samples.lower))
    ends = [end.c2 for end in (found.lower, found.upper) if end is not None and np.isfinite(end.c2)]
    wanted = max([*ends, float(np.min(upper)) if upper.size else 0.0, 0.0])
    highest = max([*upper.tolist(), *lower.tolist(), 0.0])
    top = (min(highest, ABOVE_THE_RANGE * wanted) if wanted > 0 else highest) or 1.0
    return -MARGIN * top, (1 + MARGIN) * top
