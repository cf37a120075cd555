# SPDX-License-Identifier: MIT
"""The colours of lines, arms and markers, in plots, scenes and films alike."""

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito (2008): distinguishable with every kind of colour vision."""
