# SPDX-License-Identifier: MIT
"""Names as labels of a picture: printable, and short enough to stand beside a plot."""

from collections.abc import Sequence

from mrts.base.printable import cut, printable
from mrts.limits.rows import STANDSTILL, ActiveRow

MOST_NAMES = 3
"""Rows that a short list names."""

LONGEST_LABEL = 44
"""Letters of a label."""

LANE_LETTERS = 32
"""Letters of a row's name beside its lane."""

MOST_LETTERS = 128
"""Of names that are alike where they are shorter."""


def shortened(name: str, longest: int = LONGEST_LABEL) -> str:
    """A printable name whose middle is left out where it is too long."""
    return cut(printable(name), longest)


def shortened_apart(names: Sequence[str], longest: int = LANE_LETTERS) -> list[str]:
    """Names as `shortened`, as long as it takes to tell them apart.

    Args:
        names: Beside each other.
        longest: Letters of each, where that suffices.
    """
    short = [shortened(name, longest) for name in names]
    if len({*short}) == len({*names}) or longest >= MOST_LETTERS:
        return short
    return shortened_apart(names, 2 * longest)


def row_label(row: ActiveRow) -> str:
    """A row in a few letters: `left/elbow ↑` at its upper limit, ↓ at its lower one."""
    name = row.name
    if name == STANDSTILL or not name.robot:
        return str(name)
    return f"{name.short} {'↑' if row.side == 'upper' else '↓'}"


def row_labels(rows: Sequence[ActiveRow], most: int = MOST_NAMES) -> str:
    """The first rows in a few letters, and how many more there are."""
    more = f" and {len(rows) - most} more" if len(rows) > most else ""
    return ", ".join(row_label(row) for row in rows[:most]) + more
