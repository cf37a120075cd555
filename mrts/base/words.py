# SPDX-License-Identifier: MIT
"""Short texts that several packages say: an interval, the first of many names, the lines of a table."""

from collections.abc import Iterator, Sequence

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


def first_names(names: Sequence[str], most: int) -> str:
    """The first names, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """The rows of a table as lines, each column as wide as its longest text."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip()
