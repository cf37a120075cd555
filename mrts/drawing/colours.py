# SPDX-License-Identifier: MIT
"""The colours of figures and reports."""

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito (2008): distinguishable with every kind of colour vision."""

ADMISSIBLE = COLOURS[2]
CONFLICT = COLOURS[6]
END_COLOURS = {"upper": COLOURS[1], "lower": COLOURS[0], "conflict": CONFLICT}
"""Of c²⁺(t), c²⁻(t), and limits that conflict."""
