# SPDX-License-Identifier: MIT
"""What is plotted of a result, a study or an identification, as data, and what draws it.

matplotlib (the extra 'plot') draws files, plotly the pages of `mrts.report`. May import base to layout.
Start at `plot.py`.
"""

from mrts.plots.card import answer_card
from mrts.plots.configuration_plot import ranking_plot
from mrts.plots.figure_files import (
    matplotlib_figure,
    write_motor_plots,
    write_plot,
    write_result_plots,
    write_study_plots,
)
from mrts.plots.limit_plots import limits_plot
from mrts.plots.motor_plots import motor_plot
from mrts.plots.phase_plane import phase_plane_plot
from mrts.plots.range_plots import load_plot, load_study_plot, range_plot
from mrts.plots.study_plots import durations_plot, study_map_plot
from mrts.plots.study_table import read_study_table
from mrts.plots.study_words import managed_texts, next_steps
from mrts.plots.trajectory_plots import power_plot, trajectory_plot

__all__ = [
    "answer_card",
    "durations_plot",
    "limits_plot",
    "load_plot",
    "load_study_plot",
    "managed_texts",
    "matplotlib_figure",
    "motor_plot",
    "next_steps",
    "phase_plane_plot",
    "power_plot",
    "range_plot",
    "ranking_plot",
    "read_study_table",
    "study_map_plot",
    "trajectory_plot",
    "write_motor_plots",
    "write_plot",
    "write_result_plots",
    "write_study_plots",
]
