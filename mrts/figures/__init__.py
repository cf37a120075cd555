# SPDX-License-Identifier: MIT
"""Figures of a result; needs the extra 'plot' (matplotlib).

A `draw_…` function draws into axes that you give; a `…_figure` function composes a whole figure.

May import base to output. Start at `result_figures.py`.
"""

from mrts.figures.c2_range import draw_binding_rows, draw_range, range_figure
from mrts.figures.configurations import draw_ranking, ranking_figure
from mrts.figures.loads import draw_load_study, load_figure, study_figure
from mrts.figures.motors import draw_friction, draw_motor_residual, draw_motor_torque, motor_figure, write_motor_figures
from mrts.figures.phase_plane import draw_phase_plane, phase_plane_figure
from mrts.figures.power import draw_energy, draw_power, power_figure
from mrts.figures.rates import draw_force_rates, draw_jerks, draw_moment_rates, draw_torque_rates, rates_figure
from mrts.figures.result_figures import write_result_figures
from mrts.figures.style import write_figure
from mrts.figures.trajectory import draw_contact_forces, draw_contact_moments, draw_torques, trajectory_figure

__all__ = [
    "draw_binding_rows",
    "draw_contact_forces",
    "draw_contact_moments",
    "draw_energy",
    "draw_force_rates",
    "draw_friction",
    "draw_jerks",
    "draw_load_study",
    "draw_moment_rates",
    "draw_motor_residual",
    "draw_motor_torque",
    "draw_phase_plane",
    "draw_power",
    "draw_range",
    "draw_ranking",
    "draw_torque_rates",
    "draw_torques",
    "load_figure",
    "motor_figure",
    "phase_plane_figure",
    "power_figure",
    "range_figure",
    "ranking_figure",
    "rates_figure",
    "study_figure",
    "trajectory_figure",
    "write_figure",
    "write_motor_figures",
    "write_result_figures",
]
