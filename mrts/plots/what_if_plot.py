# SPDX-License-Identifier: MIT
"""What changes to a cell would do, as bars: for everything that matters one of each direction."""

import numpy as np

from mrts.plots.colours import ADMISSIBLE, COLOURS
from mrts.plots.plot import Axis, Bars, Item, Panel, Plot, Rule, one_panel
from mrts.scaling.what_if import ChangedAnswer, WhatIf

MOST_BARS = 24
"""Things whose bars are drawn; the rest is counted."""

HALF = 0.19
"""From the middle of a thing's row to the middle of either bar."""


def what_if_plot(found: WhatIf) -> Plot | None:
    """The bars, the largest effect first; None where nothing can be told as a share."""
    effects = changed_shares(found)
    names = list(effects)[:MOST_BARS]
    if not names:
        return None
    items: list[Item] = [Rule(at=0.0, upright=True)]
    for label, up, color, aside in (("up (+)", True, ADMISSIBLE, -HALF), ("down (−)", False, COLOURS[1], HALF)):
        answers = [(row, one) for row, name in enumerate(names) if (one := effects[name].get(up)) is not None]
        if answers:
            end = np.array([100 * (change_share(one) or 0.0) for _, one in answers])
            place = np.array([row + aside for row, _ in answers])
            texts = [str(one) for _, one in answers]
            items.append(Bars(place=place, end=end, thickness=2 * HALF, label=label, color=color, texts=texts))
    of = "the duration" if found.before.c2 is None else "c²⁺"
    panel = Panel(
        title=f"What a change does to {of}: hover to read what binds then",
        x=Axis(label=f"change of {of} [%]"),
        y=Axis(names=names),
        items=items,
    )
    return one_panel("what-if", panel)


def changed_shares(found: WhatIf) -> dict[str, dict[bool, ChangedAnswer]]:
    """Answers that are shares of the one before, up and down, by what is changed: the largest effect first."""
    things: dict[str, dict[bool, ChangedAnswer]] = {}
    for one in found.changes:
        if one.matters and change_share(one) is not None:
            things.setdefault(one.change.what, {})[one.change.step > 0] = one
    return dict(
        sorted(things.items(), key=lambda thing: -max(abs(change_share(one) or 0.0) for one in thing[1].values()))
    )


def change_share(one: ChangedAnswer) -> float | None:
    """By what share c²⁺ changes, or where the speed varies the duration; None where that is no number."""
    if one.before.c2 is not None:
        return one.c2_change
    faster = one.faster
    return None if not faster or not np.isfinite(faster) else 1 / faster - 1
