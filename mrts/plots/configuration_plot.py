# SPDX-License-Identifier: MIT
"""Configurations of the arms, ranked by how fast they let the motion be played."""

import numpy as np

from mrts.plots.colours import CONFLICT, END_COLOURS
from mrts.plots.plot import Axis, Bars, Item, Panel, Plot, Points, one_panel
from mrts.studies.configurations import ConfigurationStudy, outcome

MOST_BARS = 64
"""Configurations that are drawn, the best first."""


def ranking_plot(study: ConfigurationStudy, title: str) -> Plot:
    """c²⁺ of every configuration as a bar, the best above, with what limits it; infeasible ones are crosses."""
    shown = study.ranked[:MOST_BARS]
    more = f" (the best {len(shown)} of {len(study.ranked)})" if len(shown) < len(study.ranked) else ""
    title = f"{title}{more}\nbranch of each arm; at the right: when and by what c²⁺ is limited"
    if not shown:
        note = "no configuration reaches the end of the motion"
        return one_panel("configurations", Panel(title=title, note=note))
    c2 = np.array([found.c2_upper for found in shown])
    longest = float(np.max(c2[np.isfinite(c2)], initial=0.0)) or 1.0
    rows, color = np.arange(len(shown), dtype=np.float64), END_COLOURS["upper"]
    items: list[Item] = []
    if np.any(finite := np.isfinite(c2)):
        written = [f"{value:.4g}" for value in c2[finite].tolist()]
        items.append(Bars(place=rows[finite], end=c2[finite], color=color, written=written))
    if np.any(free := c2 == np.inf):
        end = np.full(np.count_nonzero(free), 1.1 * longest)
        items.append(Bars(place=rows[free], end=end, color="#fff", hatch="///"))
    if np.any(none := c2 == -np.inf):
        items.append(Points(x=0 * rows[none], y=rows[none], symbol="cross", color=CONFLICT))
    names = [", ".join(f"{branch.robot} {branch.number}" for branch in found.branches) for found in shown]
    y = Axis(names=names, beside=[outcome(found) for found in shown])
    panel = Panel(title=title, x=Axis(label="c²⁺ [1]", ends=(0.0, 1.15 * longest)), y=y, items=items)
    return one_panel("configurations", panel)
