# SPDX-License-Identifier: MIT
"""Mechanical power of the joints and the energy that the motors give."""

from matplotlib.axes import Axes

from mrts.figures.style import SIDE_BY_SIDE, NotebookFigure, finish, legend_below, line_style, plain, plain_text
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import accumulated_energy


def draw_power(axes: Axes, result: ScalingResult, robot: str) -> None:
    """Power q̇ τ of every joint of one robot; negative where the joint brakes.

    Args:
        axes: Where to draw.
        result: A result with a trajectory.
        robot: Name of the robot.

    Raises:
        ValueError: If there is no trajectory.
    """
    done = result.trajectory
    if done is None:
        raise ValueError("there is no trajectory to draw")
    arm = next(arm for arm in result.cell.robots if arm.name == robot)
    values = done.power[:, result.cell.joint_slices[robot]]
    for index, joint in enumerate(arm.joints):
        axes.plot(done.time, values[:, index], label=plain(joint), **line_style(index))
    finish(axes, "time [s]", "joint power [W]")
    legend_below(axes)


def draw_energy(axes: Axes, result: ScalingResult) -> None:
    """Energy that the motors have given since the start, of every robot and of all.

    Args:
        axes: Where to draw.
        result: A result with a trajectory.

    Raises:
        ValueError: If there is no trajectory.
    """
    done = result.trajectory
    if done is None:
        raise ValueError("there is no trajectory to draw")
    for index, (robot, joints) in enumerate(result.cell.joint_slices.items()):
        energy = accumulated_energy(done.time, done.power[:, joints])
        axes.plot(done.time, energy, label=f"{plain(robot)}: {energy[-1]:.4g} J", **line_style(index))
    if len(result.cell.robots) > 1:
        total = accumulated_energy(done.time, done.power)
        axes.plot(done.time, total, color="black", linewidth=2.2, label=f"all: {done.energy:.4g} J")
    finish(axes, "time [s]", "energy given [J]")
    legend_below(axes, columns=len(result.cell.robots) + 1)


def power_figure(result: ScalingResult, title: str) -> NotebookFigure:
    """Power of every joint, robot by robot, above the energy given.

    Args:
        result: A result with a trajectory.
        title: Title of the figure.

    Raises:
        ValueError: If there is no trajectory.
    """
    robots = [robot.name for robot in result.cell.robots]
    columns = min(len(robots), SIDE_BY_SIDE)
    rows = -(-len(robots) // columns)
    figure = NotebookFigure(figsize=(max(6.0, 4.4 * columns), 3.1 * (rows + 1)), layout="constrained")
    figure.suptitle(plain_text(title), fontsize="medium")
    grid = figure.add_gridspec(rows + 1, columns)
    drawn = []
    for index, robot in enumerate(robots):
        axes = figure.add_subplot(grid[index // columns, index % columns])
        draw_power(axes, result, robot)
        axes.set_title(f"robot '{plain(robot)}'", fontsize="medium")
        drawn.append(axes)
    low, high = zip(*(axes.get_ylim() for axes in drawn), strict=True)
    for axes in drawn:
        axes.set_ylim(min(low), max(high))
    draw_energy(figure.add_subplot(grid[rows, :]), result)
    return figure
