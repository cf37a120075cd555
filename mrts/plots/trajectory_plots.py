# SPDX-License-Identifier: MIT
"""What a played motion takes along time, with its limits: torques, wrenches, power, energy."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mrts.base.arrays import Array
from mrts.plots.labels import shortened
from mrts.plots.limit_shares import played
from mrts.plots.plot import Axis, Line, Panel, Plot, look, one_panel, time_axis, value_ends
from mrts.scaling.limit_use import LimitedQuantities, limited_quantities
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import accumulated_energy

SIDE_BY_SIDE = 2
"""More robots than this stand below each other, to fit a page."""


def torque_plots(result: ScalingResult) -> list[Plot]:
    """Joint torques, a plot for each robot.

    Raises:
        ValueError: If there is no trajectory.
    """
    plots = []
    for number, robot in enumerate(result.cell.robots):
        drawn = limited_quantities(result, "torque", robot.name)
        plots.append(_quantities(result, f"torque-{number}", f"{robot.name}: joint torques", "torque", drawn))
    return plots


def wrench_plots(result: ScalingResult) -> list[Plot]:
    """Contact forces and moments on the object in base axes, two plots for each robot.

    Raises:
        ValueError: If there is no trajectory.
    """
    plots = []
    for number, robot in enumerate(result.cell.robots):
        wrenches = limited_quantities(result, "wrench", robot.name)
        for first, what in (("f", "force"), ("n", "moment")):
            part = wrenches.only([name.startswith(first) for name in wrenches.names])
            title = f"{robot.name}: contact {what} on the object"
            plots.append(_quantities(result, f"{what}-{number}", title, what, part))
    return plots


def power_plots(result: ScalingResult) -> list[Plot]:
    """Power q̇ τ of the joints, negative where a joint brakes, a plot for each robot; then the energy given so far.

    Raises:
        ValueError: If there is no trajectory.
    """
    done, plots, lines = played(result), [], []
    for number, robot in enumerate(result.cell.robots):
        values = done.power[:, result.cell.joint_slices[robot.name]]
        names = [(joint, "W") for joint in robot.joints]
        title = f"{robot.name}: power of the joints"
        plots.append(_limited(result, f"power-{number}", title, "power", values, names, np.empty((0, *values.shape))))
        energy = accumulated_energy(done.time, values)
        label = f"{shortened(robot.name)}: {energy[-1]:.4g} J"
        lines.append(Line(x=done.time, y=energy, label=label, unit="J", **look(number)))
    if len(lines) > 1:
        total = accumulated_energy(done.time, done.power)
        lines.append(Line(x=done.time, y=total, label=f"all: {done.energy:.4g} J", unit="J", color="#000", width=2.2))
    ends = value_ends(np.stack([line.y for line in lines]), np.empty(0))
    panel = Panel(
        title="Energy that the motors have given",
        x=time_axis(done.time),
        y=Axis(label="energy [J]", ends=ends),
        items=lines,
    )
    return [*plots, one_panel("energy", panel, "played")]


def trajectory_plot(result: ScalingResult, title: str = "") -> Plot:
    """Joint torques and contact wrenches of every robot with their limits (as the paper's figures 4 to 8).

    Args:
        result: A result with a trajectory.
        title: Above it; the cell and the duration without any.

    Raises:
        ValueError: If there is no trajectory.
    """
    torques, wrenches = torque_plots(result), wrench_plots(result)
    whole = _by_robot("torques_and_wrenches", title, result, [torques, wrenches[::2], wrenches[1::2]])
    return replace(whole, title=f"{whole.title} (thin lines: limits)")


def power_plot(result: ScalingResult, title: str = "") -> Plot:
    """Power of every joint, robot by robot, above the energy given; arguments as of `trajectory_plot`.

    Raises:
        ValueError: If there is no trajectory.
    """
    *powers, energy = power_plots(result)
    whole = _by_robot("power_and_energy", title, result, [powers])
    return Plot(name=whole.name, title=whole.title, rows=[*whole.rows, *energy.rows])


def _by_robot(name: str, title: str, result: ScalingResult, plots: Sequence[Sequence[Plot]]) -> Plot:
    """Quantities of every robot: a column a robot, or a row where there are many."""
    rows = [[plot.rows[0][0] for plot in of_kind] for of_kind in plots]
    if len(result.cell.robots) > SIDE_BY_SIDE:
        rows = [list(row) for row in zip(*rows, strict=True)]
    title = title or f"{result.cell.name}: {played(result).duration:.4g} s"
    return Plot(name=name, title=title, rows=rows)


def _quantities(result: ScalingResult, name: str, title: str, label: str, drawn: LimitedQuantities) -> Plot:
    names, limits = list(zip(drawn.names, drawn.units, strict=True)), np.stack([drawn.lower, drawn.upper])
    return _limited(result, name, title, label, drawn.values, names, limits)


def _limited(result: ScalingResult, name: str, title: str, label: str, values: Array, names: Sequence[tuple[str, str]],
             limits: Array) -> Plot:  # fmt: skip
    done, units = played(result), dict.fromkeys(unit for _, unit in names)
    lines = []
    for index, (of_line, unit) in enumerate(names):
        lower, upper = limits[:, :, index] if len(limits) else (None, None)
        shown = of_line if len(units) == 1 else f"{of_line} [{unit}]"
        lines.append(
            Line(x=done.time, y=values[:, index], label=shown, unit=unit, lower=lower, upper=upper, **look(index))
        )
    y = Axis(label=f"{label} [{', '.join(units)}]", ends=value_ends(values, limits))
    return one_panel(name, Panel(title=title, x=time_axis(done.time), y=y, items=lines), "played")
