# SPDX-License-Identifier: MIT
"""How much of its limits a played motion uses along time, drawn: a panel for each kind."""

import numpy as np

from mrts.base.arrays import Array
from mrts.limits.rows import RATES
from mrts.plots.colours import COLOURS
from mrts.plots.limit_shares import LimitShares, all_shares, played, shares_by_kind
from mrts.plots.plot import Axis, Item, Line, Panel, Plot, level, look, time_axis
from mrts.scaling.result import ScalingResult

NAMED = 5
"""Limits of a kind with a colour and a name: those of which most is used."""

HIGHEST = 160.0
"""Per cent of limits up to which a picture reaches at most."""


def limits_plot(result: ScalingResult, title: str) -> Plot:
    """How much of its limits the motion uses along time [%], a panel for each kind.

    Raises:
        ValueError: If there is no trajectory.
    """
    time = played(result).time
    panels = [percent_panel(of, time) for of in shares_by_kind(*all_shares(result))]
    return Plot(
        name="limits", title=title, rows=[panels[at : at + 2] for at in range(0, len(panels), 2)], clock="played"
    )


def percent_panel(of: LimitShares, time: Array) -> Panel:
    """The use of limits along time, Shape (N,) [s], in per cent: the nearest with a name, above the others."""
    percent, steps = 100 * of.share, of.kind in RATES
    items: list[Item] = [
        Line(x=time, y=percent[:, line], color="#bbb", width=0.8, unit=None, steps=steps) for line in of.ranked[NAMED:]
    ]
    for place, line in enumerate(of.ranked[:NAMED]):
        label = f"{of.labels[line]}: {np.max(percent[:, line]):.3g} %"
        items.append(Line(x=time, y=percent[:, line], label=label, unit="%", steps=steps, width=1.2 if place else 2.8,
                          **look(place)))  # fmt: skip
    x = time_axis(time)
    items.append(level(100.0, x, color=COLOURS[1], dash=1))
    top = 1.06 * min(max(100.0, float(np.max(percent))), HIGHEST)
    return Panel(title=of.title, x=x, y=Axis(label="of the limit [%]", ends=(0.0, top)), items=items)
