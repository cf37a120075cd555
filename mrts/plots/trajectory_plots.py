# SPDX-License-Identifier: MIT
"""Plots of a result along time: how much of each limit is used; torques, wrenches, power, energy."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from mrts.base.arrays import Array
from mrts.base.colours import COLOURS
from mrts.base.errors import check_type
from mrts.limits.rows import RATES
from mrts.plots.card import answer_card
from mrts.plots.phase_plane import phase_plane_plot
from mrts.plots.plot import Axis, Item, Line, Panel, Plot, curves_panel, level, look, shortened, time_axis
from mrts.plots.range_plots import range_plot
from mrts.program.rate_limits import RateLimits
from mrts.scaling.scale import ScalingResult
from mrts.scaling.scaled_trajectory import LimitedQuantities, ScaledTrajectory
from mrts.timing.result import RetimingResult

TITLES = {
    "torque": "Joint torques",
    "wrench": "Contact wrenches",
    "velocity": "Velocities",
    "acceleration": "Accelerations",
    "contact": "Contacts: friction, tilting, normal force",
    "motor speed": "Motor speeds",
    "torque-speed": "Torques at speed",
    "torque rate": "Rates of joint torques",
    "wrench rate": "Rates of contact wrenches",
    "jerk": "Joint jerks",
}
"""Of kinds of limits in the order of their pictures; others come after them by their own name."""

SIDE_BY_SIDE = 2
"""More robots than this stand below each other, to fit a page."""

NAMED = 5
"""Limits of a kind with a colour and a name: those of which most is used."""

HIGHEST = 160.0
"""Per cent of limits up to which a picture reaches at most."""

QUANTITIES = {
    "torque": {"N m": "joint torque", "N": "joint force"},
    "wrench": {"N": "contact force", "N m": "contact moment"},
}
"""What is drawn of a robot, by kind and unit: an axis each."""


@dataclass(frozen=True)
class LimitShares:
    """The limits of one kind.

    Attributes:
        kind: As in `mrts.limits.rows.RowName`.
        labels: A line each, the one that comes nearest to its limit first: `left/elbow`.
        share: Of its limit that each line uses, 1 at the limit, never below 0, Shape (N, lines).
    """

    kind: str
    labels: tuple[str, ...]
    share: Array

    @classmethod
    def ranked(cls, kind: str, labels: Sequence[str], share: Array) -> "LimitShares":
        """Lines in any order."""
        order = np.argsort(-np.max(share, axis=0), kind="stable")
        return cls(kind, tuple(labels[line] for line in order), share[:, order])

    @property
    def title(self) -> str:
        """What they are, for people."""
        return TITLES.get(self.kind, self.kind.capitalize())


def limit_shares(done: ScaledTrajectory, rates: RateLimits | None = None) -> list[LimitShares]:
    """The shares of all limits that there are, kind by kind; the rows of one hand that fail alike make one line.

    Velocities also where their limits are reported only, and rates by the limits that are kept, or else the cell's.
    """
    found = [done.quantities.limited, done.limited_rates(rates)]
    rows = [name for of in found for name in of.rows]
    share = np.maximum(np.hstack([of.share for of in found]), 0.0)
    kinds = []
    for kind in dict.fromkeys([*TITLES, *(name.kind for name in rows)]):
        lines: dict[str, list[int]] = {}
        for row, name in enumerate(rows):
            if name.kind == kind:
                label = name.failure or (f"{name.robot}/{name.element}" if name.robot else str(name))
                lines.setdefault(label, []).append(row)
        if lines:
            largest = [np.max(share[:, members], axis=1, initial=0.0) for members in lines.values()]
            kinds.append(LimitShares.ranked(kind, [*lines], np.column_stack(largest)))
    return kinds


def result_plots(result: ScalingResult | RetimingResult) -> list[Plot]:
    """All plots of a result; without a profile, of the best constant factor.

    A retimed motion has no range of c² to draw: its own answer is c² = 1.
    """
    check_type("result", result, ScalingResult, RetimingResult)
    timing = result if isinstance(result, RetimingResult) else None
    shown = result if isinstance(result, ScalingResult) else result.retimed or result.constant
    title = f"{shown.cell.name}: {answer_card(result).outcome}"
    plots = [] if shown.origin else [range_plot(shown)]
    if timing is not None and timing.pieces:
        plots.append(phase_plane_plot(timing))
    if shown.trajectory is not None:
        plots += [trajectory_plot(shown, title), limits_plot(shown, title), power_plot(shown, title)]
    return plots


def trajectory_plot(result: ScalingResult, title: str = "") -> Plot:
    """Joint torques and contact wrenches of every robot with their limits (as the paper's figures 4 to 8).

    Forces and moments act on the object, in base axes.

    Args:
        result: A result with a trajectory.
        title: Above it; the cell and the duration without any.

    Raises:
        ValueError: If there is no trajectory.
    """
    time, found, of_robots = result.done.time, result.done.quantities, []
    for robot in result.cell.robots:
        parts = (part for kind in QUANTITIES for part in by_unit(found.of(kind, robot.name)))
        of_robots.append([quantities_panel(time, part) for part in parts])
    title = f"{title or _title(result)} (thin lines: limits)"
    return Plot(name="torques_and_wrenches", title=title, rows=by_robot(of_robots), clock="played")


def limits_plot(result: ScalingResult, title: str = "") -> Plot:
    """How much of its limits the motion uses along time [%], a panel for each kind; arguments as `trajectory_plot`."""
    time = result.done.time
    panels = [percent_panel(of, time) for of in limit_shares(result.done, result.options.rates)]
    rows = [panels[at : at + 2] for at in range(0, len(panels), 2)]
    return Plot(name="limits", title=title or _title(result), rows=rows, clock="played")


def power_plot(result: ScalingResult, title: str = "") -> Plot:
    """Power q̇ τ of every joint, negative where it brakes, above the energy given; arguments as `trajectory_plot`."""
    done, powers, lines = result.done, [], []
    for number, robot in enumerate(result.cell.robots):
        values = done.power[:, result.cell.joint_slices[robot.name]]
        of_joints = [
            Line(x=done.time, y=values[:, k], label=joint, unit="W", **look(k)) for k, joint in enumerate(robot.joints)
        ]
        powers.append([curves_panel(f"{robot.name}: power of the joints", "power [W]", of_joints)])
        energy = _accumulated(done.time, values)
        label = f"{shortened(robot.name)}: {energy[-1]:.4g} J"
        lines.append(Line(x=done.time, y=energy, label=label, unit="J", **look(number)))
    if len(lines) > 1:
        total = _accumulated(done.time, done.power)
        lines.append(Line(x=done.time, y=total, label=f"all: {done.energy:.4g} J", unit="J", color="#000", width=2.2))
    rows = [*by_robot(powers), [curves_panel("Energy that the motors have given", "energy [J]", lines)]]
    return Plot(name="power_and_energy", title=title or _title(result), rows=rows, clock="played")


def _accumulated(time: Array, power: Array) -> Array:
    """Energy that some joints give from the start to every sample, by the trapezoidal rule, Shape (N,) [J]."""
    total = np.sum(power, axis=1)
    return np.append(0.0, np.cumsum(np.diff(time) * (total[1:] + total[:-1]) / 2))


def _title(result: ScalingResult) -> str:
    return f"{result.cell.name}: {result.done.duration:.4g} s"


def by_robot(panels: Sequence[Sequence[Panel]]) -> list[list[Panel]]:
    """Panels of every robot: a column a robot, or a row where there are many."""
    if len(panels) > SIDE_BY_SIDE:
        return [list(row) for row in panels]
    return [[panel for panel in row if panel is not None] for row in zip_longest(*panels)]


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


def by_unit(found: LimitedQuantities) -> list[LimitedQuantities]:
    """Those of each unit."""
    units = [name.unit for name in found.rows]
    return [found.only([one == unit for one in units]) for unit in dict.fromkeys(units)]


def quantities_panel(time: Array, drawn: LimitedQuantities, below: Sequence[Line] = ()) -> Panel:
    """Quantities of one robot and unit along time, Shape (N,) [s], with their limits, over other lines."""
    first, solid = drawn.rows[0], {"dash": 0} if below else {}
    what = QUANTITIES[first.kind][first.unit]
    lines = [
        Line(
            x=time, y=drawn.values[:, k], label=name.element, unit=first.unit,
            lower=drawn.lower[:, k], upper=drawn.upper[:, k], **look(k) | solid,
        )
        for k, name in enumerate(drawn.rows)
    ]  # fmt: skip
    return curves_panel(f"{first.robot}: {what}", f"{what} [{first.unit}]", lines, below)
