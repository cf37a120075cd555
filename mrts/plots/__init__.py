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
    from mrts.plots.matplotlib_drawer import matplotlib_figure as matplotlib_figure
    from mrts.plots.matplotlib_drawer import write_plot as write_plot
    from mrts.plots.matplotlib_drawer import write_plots as write_plots
    from mrts.plots.motor_plots import motor_plot as motor_plot
    from mrts.plots.phase_plane import phase_plane_plot as phase_plane_plot
    from mrts.plots.plan_plots import simulation_plot as simulation_plot
    from mrts.plots.range_plots import load_plot as load_plot
    from mrts.plots.range_plots import load_study_plot as load_study_plot
    from mrts.plots.range_plots import range_plot as range_plot
    from mrts.plots.study_plots import durations_plot as durations_plot
    from mrts.plots.study_plots import study_map_plot as study_map_plot
    from mrts.plots.study_table import managed_texts as managed_texts
    from mrts.plots.study_table import read_study_table as read_study_table
    from mrts.plots.trajectory_plots import limits_plot as limits_plot
    from mrts.plots.trajectory_plots import power_plot as power_plot
    from mrts.plots.trajectory_plots import result_plots as result_plots
    from mrts.plots.trajectory_plots import trajectory_plot as trajectory_plot

FIGURE_FORMATS = ("png", "svg", "pdf")
"""Endings of figures that are written into a folder; the first is written where nothing else is asked for."""

__all__, __getattr__, __dir__ = lazy_names(
    __name__,
    {
        "card": "answer_card",
        "matplotlib_drawer": "matplotlib_figure write_plot write_plots",
        "motor_plots": "motor_plot",
        "phase_plane": "phase_plane_plot",
        "plan_plots": "simulation_plot",
        "range_plots": "load_plot load_study_plot range_plot",
        "trajectory_plots": "limits_plot power_plot result_plots trajectory_plot",
        "study_plots": "durations_plot study_map_plot",
        "study_table": "managed_texts read_study_table",
    },
)
