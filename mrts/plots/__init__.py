# SPDX-License-Identifier: MIT
"""What is plotted of a result, a study or an identification, as data, and what draws it.

matplotlib (the extra 'plot') draws files, plotly the pages of `mrts.output`. May import base to scene.
Start at `plot.py`.

Names are imported on first use: the command line takes its answer from here without studies or timings.
"""

from mrts.base.lazy_names import lazy_names

FIGURE_FORMATS = ("png", "svg", "pdf")
"""Endings of figures that are written into a folder; the first is written where nothing else is asked for."""

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
