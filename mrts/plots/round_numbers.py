# SPDX-License-Identifier: MIT
"""Round numbers: of grids, of the scale of arrows, of axes."""

from collections.abc import Sequence

import numpy as np

ROUNDED_DOWN = 1e-9
"""A number below a round one by this share is that one: rounding of a quotient."""


def round_down(value: float, digits: Sequence[int] = (1, 2, 5)) -> float:
    """The largest round number that is not above a value: a digit times a power of ten.

    Args:
        value: > 0.
        digits: That are round, with 1.
    """
    power = 10.0 ** np.floor(np.log10(value))
    most = value / power * (1 + ROUNDED_DOWN)
    return float(max(digit for digit in (*digits, 10) if digit <= most) * power)
