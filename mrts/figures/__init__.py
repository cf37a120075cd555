# SPDX-License-Identifier: MIT
"""Figures of a result or a study; needs the extra 'plot' (matplotlib).

A `draw_…` function draws into axes that you give; a `…_figure` function composes a whole figure.

May import base to output. Start at `result_figures.py`.
"""

from mrts.drawing.study_lines import parallel_axes
from mrts.drawing.study_map import study_map
from mrts.drawing.study_table import read_study_table
from mrts.drawing.study_words import managed_texts, next_steps
from mrts.figures.c2_range import draw_binding_rows, draw_range, range_figure
from mrts.figures.configurations import draw_ranking, ranking_figure
from mrts.figures.loads import draw_load_study, load_figure, study_figure
from mrts.figures.motors import draw_friction, draw_motor_residual, draw_motor_torque, motor_figure, write_motor_figures
from mrts.figures.phase_plane import draw_phase_plane, phase_plane_figure
from mrts.figures.power import draw_energy, draw_power, power_figure
from mrts.figures.rates import draw_force_rates, draw_jerks, draw_moment_rates, draw_torque_rates, rates_figure
from mrts.figures.result_figures import write_result_figures
from mrts.figures.study_figures import (
    best_variants_figure,
    draw_durations,
    draw_managed,
    durations_figure,
    write_study_figures,
)
from mrts.figures.study_lines import draw_parallel_coordinates, parallel_coordinates_figure
from mrts.figures.study_maps import draw_limit_map, draw_study_line, draw_study_map, study_map_figure
from mrts.figures.style import write_figure
from mrts.figures.trajectory import draw_contact_forces, draw_contact_moments, draw_torques, trajectory_figure

__all__ = [
    "best_variants_figure",
    "draw_binding_rows",
    "draw_contact_forces",
    "draw_contact_moments",
    "draw_durations",
    "draw_energy",
    "draw_force_rates",
    "draw_friction",
    "draw_jerks",
    "draw_limit_map",
    "draw_load_study",
    "draw_managed",
    "draw_moment_rates",
    "draw_motor_residual",
    "draw_motor_torque",
    "draw_parallel_coordinates",
    "draw_phase_plane",
    "draw_power",
    "draw_range",
    "draw_ranking",
    "draw_study_line",
    "draw_study_map",
    "draw_torque_rates",
    "draw_torques",
    "durations_figure",
    "load_figure",
    "managed_texts",
    "motor_figure",
    "next_steps",
    "parallel_axes",
    "parallel_coordinates_figure",
    "phase_plane_figure",
    "power_figure",
    "range_figure",
    "ranking_figure",
    "rates_figure",
    "read_study_table",
    "study_figure",
    "study_map",
    "study_map_figure",
    "trajectory_figure",
    "write_figure",
    "write_motor_figures",
    "write_result_figures",
    "write_study_figures",
]
