# SPDX-License-Identifier: MIT
"""Plots of what becomes of a plan: played by a controller, or stopped on its way."""

import numpy as np

from mrts.override.speed_override import Stops
from mrts.plots.limit_shares import LimitShares
from mrts.plots.plot import (
    Axis,
    Line,
    Panel,
    Plot,
    curves_panel,
    look,
    time_axis,
    value_ends,
)
from mrts.plots.trajectory_plots import COMPONENTS, percent_panel, quantities_panel
from mrts.scaling.limit_use import all_quantities, used_shares
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
    return Plot(name="simulation", title=title, rows=[[closed_loop_panel(found), errors_panel], *rows])


def closed_loop_panel(found: Simulation) -> Panel:
    """How much of its limits the cell used along the time of the plan [%]."""
    names, share = used_shares(found.played)
    moving = found.played.time <= found.plan.duration
    of = LimitShares.ranked("in closed loop", [name.short for name in names], share[moving])
    return percent_panel(of, found.played.time[moving])


def stops_plot(stops: Stops) -> Plot:
    """Time and way of the longest stop from every place of a plan."""
    rows = []
    for name, unit, y in (("time", "ms", 1e3 * stops.stop_time), ("distance", "mm", 1e3 * stops.distance)):
        y_axis = Axis(label=f"stop {name} [{unit}]", ends=value_ends(y[np.isfinite(y)], np.empty(0)))
        rows.append([Panel(x=time_axis(stops.time), y=y_axis, items=[Line(x=stops.time, y=y, unit=unit)])])
    return Plot(name="stops", title=f"{stops.cell}: {stops.sentence()}", rows=rows, shared=True, clock="played")
