# SPDX-License-Identifier: MIT
"""Intervals as people read them."""

import numpy as np


def interval_text(low: float, high: float, unit: str = "", digits: int = 4) -> str:
    """Such as `[0, 3.062]`, `[-80, 80] N m`, `[0, ∞)`; "unbounded" without any end, "empty" where they are crossed."""
    if low > high:
        return f"empty (at least {low:.{digits}g}, but at most {high:.{digits}g})"
    if not (np.isfinite(low) or np.isfinite(high)):
        return "unbounded"
    left = f"[{low:.{digits}g}" if np.isfinite(low) else "(−∞"
    right = f"{high:.{digits}g}]" if np.isfinite(high) else "∞)"
    return f"{left}, {right} {unit}".rstrip()
