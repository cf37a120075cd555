# SPDX-License-Identifier: MIT
"""What figures and reports share: colours, and names that fit beside a plot."""

from mrts.base.printable import cut, printable

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito (2008): distinguishable with every kind of colour vision."""

ADMISSIBLE = COLOURS[2]
CONFLICT = COLOURS[6]
END_COLOURS = {"upper": COLOURS[1], "lower": COLOURS[0], "conflict": CONFLICT}
"""Of c²⁺(t), c²⁻(t), and limits that conflict."""

LONGEST_LABEL = 44
"""Letters of a label."""

LANE_LETTERS = 32
"""Letters of a row's name beside its lane."""


def shortened(name: str, longest: int = LONGEST_LABEL) -> str:
    """A printable name whose middle is left out where it is too long."""
    return cut(printable(name), longest)
