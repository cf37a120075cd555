# SPDX-License-Identifier: MIT
"""A plan that was played in simulation, over what was planned: torques, wrenches and errors along time."""

import numpy as np

from mrts.plots.limit_plots import percent_panel
from mrts.plots.limit_shares import LimitShares
from mrts.plots.plot import Line, Panel, Plot, curves_panel, look
from mrts.plots.trajectory_plots import quantities_panel
from mrts.scaling.limit_use import all_quantities, used_shares
from mrts.simulation.simulate import Simulation

KINDS = {"torque": ("torque", ""), "force": ("wrench", "f"), "moment": ("wrench", "n")}
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
    time = found.played.time
    errors = (
        ("joints", 1e3 * np.max(np.abs(found.joint_error), axis=1), "mrad"),
        ("object", 1e3 * found.object_error, "mm"),
        ("object off its path", 1e3 * found.path_error, "mm"),
    )
    lines = [
        Line(x=time, y=y, label=f"{name} [{unit}]", unit=unit, **look(k)) for k, (name, y, unit) in enumerate(errors)
    ]
    errors_panel = curves_panel("Errors of tracking", "error [mrad, mm]", lines)
    title = f"{found.plan.cell.name}: {found.sentence()}"
    return Plot(name="simulation", title=title, rows=[[closed_loop_panel(found), errors_panel], *rows])


def closed_loop_panel(found: Simulation) -> Panel:
    """How much of its limits the cell used along the time of the plan [%]."""
    names, share = used_shares(found.played)
    moving = found.played.time <= found.plan.duration
    of = LimitShares("in closed loop", tuple(name.short for name in names), share[moving])
    return percent_panel(of, found.played.time[moving])
