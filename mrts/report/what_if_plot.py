# SPDX-License-Identifier: MIT
"""What changes to a cell would do, as bars: for everything that matters one of each direction."""

from typing import Any

import numpy as np

from mrts.drawing.colours import ADMISSIBLE, COLOURS
from mrts.drawing.labels import shortened_apart
from mrts.report.markup import Html, element, joined, plot_text
from mrts.report.plots import Plot, layout, numbers
from mrts.scaling.what_if import ChangedAnswer, WhatIf

MOST_BARS = 24
"""Things whose bars are drawn; the rest is counted."""

MOST_LISTED = 12
"""Changes that are listed in words: with which it cannot be played, or can where it could not before."""

BAR_HEIGHT = 26
"""Of a thing, with both of its bars [px]."""

TITLE = "What a change does to {}: up (+) and down (-); hover to read what binds then"


def what_if_plots(found: WhatIf) -> list[Plot]:
    """The bars, the largest effect first; none where nothing can be told as a share.

    Args:
        found: What changes would do.
    """
    effects = _effects(found)
    things = list(effects)[:MOST_BARS]
    if not things:
        return []
    traces = [
        _bars("up (+)", ADMISSIBLE, [effects[what].get(True) for what in things]),
        _bars("down (-)", COLOURS[1], [effects[what].get(False) for what in things]),
    ]
    of = "the duration" if found.before.c2 is None else "c²⁺"
    shape = layout(f"change of {of} [%]", "", (len(things) - 0.4, -0.6))
    shape["hovermode"] = "closest"
    shape["barmode"] = "group"
    shape["xaxis"] |= {"zeroline": True, "zerolinecolor": "#888"}
    labels = [plot_text(what) for what in shortened_apart(things)]
    ticks = {"tickvals": list(range(len(things))), "ticktext": labels, "tickfont": {"size": 11}}
    shape["yaxis"] |= ticks | {"automargin": True, "fixedrange": True, "showgrid": False}
    return [Plot("what-if", TITLE.format(of), traces, shape, 120 + BAR_HEIGHT * len(things))]


def what_if_notes(found: WhatIf) -> list[Html]:
    """What the bars do not show, in words.

    Args:
        found: What changes would do.
    """
    first, *_ = found.lines(gains=0, losses=0)
    told = [element("p", f"{first[0].upper()}{first[1:]}.", class_="note")]
    more, _, lost = found.sorted()
    for title, listed in (
        ("With these it can be played:", [one for one in more if one.faster is None]),
        ("With these it cannot be played:", lost),
    ):
        if listed:
            lines = [element("li", str(one)) for one in listed[:MOST_LISTED]]
            rest = len(listed) - MOST_LISTED
            lines += [element("li", f"… and {rest} more")] if rest > 0 else []
            told += [element("p", title), element("ul", joined(lines))]
    hidden = len(_effects(found)) - MOST_BARS
    rest_of_bars = f"{hidden} more do less than these" if hidden > 0 else ""
    sentences = [text for text in (rest_of_bars, found.nothing_else(), found.left_out) if text]
    return [*told, *(element("p", f"{text[0].upper()}{text[1:]}.", class_="note") for text in sentences)]


def _effects(found: WhatIf) -> dict[str, dict[bool, ChangedAnswer]]:
    """Answers that are shares of the one before, up and down, by what is changed: the largest effect first."""
    things: dict[str, dict[bool, ChangedAnswer]] = {}
    for one in found.changes:
        if one.matters and _share(one) is not None:
            things.setdefault(one.change.what, {})[one.change.step > 0] = one
    return dict(sorted(things.items(), key=lambda thing: -max(abs(_share(one) or 0.0) for one in thing[1].values())))


def _share(one: ChangedAnswer) -> float | None:
    """By what share c²⁺ changes, or where the speed varies the duration; None where that is no number."""
    if one.before.c2 is not None:
        return one.c2_change
    faster = one.faster
    return None if not faster or not np.isfinite(faster) else 1 / faster - 1


def _bars(name: str, colour: str, answers: list[ChangedAnswer | None]) -> dict[str, Any]:
    shares = [np.nan if one is None else 100 * (_share(one) or 0.0) for one in answers]
    return {
        "type": "bar",
        "orientation": "h",
        "name": name,
        "x": numbers(np.array(shares)),
        "y": list(range(len(answers))),
        "marker": {"color": colour},
        "text": ["" if one is None else plot_text(str(one)) for one in answers],
        "textposition": "none",
        "hovertemplate": "%{text}<extra></extra>",
    }
