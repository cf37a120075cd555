# SPDX-License-Identifier: MIT
"""What is plotted of a result, a study or an identification, as data, and what draws it.

matplotlib (the extra 'plot') draws files, plotly the pages of `mrts.report`. May import base to studies.
Start at `plot.py`.

Names are imported on first use: the command line takes its answer from here without studies or timings.
"""

from typing import TYPE_CHECKING

from mrts.base.lazy_names import lazy_names

if TYPE_CHECKING:
    from mrts.plots.card import answer_card as answer_card
    from mrts.plots.figure_files import write_motor_plots as write_motor_plots
    from mrts.plots.figure_files import write_result_plots as write_result_plots
    from mrts.plots.figure_files import write_simulation_plot as write_simulation_plot
    from mrts.plots.figure_files import write_study_plots as write_study_plots
    from mrts.plots.limit_plots import limits_plot as limits_plot
    from mrts.plots.matplotlib_drawer import matplotlib_figure as matplotlib_figure
    from mrts.plots.matplotlib_drawer import write_plot as write_plot
    from mrts.plots.motor_plots import motor_plot as motor_plot
    from mrts.plots.phase_plane import phase_plane_plot as phase_plane_plot
    from mrts.plots.range_plots import load_plot as load_plot
    from mrts.plots.range_plots import load_study_plot as load_study_plot
    from mrts.plots.range_plots import range_plot as range_plot
    from mrts.plots.study_plots import durations_plot as durations_plot
    from mrts.plots.study_plots import study_map_plot as study_map_plot
    from mrts.plots.study_table import read_study_table as read_study_table
    from mrts.plots.study_words import managed_texts as managed_texts
    from mrts.plots.trajectory_plots import power_plot as power_plot
    from mrts.plots.trajectory_plots import trajectory_plot as trajectory_plot

FIGURE_FORMATS = ("png", "svg", "pdf")
"""Endings of figures that are written into a folder; the first is written where nothing else is asked for."""

__all__, __getattr__, __dir__ = lazy_names(
    __name__,
    {
        "card": "answer_card",
        "figure_files": "write_motor_plots write_result_plots write_simulation_plot write_study_plots",
        "limit_plots": "limits_plot",
        "matplotlib_drawer": "matplotlib_figure write_plot",
        "motor_plots": "motor_plot",
        "phase_plane": "phase_plane_plot",
        "range_plots": "load_plot load_study_plot range_plot",
        "study_plots": "durations_plot study_map_plot",
        "study_table": "read_study_table",
        "study_words": "managed_texts",
        "trajectory_plots": "power_plot trajectory_plot",
    },
)
