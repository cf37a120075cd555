# SPDX-License-Identifier: MIT
"""Duration of a plan against the reserve that it keeps, and which plans survive their controller."""

from typing import Any

import numpy as np

from mrts.plots.colours import ADMISSIBLE, COLOURS
from mrts.plots.plot import Axis, Item, Line, Panel, Plot, Points, one_panel
from mrts.simulation.reserve import ReserveSearch


def reserve_plot(search: ReserveSearch) -> Plot:
    """Every plan that was tried, with the largest use of a limit when it was played."""
    plans = sorted((each for each in search.tried if each.limit), key=lambda each: each.reserve)
    reserve, duration = (np.array([getattr(each, name) for each in plans]) for name in ("reserve", "duration"))
    items: list[Item] = [Line(x=100 * reserve, y=duration, color="#888", unit=None)]
    looks: list[tuple[bool, dict[str, Any]]] = [
        (True, {"label": "keeps all limits when it is played", "color": ADMISSIBLE}),
        (False, {"label": "passes limits", "color": COLOURS[1], "symbol": "cross"}),
    ]
    for kept, look in looks:
        own = [place for place, each in enumerate(plans) if each.kept == kept]
        if own:
            texts = [f"{100 * plans[place].share:.0f} %" for place in own]
            items.append(Points(x=100 * reserve[own], y=duration[own], texts=texts, **look))
    panel = Panel(
        title="Duration by the reserve, with the largest use of a limit",
        x=Axis(label="reserve [% of every limit]"), y=Axis(label="duration [s]"), items=items,
    )  # fmt: skip
    return one_panel("reserve", panel)
