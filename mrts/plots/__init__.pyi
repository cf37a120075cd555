# SPDX-License-Identifier: MIT
from mrts.plots.card import answer_card as answer_card
from mrts.plots.matplotlib_drawer import matplotlib_figure as matplotlib_figure
from mrts.plots.matplotlib_drawer import write_plot as write_plot
from mrts.plots.matplotlib_drawer import write_plots as write_plots
from mrts.plots.motor_plots import motor_plot as motor_plot
from mrts.plots.phase_plane import phase_plane_plot as phase_plane_plot
from mrts.plots.plan_plots import reserve_plot as reserve_plot
from mrts.plots.plan_plots import simulation_plot as simulation_plot
from mrts.plots.plan_plots import stops_plot as stops_plot
from mrts.plots.range_plots import load_plot as load_plot
from mrts.plots.range_plots import range_plot as range_plot
from mrts.plots.study_plots import durations_plot as durations_plot
from mrts.plots.study_plots import managed_texts as managed_texts
from mrts.plots.study_plots import numbers_plot as numbers_plot
from mrts.plots.study_plots import read_study_table as read_study_table
from mrts.plots.trajectory_plots import limits_plot as limits_plot
from mrts.plots.trajectory_plots import power_plot as power_plot
from mrts.plots.trajectory_plots import result_plots as result_plots
from mrts.plots.trajectory_plots import trajectory_plot as trajectory_plot

FIGURE_FORMATS: tuple[str, ...]
