# SPDX-License-Identifier: MIT
"""Figures of a result; needs the extra 'plot' (matplotlib)."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mrts.atomic_file import write_atomically
from mrts.result import ScalingResult
from mrts.rigid_transform import Array

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito (2008): distinguishable with every kind of colour vision."""

DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)), (0, (7, 3)))
"""A second difference between lines, for print without colour."""

MANY_LINES = 3
"""Above this the legend takes two columns."""

DPI = 150


def trajectory_figure(result: ScalingResult, title: str) -> Figure:
    """Joint torques with their limits, and contact wrenches, one column a robot (as the paper's figures 4 to 8).

    Args:
        result: A result with a trajectory.
        title: Title of the figure.

    Raises:
        ValueError: If there is no trajectory.
    """
    if result.trajectory is None:
        raise ValueError("there is no trajectory to draw")
    robots = result.cell.robots
    figure = Figure(figsize=(4.2 * max(2, len(robots)), 6.4), layout="constrained")
    figure.suptitle(f"{title}\n(thin lines: limits)", fontsize="medium")
    grid = figure.subplots(2, len(robots), sharex=True, sharey="row", squeeze=False)
    time = result.trajectory.time
    for column, robot in enumerate(robots):
        torque, wrench = grid[0, column], grid[1, column]
        torque.set_title(f"robot '{robot.name}'")
        limits = np.stack([robot.torque_lower, robot.torque_upper])
        _lines(torque, time, result.torque[robot.name], robot.joints, limits)
        bounds = np.stack([robot.wrench_lower, robot.wrench_upper])
        units = [f"{name} [N]" if name.startswith("f") else f"{name} [N m]" for name in result.cell.wrench_components]
        _lines(wrench, time, result.wrench[robot.name], tuple(units), bounds)
        wrench.set_xlabel("time [s]")
    unit = "N m" if all(unit == "N m" for robot in robots for unit in robot.torque_units) else "N m, N"
    grid[0, 0].set_ylabel(f"joint torque [{unit}]")
    grid[1, 0].set_ylabel("contact wrench on the object [N, N m]")
    return figure


def range_figure(result: ScalingResult) -> Figure:
    """c²⁻(t) and c²⁺(t) with the range over the motion; infeasible samples are marked."""
    samples = result.range.samples
    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.subplots()
    upper = np.where(np.isfinite(samples.upper), samples.upper, np.nan)
    lower = np.where(np.isfinite(samples.lower), samples.lower, np.nan)
    axes.plot(samples.time, upper, color=COLOURS[1], label="c²⁺(t)")
    axes.plot(samples.time, lower, color=COLOURS[0], linestyle="--", label="c²⁻(t)")
    low, high = result.range.lower, result.range.upper
    if result.status.admits_motion and low and high and np.isfinite(high.c2):
        axes.axhspan(low.c2, high.c2, color=COLOURS[2], alpha=0.15, label=f"[{low.c2:.4g}, {high.c2:.4g}]")
    for conflict in samples.conflicts:
        axes.axvline(conflict.time, color=COLOURS[6], alpha=0.3, linewidth=1)
    finite = upper[np.isfinite(upper)]
    if finite.size:
        # one sample near rest can be thousands of times above the range that matters
        top = 1.05 * min(float(np.max(finite)), 10 * float(np.min(finite)) + 1e-12)
        axes.set_ylim(-0.02 * top, top)
    axes.margins(x=0)
    axes.set_xlabel("time of the given motion [s]")
    axes.set_ylabel("c² [1]")
    axes.legend()
    axes.grid(visible=True, alpha=0.3)
    return figure


def load_figure(results: Mapping[str, ScalingResult]) -> Figure:
    """c²⁺(t) for several questions of one load, and how fast each lets the whole motion be played.

    Args:
        results: By label, such as "nominal", "guaranteed", "possible".
    """
    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.subplots()
    lowest = np.inf
    for index, (label, result) in enumerate(results.items()):
        samples, end = result.range.samples, result.range.upper
        upper = np.where(np.isfinite(samples.upper), samples.upper, np.nan)
        colour, dash = COLOURS[index % len(COLOURS)], DASHES[index % len(DASHES)]
        reach = f" (c²⁺ = {end.c2:.4g})" if end is not None and np.isfinite(end.c2) else ""
        axes.plot(samples.time, upper, color=colour, linestyle=dash, label=f"{label}{reach}")
        if end is not None and end.time is not None:
            axes.plot(end.time, end.c2, "o", color=colour, clip_on=False)
            lowest = min(lowest, max(end.c2, 0.0))
    if np.isfinite(lowest):
        axes.set_ylim(0, 10 * lowest + 1e-12)
    axes.margins(x=0)
    axes.set_xlabel("time of the given motion [s]")
    axes.set_ylabel("largest c² at the sample [1]")
    axes.legend()
    axes.grid(visible=True, alpha=0.3)
    return figure


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure, whole or not at all; the file name's ending chooses the format.

    Raises:
        InputError: If it cannot be written.
    """
    write_atomically(path, lambda temporary: figure.savefig(temporary, dpi=DPI))


def _lines(axes: Axes, time: Array, values: Array, names: tuple[str, ...], limits: Array) -> None:
    for index, name in enumerate(names):
        colour = COLOURS[index % len(COLOURS)]
        axes.plot(time, values[:, index], color=colour, linestyle=DASHES[index % len(DASHES)], label=name)
        for limit in limits[:, index]:
            if np.isfinite(limit):
                axes.axhline(limit, color=colour, linewidth=0.8, alpha=0.5)
    axes.legend(loc="best", fontsize="x-small", ncols=2 if len(names) > MANY_LINES else 1, framealpha=0.7)
    axes.grid(visible=True, alpha=0.3)
    axes.margins(x=0)
