# SPDX-License-Identifier: MIT
"""What stands in the viewer's panel along time, and leaves it as files: plots, comparison, pictures and films.

May import base to film, and the rest of the viewer but what puts all of it together. Start at `time_plots.py`.
"""
