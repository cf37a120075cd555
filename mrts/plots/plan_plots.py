# SPDX-License-Identifier: MIT
"""Plots of what becomes of a plan: played by a controller, with a reserve, or stopped on its way."""

from typing import Any

import numpy as np

from mrts.base.colours import COLOURS
from mrts.control.simulate import ReserveSearch, Simulation
from mrts.control.speed_override import Stops
from mrts.plots.plot import (
    ADMISSIBLE,
    Axis,
    Item,
    Line,
    Panel,
    Plot,
    Points,
    curves_panel,
    look,
    one_panel,
    time_axis,
    value_ends,
)
from mrts.plots.trajectory_plots import QUANTITIES, LimitShares, by_robot, by_unit, percent_panel, quantities_panel


def simulation_plot(found: Simulation) -> Plot:
    """What was used of all limits, and errors; torques and wrenches, thin and dashed as planned."""
    sides = found.plan.quantities, found.played.quantities
    of_robots = []
    for robot in found.plan.cell.robots:
        panels = []
        for kind in QUANTITIES:
            for planned, used in zip(*(by_unit(side.of(kind, robot.name)) for side in sides), strict=True):
                thin = [
                    Line(x=found.plan.time, y=y, unit=None, color=look(k)["color"], dash=1, width=0.8)
                    for k, y in enumerate(planned.values.T)
                ]
                panels.append(quantities_panel(found.played.time, used, thin))
        of_robots.append(panels)
    errors = {
        "joints [mrad]": 1e3 * np.max(np.abs(found.joint_error), axis=1),
        "object [mm]": 1e3 * found.object_error,
        "object off its path [mm]": 1e3 * found.path_error,
    }
    lines = [Line(x=found.played.time, y=y, label=name, **look(k)) for k, (name, y) in enumerate(errors.items())]
    errors_panel = curves_panel("Errors of tracking", "error [mrad, mm]", lines)
    title = f"{found.plan.cell.name}: {found.sentence()}"
    return Plot(name="simulation", title=title, rows=[[closed_loop_panel(found), errors_panel], *by_robot(of_robots)])


def closed_loop_panel(found: Simulation) -> Panel:
    """How much of its limits the cell used along the time of the plan [%]."""
    used = found.played.quantities.limited
    moving = found.played.time <= found.plan.duration
    of = LimitShares.ranked("in closed loop", [name.short for name in used.rows], np.maximum(used.share[moving], 0.0))
    return percent_panel(of, found.played.time[moving])


def stops_plot(stops: Stops) -> Plot:
    """Time and distance of the longest stop from every place of a plan."""
    rows = []
    for name, unit, y in (("time", "ms", 1e3 * stops.stop_time), ("distance", "mm", 1e3 * stops.distance)):
        y_axis = Axis(label=f"stop {name} [{unit}]", ends=value_ends(y[np.isfinite(y)], np.empty(0)))
        rows.append([Panel(x=time_axis(stops.time), y=y_axis, items=[Line(x=stops.time, y=y, unit=unit)])])
    return Plot(name="stops", title=f"{stops.cell}: {stops.sentence()}", rows=rows, shared=True, clock="played")


def reserve_plot(search: ReserveSearch) -> Plot:
    """Duration against the reserve of every plan that was tried, with the largest use of a limit when it was played."""
    plans = [each for each in search.tried if each.largest]
    reserve, duration = (np.array([getattr(each, name) for each in plans]) for name in ("reserve", "duration"))
    items: list[Item] = [Line(x=100 * reserve, y=duration, color="#888", unit=None)]
    looks: dict[bool, dict[str, Any]] = {
        True: {"label": "keeps all limits when it is played", "color": ADMISSIBLE},
        False: {"label": "passes limits", "color": COLOURS[1], "symbol": "cross"},
    }
    for kept, look_of in looks.items():
        own = [place for place, each in enumerate(plans) if each.kept == kept]
        if own:
            texts = [f"{100 * (plans[place].largest or 0.0):.1f} %" for place in own]
            items.append(Points(x=100 * reserve[own], y=duration[own], texts=texts, **look_of))
    panel = Panel(
        title="Duration by the reserve, with the largest use of a limit",
        x=Axis(label="reserve [% of every limit]"), y=Axis(label="duration [s]"), items=items,
    )  # fmt: skip
    return one_panel("reserve", panel)
