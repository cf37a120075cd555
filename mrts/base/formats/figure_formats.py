# SPDX-License-Identifier: MIT
"""Formats of figures that are written into a folder."""

FIGURE_FORMATS = ("png", "svg", "pdf")
"""Endings of their files; the first is written where nothing else is asked for."""
