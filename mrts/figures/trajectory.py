# SPDX-License-Identifier: MIT
"""Joint torques and contact wrenches over time, with their limits."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mrts.base.arrays import Array
from mrts.drawing.axis_reach import value_reach
from mrts.figures.style import finish, legend_below, line_style, plain, plain_text
from mrts.scaling.limit_use import limited_quantities
from mrts.scaling.result import ScalingResult

SIDE_BY_SIDE = 2
"""More robots than this stand below each other, to fit a page."""


def draw_torques(axes: Axes, result: ScalingResult, robot: str) -> None:
    """Joint torques of one robot, with their limits as thin lines.

    Args:
        axes: Where to draw.
        result: A result with a trajectory.
        robot: Name of the robot.

    Raises:
        ValueError: If there is no trajectory.
    """
    torques = limited_quantities(result, "torque", robot)
    units = set(torques.units)
    names = [
        plain(joint) if len(units) == 1 else f"{plain(joint)} [{unit}]"
        for joint, unit in zip(torques.names, torques.units, strict=True)
    ]
    limits = np.stack([torques.lower, torques.upper])
    _draw(axes, result, torques.values, names, limits, f"joint torque [{', '.join(sorted(units, reverse=True))}]")


def draw_contact_forces(axes: Axes, result: ScalingResult, robot: str) -> None:
    """Force of one robot on the object, base axes, with its limits as thin lines; arguments as in `draw_torques`."""
    _draw_wrench(axes, result, robot, "f", "contact force [N]")


def draw_contact_moments(axes: Axes, result: ScalingResult, robot: str) -> None:
    """Moment of one robot on the object, base axes, with its limits; arguments as in `draw_torques`."""
    _draw_wrench(axes, result, robot, "n", "contact moment [N m]")


def trajectory_figure(result: ScalingResult, title: str) -> Figure:
    """Joint torques and contact wrenches of every robot with their limits (as the paper's figures 4 to 8).

    Args:
        result: A result with a trajectory.
        title: Title of the figure.

    Raises:
        ValueError: If there is no trajectory.
    """
    robots = [robot.name for robot in result.cell.robots]
    count = len(robots)
    if count <= SIDE_BY_SIDE:
        figure = Figure(figsize=(max(6.0, 4.4 * count), 8.6), layout="constrained")
        grid = figure.subplots(3, count, squeeze=False)
    else:
        figure = Figure(figsize=(11.0, 3.1 * count + 0.6), layout="constrained")
        grid = figure.subplots(count, 3, squeeze=False).T
    figure.suptitle(plain_text(f"{title}\n(thin lines: limits)"), fontsize="medium")
    for column, robot in enumerate(robots):
        draws = (draw_torques, draw_contact_forces, draw_contact_moments)
        for axes, draw in zip(grid[:, column], draws, strict=True):
            draw(axes, result, robot)
        grid[0, column].set_title(f"robot '{plain(robot)}'", fontsize="medium")
    for quantity in grid if count <= SIDE_BY_SIDE else ():
        reaches = np.array([axes.get_ylim() for axes in quantity])
        for axes in quantity:
            axes.set_ylim(np.min(reaches[:, 0]), np.max(reaches[:, 1]))
    return figure


def _draw_wrench(axes: Axes, result: ScalingResult, robot: str, first: str, label: str) -> None:
    wrenches = limited_quantities(result, "wrench", robot)
    part = [index for index, name in enumerate(wrenches.names) if name.startswith(first)]
    limits = np.stack([wrenches.lower, wrenches.upper])[:, :, part]
    _draw(axes, result, wrenches.values[:, part], [wrenches.names[index] for index in part], limits, label)


def _draw(axes: Axes, result: ScalingResult, values: Array, names: list[str], limits: Array, label: str) -> None:
    assert result.trajectory is not None  # noqa: S101 (checked by every caller)
    for index, name in enumerate(names):
        style = line_style(index)
        axes.plot(result.trajectory.time, values[:, index], label=name, **style)
        for limit in limits[:, :, index]:
            if not np.all(limit == limit[0]):
                axes.plot(result.trajectory.time, limit, linewidth=0.7, alpha=0.8, **style)
            elif np.isfinite(limit[0]):
                axes.axhline(limit[0], linewidth=0.7, alpha=0.8, **style)
    axes.set_ylim(value_reach(values, limits))
    finish(axes, "time [s]", label)
    legend_below(axes)
