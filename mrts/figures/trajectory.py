# SPDX-License-Identifier: MIT
"""Joint torques and contact wrenches over time, with their limits."""

import numpy as np
from matplotlib.axes import Axes

from mrts.drawing.axis_reach import value_reach
from mrts.figures.style import NotebookFigure, finish, legend_below, line_style, plain, robot_figure
from mrts.scaling.limit_use import LimitedQuantities, limited_quantities
from mrts.scaling.result import ScalingResult


def draw_torques(axes: Axes, result: ScalingResult, robot: str) -> None:
    """Joint torques of one robot, with their limits as thin lines.

    Args:
        axes: Where to draw.
        result: A result with a trajectory.
        robot: Name of the robot.

    Raises:
        ValueError: If there is no trajectory.
    """
    draw_limited(axes, result, limited_quantities(result, "torque", robot), "joint torque")


def draw_contact_forces(axes: Axes, result: ScalingResult, robot: str) -> None:
    """Force of one robot on the object, base axes, with its limits as thin lines; arguments as in `draw_torques`."""
    _draw_wrench(axes, result, robot, "f", "contact force")


def draw_contact_moments(axes: Axes, result: ScalingResult, robot: str) -> None:
    """Moment of one robot on the object, base axes, with its limits; arguments as in `draw_torques`."""
    _draw_wrench(axes, result, robot, "n", "contact moment")


def trajectory_figure(result: ScalingResult, title: str) -> NotebookFigure:
    """Joint torques and contact wrenches of every robot with their limits (as the paper's figures 4 to 8).

    Args:
        result: A result with a trajectory.
        title: Title of the figure.

    Raises:
        ValueError: If there is no trajectory.
    """
    return robot_figure(result, title, (draw_torques, draw_contact_forces, draw_contact_moments))


def draw_limited(
    axes: Axes, result: ScalingResult, drawn: LimitedQuantities, label: str, *, steps: bool = False
) -> None:
    """Quantities over time, with their limits as thin lines.

    Args:
        axes: Where to draw.
        result: A result with a trajectory.
        drawn: What of it.
        label: What they are; their units are told beside it, or beside each name where they differ.
        steps: Whether each is constant from sample to sample.
    """
    assert result.trajectory is not None  # noqa: S101 (what is drawn is of it)
    time, units = result.trajectory.time, set(drawn.units)
    for index, (name, unit) in enumerate(zip(drawn.names, drawn.units, strict=True)):
        style = line_style(index)
        shown = plain(name) if len(units) == 1 else f"{plain(name)} [{unit}]"
        course = "steps-post" if steps else "default"
        axes.plot(time, drawn.values[:, index], label=shown, drawstyle=course, **style)
        for limit in (drawn.lower[:, index], drawn.upper[:, index]):
            if not np.all(limit == limit[0]):
                axes.plot(time, limit, linewidth=0.7, alpha=0.8, **style)
            elif np.isfinite(limit[0]):
                axes.axhline(limit[0], linewidth=0.7, alpha=0.8, **style)
    axes.set_ylim(value_reach(drawn.values, np.stack([drawn.lower, drawn.upper])))
    finish(axes, "time [s]", f"{label} [{', '.join(sorted(units, reverse=True))}]")
    legend_below(axes)


def _draw_wrench(axes: Axes, result: ScalingResult, robot: str, first: str, label: str) -> None:
    wrenches = limited_quantities(result, "wrench", robot)
    draw_limited(axes, result, wrenches.only([name.startswith(first) for name in wrenches.names]), label)
