# SPDX-License-Identifier: MIT
"""A plan that was played in simulation, over what was planned: torques, wrenches and errors along time."""

import numpy as np

from mrts.plots.limit_plots import percent_panel
from mrts.plots.limit_shares import LimitShares
from mrts.plots.plot import Axis, Item, Line, Panel, Plot, look, time_axis, value_ends
from mrts.scaling.limit_use import LimitedQuantities, all_quantities, used_shares
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
            row.append(_panel(found, f"{robot.name}: {what}", what, planned.only(own), used.only(own)))
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
    ends = value_ends(np.stack([line.y for line in lines]), np.empty(0))
    errors_panel = Panel(
        title="Errors of tracking", x=time_axis(time), y=Axis(label="error [mrad, mm]", ends=ends), items=lines
    )
    title = f"{found.plan.cell.name}: {found.sentence()}"
    return Plot(name="simulation", title=title, rows=[[closed_loop_panel(found), errors_panel], *rows])


def closed_loop_panel(found: Simulation) -> Panel:
    """How much of its limits the cell used along the time of the plan [%]."""
    names, share = used_shares(found.played)
    moving = found.played.time <= found.plan.duration
    of = LimitShares("in closed loop", tuple(name.short for name in names), share[moving])
    return percent_panel(of, found.played.time[moving])


def _panel(found: Simulation, title: str, what: str, planned: LimitedQuantities, used: LimitedQuantities) -> Panel:
    items: list[Item] = []
    for index, name in enumerate(used.names):
        looks = look(index)
        thin = looks | {"dash": 1, "width": 0.8}
        items.append(Line(x=found.plan.time, y=planned.values[:, index], unit=None, **thin))
        items.append(
            Line(
                x=found.played.time, y=used.values[:, index], label=name, unit=used.units[index],
                lower=used.lower[:, index], upper=used.upper[:, index], color=looks["color"],
            )
        )  # fmt: skip
    units = ", ".join(dict.fromkeys(used.units))
    y = Axis(label=f"{what} [{units}]", ends=value_ends(used.values, np.stack([used.lower, used.upper])))
    return Panel(title=title, x=time_axis(found.played.time), y=y, items=items)
