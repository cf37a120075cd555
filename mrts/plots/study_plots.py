# SPDX-License-Identifier: MIT
"""The durations of a study over one or two of its numbers, which limit binds where, and how durations spread."""

from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.words import first_names
from mrts.limits.rows import MOST_NAMES
from mrts.plots.colours import COLOURS
from mrts.plots.labels import shortened
from mrts.plots.plot import MARGIN, Axis, HeatMap, Item, Line, Panel, Plot, Points, level, rectangles
from mrts.plots.range_plots import neighbours
from mrts.plots.study_map import LIMIT_COLOURS, StudyMap, map_binding, map_remark, study_map
from mrts.plots.study_table import OUTCOMES, StudyTable
from mrts.plots.study_words import SHARES, best_text, managed, managed_texts, outcome_text, variant_text

FASTER = ("#fde725", "#aadc32", "#5ec962", "#28ae80", "#21918c", "#2c728e", "#3b528b", "#472d7b", "#440154")
"""Viridis from its end, bright is fast: ordered in grey and for every colour vision (van der Walt and Smith, 2015)."""

WITHOUT = {
    "unbounded": "#e3f1e9",
    "infeasible": "#bbb",
    "empty": "#a9a9a9",
    "unreachable": "#d9d9d9",
    "invalid": "#8d8d8d",
    "failed": "#6f6f6f",
}
"""Of what has no duration: greys, which no duration has."""

NEARLY_ALL, SEVERAL = 0.95, 3.0
"""Share of the durations, and times the shortest, that colours tell apart; longer ones look like the longest of these:
near a singularity a variant may take a hundred times as long as the best."""

WIDE = 10.0
"""Times the shortest duration from which an axis of durations is logarithmic."""

SAME = 0.01
"""Share of a duration by which an axis of durations that are all alike is wide."""

CELL_LETTERS = 80
"""Of a line of what is told of a cell."""


def study_map_plot(table: StudyTable) -> Plot:
    """The shortest duration and which limit binds, over the two numbers that matter most, or over the only one.

    Args:
        table: The study, with at least one variant and one number.
    """
    drawn = study_map(table)
    title = _title(table, map_remark(table, drawn))
    panels = [_line_panel(table, drawn)] if len(drawn.knobs) == 1 else _map_panels(table, drawn)
    return Plot(name="map" if len(drawn.knobs) > 1 else "line", title=title, rows=[panels])


def _title(table: StudyTable, *remarks: str) -> str:
    return "\n".join([f"{table.name}: {outcome_text(table)}", best_text(table), *filter(None, remarks)])


def _map_panels(table: StudyTable, drawn: StudyMap) -> list[Panel]:
    grid: dict[str, Any] = {"x": drawn.edges[0], "y": drawn.edges[1], "texts": _texts(table, drawn)}
    limits, binding = map_binding(table, drawn)
    greys = [WITHOUT.get(name, "#fff") for name in OUTCOMES]
    without = HeatMap(**grid, z=drawn.outcome, names=list(OUTCOMES), colors=greys)
    duration: list[Item] = []
    if len(table.ranked):
        durations = table.duration[table.ranked]
        most, median = np.quantile(durations, (NEARLY_ALL, 0.5))
        high = min(most, max(median, SEVERAL * durations[0]))
        duration = [HeatMap(**grid, z=drawn.durations(table), colors=FASTER, low=durations[0], high=high,
                            title="shortest duration [s]")]  # fmt: skip
    limit: list[Item] = (
        [HeatMap(**grid, z=binding, names=limits, colors=LIMIT_COLOURS[: len(limits)])] if limits else []
    )
    x, y = (_knob_axis(table, drawn, place) for place in (0, 1))
    best = _best(table, *(table.values[:, knob] for knob in drawn.knobs))
    return [
        Panel(title="Shortest duration", x=x, y=y, items=[*duration, without, *best]),
        Panel(title="What limits it", x=x, y=y, items=[*limit, without, *best]),
    ]


def _knob_axis(table: StudyTable, drawn: StudyMap, place: int) -> Axis:
    edges = drawn.edges[place]
    return Axis(label=table.knobs[drawn.knobs[place]].title, ends=(float(edges[0]), float(edges[-1])))


def _best(table: StudyTable, x: Array, y: Array) -> list[Item]:
    row = table.ranked[:1]
    return [Points(x=x[row], y=y[row], symbol="star", color="#fff", label="the best")] if len(row) else []


def _texts(table: StudyTable, drawn: StudyMap) -> list[list[str]]:
    texts = np.full(drawn.best.shape, "", dtype=object)
    for place, row in np.ndenumerate(drawn.best):
        if row >= 0:
            limits = table.limits(int(row))
            said = [
                variant_text(table, int(row)),
                *([f"limited by {first_names(limits, MOST_NAMES)}"] if limits else []),
            ]
            said += [
                f"{table.knobs[knob].path} = {table.values[row, knob]:.4g} {table.knobs[knob].unit}".rstrip()
                for knob in drawn.knobs
            ]
            texts[place] = "\n".join(shortened(each, CELL_LETTERS) for each in said)
        elif drawn.outcome[place] >= 0:
            texts[place] = ": ".join(list(OUTCOMES.items())[drawn.outcome[place]])
    return list(texts.tolist())


def _line_panel(table: StudyTable, drawn: StudyMap) -> Panel:
    (edges,), durations = drawn.edges, drawn.durations(table)
    limits, binding = map_binding(table, drawn)
    fills = [
        (binding == code, name, _pale(color))
        for code, (name, color) in enumerate(zip(limits, LIMIT_COLOURS, strict=False))
    ]
    fills += [(drawn.outcome == code, name, WITHOUT[name]) for code, name in enumerate(OUTCOMES) if name in WITHOUT]
    log = _spreads_widely(table)
    low, high = (np.nanmin(durations), np.nanmax(durations)) if len(table.ranked) else (0.0, 1.0)
    margin = MARGIN * ((high - low) or high)
    ends = (low / (1 + MARGIN), high * (1 + MARGIN)) if log else (low - margin, high + margin)
    items: list[Item] = [
        rectangles(neighbours(edges, where), *ends, label=name, color=color)
        for where, name, color in fills
        if np.any(where)
    ]
    middles = (edges[1:] + edges[:-1]) / 2
    items.append(Line(x=middles, y=durations, label="shortest duration", unit="s", color="#1b1b1b"))
    items += _best(table, table.values[:, drawn.knobs[0]], table.duration)
    y = Axis(label="duration [s]", log=log, ends=ends)
    return Panel(title="Shortest duration and what limits it", x=_knob_axis(table, drawn, 0), y=y, items=items)


def _spreads_widely(table: StudyTable) -> bool:
    durations = table.duration[table.ranked]
    return len(durations) > 0 and bool(durations[-1] > WIDE * durations[0])


def _pale(color: str) -> str:
    red, green, blue = (255 - (255 - int(color[at : at + 2], 16)) * 3 // 10 for at in (1, 3, 5))
    return f"#{red:02x}{green:02x}{blue:02x}"


def durations_plot(table: StudyTable) -> Plot:
    """Which share of all variants finishes within a duration."""
    title = _title(table, "; ".join(managed_texts(table)) if len(table.ranked) else "")
    if not len(table.ranked):
        return Plot(name="durations", title=title, rows=[[Panel(note="no variant has a duration")]])
    durations = table.duration[table.ranked]
    percent = 100 * np.arange(1, len(durations) + 1) / table.variants
    marks = [(share, end) for share in SHARES if (end := managed(table, share)) is not None]
    share, at = (np.array([mark[part] for mark in marks], dtype=np.float64) for part in (0, 1))
    ends = (float(durations[0]), max(float(durations[-1]), (1 + SAME) * float(durations[0])))
    x = Axis(label="shortest duration [s]", log=_spreads_widely(table), ends=ends, hover="{} s")
    items: list[Item] = [
        Line(x=durations, y=percent, label="finish within this duration", unit="%", steps=True),
        level(float(percent[-1]), x, color=COLOURS[1], dash=1, label="can be played at all"),
        Points(x=at, y=share),
    ]
    panel = Panel(x=x, y=Axis(label="share of all variants [%]", ends=(0.0, 104.0)), items=items)
    return Plot(name="durations", title=title, rows=[[panel]])
