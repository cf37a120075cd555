# SPDX-License-Identifier: MIT
"""What is plotted of a result, a study or an identification, as data, and what draws it.

matplotlib (the extra 'plot') draws files, plotly the pages of `mrts.report`. May import base to layout.
Start at `plot.py`.

Names are imported on first use: the command line takes its answer from here without studies or timings.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mrts.plots.card import answer_card as answer_card
    from mrts.plots.configuration_plot import ranking_plot as ranking_plot
    from mrts.plots.figure_files import matplotlib_figure as matplotlib_figure
    from mrts.plots.figure_files import write_motor_plots as write_motor_plots
    from mrts.plots.figure_files import write_plot as write_plot
    from mrts.plots.figure_files import write_result_plots as write_result_plots
    from mrts.plots.figure_files import write_study_plots as write_study_plots
    from mrts.plots.limit_plots import limits_plot as limits_plot
    from mrts.plots.motor_plots import motor_plot as motor_plot
    from mrts.plots.phase_plane import phase_plane_plot as phase_plane_plot
    from mrts.plots.range_plots import load_plot as load_plot
    from mrts.plots.range_plots import load_study_plot as load_study_plot
    from mrts.plots.range_plots import range_plot as range_plot
    from mrts.plots.study_plots import durations_plot as durations_plot
    from mrts.plots.study_plots import study_map_plot as study_map_plot
    from mrts.plots.study_table import read_study_table as read_study_table
    from mrts.plots.study_words import managed_texts as managed_texts
    from mrts.plots.study_words import next_steps as next_steps
    from mrts.plots.trajectory_plots import power_plot as power_plot
    from mrts.plots.trajectory_plots import trajectory_plot as trajectory_plot

_HOMES = {
    "answer_card": "card",
    "durations_plot": "study_plots",
    "limits_plot": "limit_plots",
    "load_plot": "range_plots",
    "load_study_plot": "range_plots",
    "managed_texts": "study_words",
    "matplotlib_figure": "figure_files",
    "motor_plot": "motor_plots",
    "next_steps": "study_words",
    "phase_plane_plot": "phase_plane",
    "power_plot": "trajectory_plots",
    "range_plot": "range_plots",
    "ranking_plot": "configuration_plot",
    "read_study_table": "study_table",
    "study_map_plot": "study_plots",
    "trajectory_plot": "trajectory_plots",
    "write_motor_plots": "figure_files",
    "write_plot": "figure_files",
    "write_result_plots": "figure_files",
    "write_study_plots": "figure_files",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'mrts.plots' has no attribute '{name}'")
    return getattr(import_module(f"mrts.plots.{_HOMES[name]}"), name)
