# SPDX-License-Identifier: MIT
"""Plots of a result along time: how much of each limit is used; torques, wrenches, power, energy."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mrts.base.argument_types import check_type
from mrts.base.arrays import Array
from mrts.limits.rows import RATES
from mrts.plots.card import answer_card
from mrts.plots.labels import shortened
from mrts.plots.limit_shares import LimitShares, all_shares, played, shares_by_kind
from mrts.plots.phase_plane import phase_plane_plot
from mrts.plots.plot import (
    ADMISSIBLE,
    COLOURS,
    Axis,
    Item,
    Line,
    Panel,
    Plot,
    Points,
    curves_panel,
    level,
    look,
    one_panel,
    time_axis,
)
from mrts.plots.range_plots import load_study_plot, range_plot
from mrts.scaling.limit_use import LimitedQuantities, limited_quantities
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import accumulated_energy
from mrts.simulation.reserve import ReserveSearch
from mrts.timing.result import RetimingResult

SIDE_BY_SIDE = 2
"""More robots than this stand below each other, to fit a page."""

NAMED = 5
"""Limits of a kind with a colour and a name: those of which most is used."""

HIGHEST = 160.0
"""Per cent of limits up to which a picture reaches at most."""

COMPONENTS = {"f": "force", "n": "moment"}
"""How components of a wrench begin, and what they are."""


def result_plots(result: ScalingResult | RetimingResult, search: ReserveSearch | None = None) -> list[Plot]:
    """All plots of a result, and of the search that found its reserve; without a profile, of the best constant factor.

    A retimed motion has no range of c² to draw: its own answer is c² = 1.
    """
    check_type("result", result, ScalingResult, RetimingResult)
    timing = result if isinstance(result, RetimingResult) else None
    shown = result if isinstance(result, ScalingResult) else result.retimed or result.constant
    title = f"{shown.cell.name}: {answer_card(result).outcome}"
    plots = [] if shown.origin else [range_plot(shown)]
    if timing is not None and timing.pieces:
        plots.append(phase_plane_plot(timing))
    if shown.load is not None and shown.load.ranges:
        plots.append(load_study_plot(shown))
    if shown.trajectory is not None:
        plots += [trajectory_plot(shown, title), limits_plot(shown, title), power_plot(shown, title)]
    return plots if search is None else [*plots, reserve_plot(search)]


def trajectory_plot(result: ScalingResult, title: str = "") -> Plot:
    """Joint torques and contact wrenches of every robot with their limits (as the paper's figures 4 to 8).

    Forces and moments act on the object, in base axes.

    Args:
        result: A result with a trajectory.
        title: Above it; the cell and the duration without any.

    Raises:
        ValueError: If there is no trajectory.
    """
    time, of_robots = played(result).time, []
    for robot in result.cell.robots:
        torques, wrenches = (limited_quantities(result, kind, robot.name) for kind in ("torque", "wrench"))
        parts = {what: wrenches.only([name[0] == first for name in wrenches.names])
                 for first, what in COMPONENTS.items()}  # fmt: skip
        of_robots.append(
            [
                quantities_panel(f"{robot.name}: joint torques", "torque", time, torques),
                *(quantities_panel(f"{robot.name}: contact {what}", what, time, part) for what, part in parts.items()),
            ]
        )
    title = f"{title or _title(result)} (thin lines: limits)"
    return Plot(name="torques_and_wrenches", title=title, rows=_by_robot(of_robots), clock="played")


def limits_plot(result: ScalingResult, title: str = "") -> Plot:
    """How much of its limits the motion uses along time [%], a panel for each kind; arguments as `trajectory_plot`."""
    time = played(result).time
    panels = [percent_panel(of, time) for of in shares_by_kind(*all_shares(result))]
    rows = [panels[at : at + 2] for at in range(0, len(panels), 2)]
    return Plot(name="limits", title=title or _title(result), rows=rows, clock="played")


def power_plot(result: ScalingResult, title: str = "") -> Plot:
    """Power q̇ τ of every joint, negative where it brakes, above the energy given; arguments as `trajectory_plot`."""
    done, powers, lines = played(result), [], []
    for number, robot in enumerate(result.cell.robots):
        values = done.power[:, result.cell.joint_slices[robot.name]]
        of_joints = [
            Line(x=done.time, y=values[:, k], label=joint, unit="W", **look(k)) for k, joint in enumerate(robot.joints)
        ]
        powers.append([curves_panel(f"{robot.name}: power of the joints", "power [W]", of_joints)])
        energy = accumulated_energy(done.time, values)
        label = f"{shortened(robot.name)}: {energy[-1]:.4g} J"
        lines.append(Line(x=done.time, y=energy, label=label, unit="J", **look(number)))
    if len(lines) > 1:
        total = accumulated_energy(done.time, done.power)
        lines.append(Line(x=done.time, y=total, label=f"all: {done.energy:.4g} J", unit="J", color="#000", width=2.2))
    rows = [*_by_robot(powers), [curves_panel("Energy that the motors have given", "energy [J]", lines)]]
    return Plot(name="power_and_energy", title=title or _title(result), rows=rows, clock="played")


def _title(result: ScalingResult) -> str:
    return f"{result.cell.name}: {played(result).duration:.4g} s"


def _by_robot(panels: Sequence[Sequence[Panel]]) -> list[list[Panel]]:
    """Panels of every robot: a column a robot, or a row where there are many."""
    if len(panels) > SIDE_BY_SIDE:
        return [list(row) for row in panels]
    return [list(row) for row in zip(*panels, strict=True)]


def percent_panel(of: LimitShares, time: Array) -> Panel:
    """The use of limits along time, Shape (N,) [s], in per cent: the nearest with a name, above the others."""
    percent, steps = 100 * of.share, of.kind in RATES
    items: list[Item] = [Line(x=time, y=y, color="#bbb", width=0.8, unit=None, steps=steps) for y in percent.T[NAMED:]]
    for place, (name, y) in enumerate(zip(of.labels[:NAMED], percent.T, strict=False)):
        label, width = f"{name}: {np.max(y):.3g} %", 1.2 if place else 2.8
        items.append(Line(x=time, y=y, label=label, unit="%", steps=steps, width=width, **look(place)))
    x = time_axis(time)
    items.append(level(100.0, x, color=COLOURS[1], dash=1))
    top = 1.06 * min(max(100.0, float(np.max(percent))), HIGHEST)
    return Panel(title=of.title, x=x, y=Axis(label="of the limit [%]", ends=(0.0, top)), items=items)


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


def reserve_plot(search: ReserveSearch) -> Plot:
    """Duration against the reserve of every plan that was tried, with the largest use of a limit when it was played."""
    plans = sorted((each for each in search.tried if each.limit), key=lambda each: each.reserve)
    reserve, duration = (np.array([getattr(each, name) for each in plans]) for name in ("reserve", "duration"))
    items: list[Item] = [Line(x=100 * reserve, y=duration, color="#888", unit=None)]
    looks: list[tuple[bool, dict[str, Any]]] = [
        (True, {"label": "keeps all limits when it is played", "color": ADMISSIBLE}),
        (False, {"label": "passes limits", "color": COLOURS[1], "symbol": "cross"}),
    ]
    for kept, look_of in looks:
        own = [place for place, each in enumerate(plans) if each.kept == kept]
        if own:
            texts = [f"{100 * plans[place].share:.0f} %" for place in own]
            items.append(Points(x=100 * reserve[own], y=duration[own], texts=texts, **look_of))
    panel = Panel(
        title="Duration by the reserve, with the largest use of a limit",
        x=Axis(label="reserve [% of every limit]"), y=Axis(label="duration [s]"), items=items,
    )  # fmt: skip
    return one_panel("reserve", panel)
