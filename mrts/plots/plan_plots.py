# SPDX-License-Identifier: MIT
"""Plots of what becomes of a plan that a controller plays."""

import numpy as np

from mrts.plots.plot import (
    Line,
    Panel,
    Plot,
    curves_panel,
    look,
)
from mrts.plots.trajectory_plots import COMPONENTS, LimitShares, percent_panel, quantities_panel
from mrts.scaling.limit_use import all_quantities, limited_rows
from mrts.simulation.simulate import Simulation

KINDS = {"torque": ("torque", ""), **{what: ("wrench", first) for first, what in COMPONENTS.items()}}
"""What is drawn: the kind of its rows, and how their elements begin."""


def simulation_plot(found: Simulation) -> Plot:
    """What was used of all limits, and errors; torques and wrenches, thin and dashed as planned, a column a robot."""
    sides = all_quantities(found.plan), all_quantities(found.played)
    rows = []
    for what, (kind, first) in KINDS.items():
        row = []
        for robot in found.plan.cell.robots:
            planned, used = (side.of(kind, robot.name) for side in sides)
            own = [name.startswith(first) for name in used.names]
            thin = [
                Line(x=found.plan.time, y=y, unit=None, color=look(k)["color"], dash=1, width=0.8)
                for k, y in enumerate(planned.only(own).values.T)
            ]
            row.append(quantities_panel(f"{robot.name}: {what}", what, found.played.time, used.only(own), thin))
        rows.append(row)
    errors = {
        "joints [mrad]": 1e3 * np.max(np.abs(found.joint_error), axis=1),
        "object [mm]": 1e3 * found.object_error,
        "object off its path [mm]": 1e3 * found.path_error,
    }
    lines = [Line(x=found.played.time, y=y, label=name, **look(k)) for k, (name, y) in enumerate(errors.items())]
    errors_panel = curves_panel("Errors of tracking", "error [mrad, mm]", lines)
    title = f"{found.plan.cell.name}: {found.sentence()}"
    return Plot(name="simulation", title=title, rows=[[_closed_loop_panel(found), errors_panel], *rows])


def _closed_loop_panel(found: Simulation) -> Panel:
    """How much of its limits the cell used along the time of the plan [%]."""
    used = limited_rows(found.played)
    moving = found.played.time <= found.plan.duration
    of = LimitShares.ranked("in closed loop", [name.short for name in used.rows], np.maximum(used.share[moving], 0.0))
    return percent_panel(of, found.played.time[moving])
