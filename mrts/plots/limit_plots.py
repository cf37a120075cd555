# SPDX-License-Identifier: MIT
"""How much of its limits a played motion uses along time, drawn: a panel for each kind, or a map of all."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.limits.rows import RATES
from mrts.plots.colours import COLOURS
from mrts.plots.limit_shares import AT_LIMIT, LimitingRows, LimitShares, all_shares, played, shares_by_kind
from mrts.plots.plot import Axis, HeatMap, Item, Line, Panel, Plot, Rule, look, one_panel, time_axis
from mrts.scaling.result import ScalingResult

NAMED = 5
"""Limits of a kind with a colour and a name: those of which most is used."""

HIGHEST = 160.0
"""Per cent of limits up to which a picture reaches at most."""

MOST_ROWS = 24
"""Limits on the map, those of which most is used."""

MOST_TIMES = 200
"""Columns of the map; each has the largest use of the samples in it."""

MAP_COLORS = ("#fff", "#0072B2")
"""From 0 to 100 %; a dark page has dark for the first and light for the second."""


def limits_plot(result: ScalingResult, title: str, without: Sequence[str] = ()) -> Plot:
    """How much of its limits the motion uses along time [%], a panel for each kind.

    Raises:
        ValueError: If there is no trajectory.
    """
    kinds = shares_by_kind(*all_shares(result))
    panels = [_percent_panel(of, result) for of in kinds if of.kind not in without]
    return Plot(
        name="limits", title=title, rows=[panels[at : at + 2] for at in range(0, len(panels), 2)], clock="played"
    )


def _percent_panel(of: LimitShares, result: ScalingResult) -> Panel:
    time, percent = played(result).time, 100 * of.share
    steps = of.kind in RATES
    items: list[Item] = [
        Line(x=time, y=percent[:, line], color="#bbb", width=0.8, unit=None, steps=steps) for line in of.ranked[NAMED:]
    ]
    for place, line in enumerate(of.ranked[:NAMED]):
        label = f"{of.labels[line]}: {np.max(percent[:, line]):.3g} %"
        items.append(Line(x=time, y=percent[:, line], label=label, unit="%", steps=steps, width=1.2 if place else 2.8,
                          **look(place)))  # fmt: skip
    items.append(Rule(at=100.0, color=COLOURS[1], dash=1))
    top = 1.06 * min(max(100.0, float(np.max(percent))), HIGHEST)
    return Panel(title=of.title, x=time_axis(time), y=Axis(label="of the limit [%]", ends=(0.0, top)), items=items)


def limit_map(result: ScalingResult, limiting: LimitingRows) -> Plot:
    """Per cents of the limits of which most is used, all along the motion; those that set the speed come first.

    Raises:
        ValueError: If there is no trajectory.
    """
    time, shares = played(result).time, limiting.shares
    shown = dict(list(limiting.ranked.items())[:MOST_ROWS])

    def largest(values: Array) -> tuple[Array, Array]:
        """Edges of the columns, and of each row and column the largest value."""
        edges, columns = _columns(time, np.stack([np.max(values[:, rows], axis=1) for rows in shown.values()], 1))
        return edges, columns.T

    edges, percent = largest(100 * shares)
    codes = np.where(shares >= 1 - AT_LIMIT, np.where(limiting.forced, 1.0, 0.0), -1.0)
    grid: dict[str, Any] = {"x": edges, "y": np.arange(len(shown) + 1, dtype=np.float64) - 0.5}
    reached = HeatMap(
        **grid,
        z=largest(codes)[1],
        names=("at the limit through the distribution", "at the limit where the speed is set"),
        colors=(COLOURS[4], COLOURS[1]),
    )
    used = HeatMap(**grid, z=percent, colors=MAP_COLORS, low=0.0, high=100.0, title="of the limit [%]", unit="%")
    panel = Panel(
        title="Per cent of limits along the motion",
        x=time_axis(time),
        y=Axis(names=list(shown), strong=[limiting.names[rows[0]] in limiting.setting for rows in shown.values()]),
        items=[used, reached],
    )
    return one_panel("limit-map", panel, "played")


def _columns(time: Array, shares: Array) -> tuple[Array, Array]:
    """Edges of columns of about one width, and the largest share of the samples that touch each."""
    count = min(len(time) - 1, MOST_TIMES)
    starts = np.unique(np.searchsorted(time, np.linspace(time[0], time[-1], count + 1)[:-1], side="right") - 1)
    steps = np.maximum(shares[:-1], shares[1:])  # each from one sample to the next
    return np.append(time[starts], time[-1]), np.maximum.reduceat(steps, starts)
