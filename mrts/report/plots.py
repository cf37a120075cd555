# SPDX-License-Identifier: MIT
"""Plots over time as plotly reads them: positions, velocities, torques, wrenches, rates, power, energy, loads."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.drawing.axis_reach import c2_reach, value_reach
from mrts.drawing.colours import COLOURS
from mrts.drawing.labels import shortened
from mrts.drawing.lanes import gap_boxes
from mrts.drawing.load_envelope import load_envelope
from mrts.report.markup import plot_text
from mrts.samples.sample_ranges import SampleRanges
from mrts.scaling.limit_use import LimitedQuantities, limited_quantities, limited_rate_kinds, limited_rates
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import accumulated_energy

DASHES = ("solid", "dash", "dashdot", "dot", "longdash", "longdashdot", "2px,6px")
"""A second difference between lines, for print without colour."""

MOST_SAMPLES = 500
"""Evenly chosen samples of a line; the extreme ones of every line are kept beside these."""

DIGITS = 6
"""Of the numbers in a plot."""

PLOT_HEIGHT = 340
"""[px]."""

LONG_NAME = 24
"""Letters from which every name takes a line of the legend."""

LEGEND_LINE = 18
"""[px]."""


@dataclass(frozen=True)
class Plot:
    """One plot of the page.

    Attributes:
        name: Its name, one of a kind.
        title: Its heading.
        data: Traces.
        layout: Axes and legend.
        height: [px].
        clock: What its x axis counts, for the cursor: "played" is the time of the trajectory, "given" that of the
            given motion, "way" that along the path; empty where it is none of these.
    """

    name: str
    title: str
    data: list[dict[str, Any]]
    layout: dict[str, Any]
    height: int = PLOT_HEIGHT
    clock: str = ""

    @property
    def place(self) -> str:
        """The identifier of its place in the page."""
        return f"plot-{self.name}"


def numbers(values: Array) -> list[Any]:
    """An array for JSON, to `DIGITS` digits; None stands for what is not finite."""
    flat = [float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None for value in np.ravel(values).tolist()]
    return flat if np.ndim(values) == 1 else np.reshape(np.array(flat, dtype=object), np.shape(values)).tolist()


def shown_samples(count: int, *values: Array) -> NDArray[np.int_]:
    """Samples that are enough to draw lines: all, or an even choice and the extremes of every line.

    Args:
        count: Number of samples N.
        *values: Lines, each Shape (N, lines).
    """
    if count <= MOST_SAMPLES:
        return np.arange(count)
    even = np.linspace(0, count - 1, MOST_SAMPLES).round().astype(int)
    extremes = [np.concatenate([np.argmin(part, axis=0), np.argmax(part, axis=0)]) for part in values]
    return np.unique(np.concatenate([even, *extremes]))


def layout(xtitle: str, ytitle: str, yrange: tuple[float, float]) -> dict[str, Any]:
    """Axes with the legend above, where it hides no curve."""
    axis = {"showline": True, "mirror": True, "linecolor": "#888", "gridcolor": "#e5e5e5", "zeroline": False}
    return {
        "font": {"family": "system-ui, sans-serif", "size": 13, "color": "#1b1b1b"},
        "margin": {"l": 64, "r": 12, "t": 12, "b": 48},
        "paper_bgcolor": "#fff",
        "plot_bgcolor": "#fff",
        "hovermode": "x unified",
        "hoverlabel": {"namelength": -1},
        "legend": {"orientation": "h", "x": 0, "y": 1.01, "yanchor": "bottom", "itemwidth": 42, "traceorder": "normal"},
        "xaxis": axis | {"title": {"text": xtitle}, "unifiedhovertitle": {"text": "t = %{x:.4g} s"}},
        "yaxis": axis | {"title": {"text": ytitle}, "range": numbers(np.array(yrange))},
    }


def line(time: Array, values: Array, name: str, index: int, unit: str | None, **more: Any) -> dict[str, Any]:
    """The line with this number, which chooses its colour and dashes; without a unit it does not answer hovering."""
    turn = index // len(COLOURS)
    return {
        "x": numbers(time),
        "y": numbers(values),
        "name": plot_text(name),
        "mode": "lines",
        "line": {"color": COLOURS[index % len(COLOURS)], "dash": DASHES[(index + turn) % len(DASHES)]} | more,
    } | ({"hoverinfo": "skip"} if unit is None else {"hovertemplate": f"%{{y:.4g}} {unit}"})


def _limited(name: str, title: str, ytitle: str, time: Array, values: Array, names: Sequence[tuple[str, str]],
             limits: Array, **more: Any) -> Plot:  # fmt: skip
    """Lines, each a name and a unit, with their limits as thin lines."""
    traces = []
    samples = shown_samples(len(time), values)
    for index, (label, unit) in enumerate(names):
        own = line(time[samples], values[samples, index], shortened(label), index, unit, **more) | {
            "legendgroup": str(index)
        }
        used = _percent(values[samples, index], *limits[:, samples, index]) if len(limits) else None
        if used is not None:
            own |= {"customdata": used, "hovertemplate": f"%{{y:.4g}} {unit} (%{{customdata}} %)"}
        traces.append(own)
        for limit in limits[:, :, index]:
            if np.any(np.isfinite(limit)):
                at = np.array([0, -1]) if np.all(limit == limit[0]) else samples
                drawn = line(time[at], limit[at], "", index, None, width=0.8)
                traces.append(drawn | {"legendgroup": str(index), "showlegend": False})
    legend = LEGEND_LINE * len(names) if max(len(label) for label, _ in names) >= LONG_NAME else 0
    shape = layout("time [s]", ytitle, value_reach(values, limits))
    return Plot(name, title, traces, shape, PLOT_HEIGHT + legend, "played")


def _percent(values: Array, lower: Array, upper: Array) -> list[int] | None:
    """How much of the limit on their side values use [%]; None where neither side has one that is not 0."""
    limit = np.where(values < 0, lower, upper)
    if not np.all(np.isfinite(limit) & (limit != 0)):
        return None
    return [round(percent) for percent in (100 * values / limit).tolist()]


def position_plots(result: ScalingResult) -> list[Plot]:
    """Joint positions with limits, of each robot a plot for each unit; none without a trajectory."""
    done = result.trajectory
    if done is None:
        return []
    plots = []
    for number, robot in enumerate(result.cell.robots):
        values = done.q[:, result.cell.joint_slices[robot.name]]
        ends = np.stack([robot.position_lower, robot.position_upper])[:, None, :]
        limits = np.broadcast_to(ends, (2, *values.shape))
        for part, unit in enumerate(dict.fromkeys(robot.position_units)):
            own = [index for index, of in enumerate(robot.position_units) if of == unit]
            names = [(robot.joints[index], unit) for index in own]
            name, title = f"position-{number}-{part}", f"{robot.name}: joint positions"
            drawn = _limited(name, title, f"position [{unit}]", done.time, values[:, own], names, limits[:, :, own])
            plots.append(drawn)
    return plots


def velocity_plots(result: ScalingResult) -> list[Plot]:
    """Joint velocities with limits, kept or not, of each robot a plot for each unit; none without a trajectory."""
    done = result.trajectory
    if done is None:
        return []
    plots = []
    for number, robot in enumerate(result.cell.robots):
        values = done.dq[:, result.cell.joint_slices[robot.name]]
        limits = np.broadcast_to(
            np.stack([-robot.velocity_limit, robot.velocity_limit])[:, None, :], (2, *values.shape)
        )
        for part, unit in enumerate(dict.fromkeys(robot.position_units)):
            own = [index for index, of in enumerate(robot.position_units) if of == unit]
            names = [(robot.joints[index], f"{unit}/s") for index in own]
            name, title = f"velocity-{number}-{part}", f"{robot.name}: joint velocities"
            drawn = _limited(name, title, f"velocity [{unit}/s]", done.time, values[:, own], names, limits[:, :, own])
            plots.append(drawn)
    return plots


def torque_plots(result: ScalingResult) -> list[Plot]:
    """Joint torques with limits, a plot for each robot; none without a trajectory."""
    if result.trajectory is None:
        return []
    plots = []
    for number, robot in enumerate(result.cell.robots):
        torques = limited_quantities(result, "torque", robot.name)
        unit = ", ".join(sorted(set(torques.units), reverse=True))
        names = list(zip(torques.names, torques.units, strict=True))
        limits = np.stack([torques.lower, torques.upper])
        title, time = f"{robot.name}: joint torques", result.trajectory.time
        plots.append(_limited(f"torque-{number}", title, f"torque [{unit}]", time, torques.values, names, limits))
    return plots


def wrench_plots(result: ScalingResult) -> list[Plot]:
    """Contact forces and moments with limits, two plots for each robot; none without a trajectory."""
    if result.trajectory is None:
        return []
    plots = []
    for number, robot in enumerate(result.cell.robots):
        wrenches = limited_quantities(result, "wrench", robot.name)
        limits = np.stack([wrenches.lower, wrenches.upper])
        for first, what, unit in (("f", "force", "N"), ("n", "moment", "N m")):
            part = [index for index, name in enumerate(wrenches.names) if name.startswith(first)]
            names = [(wrenches.names[index], unit) for index in part]
            values = wrenches.values[:, part]
            title, time = f"{robot.name}: contact {what} on the object", result.trajectory.time
            name, ytitle = f"{what}-{number}", f"{what} [{unit}]"
            plots.append(_limited(name, title, ytitle, time, values, names, limits[:, :, part]))
    return plots


def rate_plots(result: ScalingResult) -> list[Plot]:
    """How fast torques, wrenches and accelerations change where that is limited, plots for each robot."""
    plots = []
    for kind in limited_rate_kinds(result):
        for number, robot in enumerate(result.cell.robots):
            rates = limited_rates(result, kind, robot.name)
            for part, unit in enumerate(dict.fromkeys(rates.units)):
                drawn = rates.only([of == unit for of in rates.units])
                if np.any(np.isfinite(drawn.upper)):
                    name = f"{kind.replace(' ', '-')}-{number}-{part}"
                    plots.append(_rate_plot(result, drawn, name, f"{robot.name}: {kind}", f"{kind} [{unit}]"))
    return plots


def _rate_plot(result: ScalingResult, drawn: LimitedQuantities, name: str, title: str, ytitle: str) -> Plot:
    """Rates of one unit, each constant from sample to sample."""
    assert result.trajectory is not None  # noqa: S101 (checked by its caller)
    names = list(zip(drawn.names, drawn.units, strict=True))
    limits = np.stack([drawn.lower, drawn.upper])
    return _limited(name, title, ytitle, result.trajectory.time, drawn.values, names, limits, shape="hv")


def power_plots(result: ScalingResult) -> list[Plot]:
    """Joint power, a plot for each robot, and the energy given so far; none without a trajectory."""
    done = result.trajectory
    if done is None:
        return []
    plots, energies = [], []
    for number, robot in enumerate(result.cell.robots):
        values = done.power[:, result.cell.joint_slices[robot.name]]
        names = [(joint, "W") for joint in robot.joints]
        title = f"{robot.name}: power of the joints"
        none = np.empty((0, *values.shape))
        plots.append(_limited(f"power-{number}", title, "power [W]", done.time, values, names, none))
        energies.append(accumulated_energy(done.time, values))
    total = accumulated_energy(done.time, done.power)
    samples = shown_samples(len(done.time), np.stack([*energies, total], axis=1))
    traces = [
        line(done.time[samples], energy[samples], f"{shortened(robot.name)}: {energy[-1]:.4g} J", index, "J")
        for index, (robot, energy) in enumerate(zip(result.cell.robots, energies, strict=True))
    ]
    if len(energies) > 1:
        whole = line(done.time[samples], total[samples], f"all: {done.energy:.4g} J", 0, "J", color="#000", width=3)
        traces.append(whole)
    reach = value_reach(np.stack([*energies, total]), np.empty(0))
    shape = layout("time [s]", "energy [J]", reach)
    return [*plots, Plot("energy", "Energy that the motors have given", traces, shape, clock="played")]


def gap_traces(samples: SampleRanges, high: float) -> list[dict[str, Any]]:
    """What samples do not admit between their least and their largest c², hatched; none where there are no gaps.

    Args:
        samples: Ranges of all samples.
        high: Largest c² of the plot.
    """
    boxes = gap_boxes(samples, high)
    if not boxes:
        return []
    x: list[float | None] = []
    y: list[float | None] = []
    for box in boxes:
        x += [*numbers(np.array([box.start, box.end, box.end, box.start, box.start])), None]
        y += [*numbers(np.array([box.lower, box.lower, box.upper, box.upper, box.lower])), None]
    hatched = {"shape": "/", "bgcolor": "#e4e4e4", "fgcolor": "#9a9a9a", "size": 8}
    look = {"mode": "lines", "line": {"width": 0}, "fill": "toself", "fillpattern": hatched, "hoverinfo": "skip"}
    return [{"x": x, "y": y, "name": "gap: no admissible c²"} | look]


def load_plot(result: ScalingResult) -> Plot | None:
    """c²⁺(t) of the answer, and what the loads that were looked at span; None if none was looked at."""
    study = result.load
    envelope = load_envelope(study) if study is not None else None
    if study is None or envelope is None:
        return None
    time = result.range.samples.time
    worst, best = envelope.order[0], envelope.order[-1]
    low, high = c2_reach(result.range)
    high = max(high, c2_reach(study.ranges[best])[1])
    samples = shown_samples(len(time), np.nan_to_num(result.range.samples.upper)[:, None])
    label = f"between {len(study.points)} loads"
    sides = (np.clip(side[samples], low, 10 * high) for side in (envelope.least, envelope.largest))
    traces = [line(time[samples], side, label, 0, None, width=0) | {"fillcolor": "#ddd"} for side in sides]
    traces[0] |= {"showlegend": False}
    traces[1] |= {"fill": "tonexty"}
    for name, index in (("worst", worst), ("best", best)):
        upper = study.ranges[index].samples.upper[samples]
        traces.append(line(time[samples], upper, f"{name}: {study.points[index]}", 1 + (name == "best"), ""))
    traces.append(line(time[samples], result.range.samples.upper[samples], study.question, 0, "", width=3))
    traces += gap_traces(result.range.samples, high)
    shape = layout("time of the given motion [s]", "largest c² [1]", (low, high))
    return Plot("loads", "c²⁺(t) by load", traces, shape, 400, "given")
