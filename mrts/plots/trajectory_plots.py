# SPDX-License-Identifier: MIT
"""What a played motion takes along time, with its limits: torques, wrenches, power, energy."""

from collections.abc import Sequence
from dataclasses import replace

from mrts.base.arrays import Array
from mrts.plots.labels import shortened
from mrts.plots.limit_shares import played
from mrts.plots.plot import Line, Panel, Plot, curves_panel, look, one_panel
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
        panel = quantities_panel(f"{robot.name}: joint torques", "torque", played(result).time, drawn)
        plots.append(one_panel(f"torque-{number}", panel, "played"))
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
            panel = quantities_panel(f"{robot.name}: contact {what} on the object", what, played(result).time, part)
            plots.append(one_panel(f"{what}-{number}", panel, "played"))
    return plots


def power_plots(result: ScalingResult) -> list[Plot]:
    """Power q̇ τ of the joints, negative where a joint brakes, a plot for each robot; then the energy given so far.

    Raises:
        ValueError: If there is no trajectory.
    """
    done, plots, lines = played(result), [], []
    for number, robot in enumerate(result.cell.robots):
        values = done.power[:, result.cell.joint_slices[robot.name]]
        of_joints = [
            Line(x=done.time, y=values[:, k], label=joint, unit="W", **look(k)) for k, joint in enumerate(robot.joints)
        ]
        panel = curves_panel(f"{robot.name}: power of the joints", "power [W]", of_joints)
        plots.append(one_panel(f"power-{number}", panel, "played"))
        energy = accumulated_energy(done.time, values)
        label = f"{shortened(robot.name)}: {energy[-1]:.4g} J"
        lines.append(Line(x=done.time, y=energy, label=label, unit="J", **look(number)))
    if len(lines) > 1:
        total = accumulated_energy(done.time, done.power)
        lines.append(Line(x=done.time, y=total, label=f"all: {done.energy:.4g} J", unit="J", color="#000", width=2.2))
    panel = curves_panel("Energy that the motors have given", "energy [J]", lines)
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


def quantities_panel(title: str, what: str, time: Array, drawn: LimitedQuantities, below: Sequence[Line] = ()) -> Panel:
    """Quantities along time, Shape (N,) [s], with their limits, over other lines."""
    units, solid = dict.fromkeys(drawn.units), {"dash": 0} if below else {}
    lines = [
        Line(
            x=time, y=drawn.values[:, k], label=name if len(units) == 1 else f"{name} [{unit}]", unit=unit,
            lower=drawn.lower[:, k], upper=drawn.upper[:, k], **look(k) | solid,
        )
        for k, (name, unit) in enumerate(zip(drawn.names, drawn.units, strict=True))
    ]  # fmt: skip
    return curves_panel(title, f"{what} [{', '.join(units)}]", lines, below)
