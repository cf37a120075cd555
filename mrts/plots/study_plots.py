# SPDX-License-Identifier: MIT
"""The durations of a study over one or two of its numbers, which limit binds where, and how durations spread."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.words import first_names
from mrts.limits.rows import MOST_NAMES
from mrts.plots.colours import COLOURS
from mrts.plots.labels import shortened
from mrts.plots.plot import MARGIN, Axis, Bars, HeatMap, Item, Line, Panel, Plot, Points, Rule
from mrts.plots.plotly_drawer import FONT, numbers, plot_text
from mrts.plots.range_plots import neighbours, upright_areas
from mrts.plots.study_map import (
    LIMIT_COLOURS,
    StudyMap,
    best_values,
    duration_ends,
    map_binding,
    map_remark,
    spreads_widely,
    study_map,
    weights,
)
from mrts.plots.study_table import OUTCOMES, Index, StudyTable
from mrts.plots.study_words import (
    SHARES,
    best_part,
    best_text,
    managed,
    managed_texts,
    outcome_text,
    span_texts,
    variant_text,
)

FASTER = ("#fde725", "#aadc32", "#5ec962", "#28ae80", "#21918c", "#2c728e", "#3b528b", "#472d7b", "#440154")
"""Viridis from its end, bright is fast: ordered in grey and for every colour vision (van der Walt and Smith, 2015)."""

WITHOUT = {
    "unbounded": ("#e3f1e9", "||||"),
    "infeasible": ("#bbb", "////"),
    "empty": ("#a9a9a9", "\\\\\\\\"),
    "unreachable": ("#d9d9d9", "xxxx"),
    "invalid": ("#8d8d8d", "...."),
    "failed": ("#6f6f6f", "****"),
}
"""Grey and hatch of what has no duration: greys, which no duration has."""

FEWEST_BINS, MOST_BINS = 4, 60
"""Of a histogram: about the square root of the number of values."""

SAME = 0.01
"""Durations that differ by less than this share of them have one picture."""

MOST_AXES = 10
"""Numbers that get a parallel axis: those that matter most."""

MOST_LINES = 200
"""Across parallel axes, of the best, of the others, and of those without a duration, each."""

NO_DURATION = 1.12
"""Where variants without a duration meet the last axis; the longest shown is at 1."""

AXIS_LETTERS = 26
"""Of the name of a parallel axis."""

LINE_COLOURS = ("#cfd3d8", "#9db4cc", COLOURS[1])
"""Without a duration, others, the best."""

LINES_HEIGHT = 480
"""[px]."""

CELL_LETTERS = 80
"""Of a line of what is told of a cell."""


def study_map_plot(table: StudyTable, over: Sequence[str] = ()) -> Plot:
    """The shortest duration over two numbers of a study, and which limit binds; over its only number, both as one.

    Args:
        table: The study, with at least one variant and one number.
        over: Paths of one or two of its numbers; without any, all, or the two that matter most.

    Raises:
        InputError: If the study does not vary them.
    """
    drawn = study_map(table, over)
    title = _title(table, map_remark(table, drawn))
    panels = [_line_panel(table, drawn)] if len(drawn.knobs) == 1 else _map_panels(table, drawn)
    return Plot(name="map" if len(drawn.knobs) > 1 else "line", title=title, rows=[panels])


def _title(table: StudyTable, *remarks: str) -> str:
    return "\n".join([f"{table.name}: {outcome_text(table)}", best_text(table), *filter(None, remarks)])


def _map_panels(table: StudyTable, drawn: StudyMap) -> list[Panel]:
    grid: dict[str, Any] = {"x": drawn.edges[0], "y": drawn.edges[1], "texts": _texts(table, drawn)}
    limits, binding = map_binding(table, drawn)
    colors, hatches = zip(*(WITHOUT.get(name, ("#fff", "")) for name in OUTCOMES), strict=True)
    without = HeatMap(**grid, z=drawn.outcome, names=list(OUTCOMES), colors=colors, hatches=hatches)
    duration: list[Item] = []
    if len(table.ranked):
        low, high = duration_ends(table)
        duration = [HeatMap(**grid, z=best_values(drawn, table.duration), colors=FASTER, low=low, high=high, unit="s",
                            title="shortest duration [s]", contours=drawn.exact)]  # fmt: skip
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
    (edges,), durations = drawn.edges, best_values(drawn, table.duration)
    limits, binding = map_binding(table, drawn)
    fills = [
        (binding == code, name, _pale(color), "")
        for code, (name, color) in enumerate(zip(limits, LIMIT_COLOURS, strict=False))
    ]
    fills += [(drawn.outcome == code, name, *WITHOUT[name]) for code, name in enumerate(OUTCOMES) if name in WITHOUT]
    log = bool(len(table.ranked)) and spreads_widely(table)
    low, high = (np.nanmin(durations), np.nanmax(durations)) if len(table.ranked) else (0.0, 1.0)
    margin = MARGIN * ((high - low) or high)
    ends = (low / (1 + MARGIN), high * (1 + MARGIN)) if log else (low - margin, high + margin)
    items: list[Item] = [
        upright_areas(neighbours(edges, where), ends, name, color, hatch)
        for where, name, color, hatch in fills
        if np.any(where)
    ]
    middles = (edges[1:] + edges[:-1]) / 2
    items.append(Line(x=middles, y=durations, label="shortest duration", unit="s", color="#1b1b1b"))
    items += _best(table, table.values[:, drawn.knobs[0]], table.duration)
    y = Axis(label="duration [s]", log=log, ends=ends)
    return Panel(title="Shortest duration and what limits it", x=_knob_axis(table, drawn, 0), y=y, items=items)


def _pale(color: str) -> str:
    red, green, blue = (255 - (255 - int(color[at : at + 2], 16)) * 3 // 10 for at in (1, 3, 5))
    return f"#{red:02x}{green:02x}{blue:02x}"


def durations_plot(table: StudyTable) -> Plot:
    """Which share of all variants finishes within a duration, above how the durations spread."""
    title = _title(table, "; ".join(managed_texts(table)) if len(table.ranked) else "")
    if not len(table.ranked):
        return Plot(name="durations", title=title, rows=[[Panel(note="no variant has a duration")]])
    durations, log = table.duration[table.ranked], spreads_widely(table)
    percent = 100 * np.arange(1, len(durations) + 1) / table.variants
    marks = [(share, end) for share in SHARES if (end := managed(table, share)) is not None]
    share, at = (np.array([mark[part] for mark in marks], dtype=np.float64) for part in (0, 1))
    above: list[Item] = [
        Line(x=durations, y=percent, label="finish within this duration", unit="%", steps=True),
        Rule(at=float(percent[-1]), color=COLOURS[1], dash=1, label="can be played at all"),
        Points(x=at, y=share),
    ]
    count = int(np.clip(np.sqrt(len(durations)), FEWEST_BINS, MOST_BINS))
    divided = np.geomspace if log else np.linspace
    bins = divided(durations[0], max(durations[-1], durations[0] * (1 + SAME)), count + 1)
    height = 100 / table.variants * np.histogram(durations, bins)[0]
    spread = Bars(place=(bins[1:] + bins[:-1]) / 2, end=height, thickness=np.diff(bins),
                  color=COLOURS[5], upright=True)  # fmt: skip
    x = Axis(label="shortest duration [s]", log=log, ends=(float(bins[0]), float(bins[-1])), hover="{} s")
    rows = [
        [Panel(x=x, y=Axis(label="share of all variants [%]", ends=(0.0, 104.0)), items=above)],
        [Panel(x=x, y=Axis(label="in each bin [%]"), items=[spread])],
    ]
    return Plot(name="durations", title=title, rows=rows, shared=True)


def parallel_figure(table: StudyTable) -> dict[str, Any]:
    """The variants through an axis for each number that matters and one for the duration, as plotly reads them.

    A drag along an axis filters them. The "remark" says what is left out, if anything is.
    """
    knobs = sorted(weight.knob for weight in weights(table)[:MOST_AXES])
    first = len(best_part(table))
    without = np.flatnonzero(~np.isin(np.arange(table.variants), table.ranked))
    groups = [_some(rows) for rows in (without, table.ranked[first:], table.ranked[:first])]
    groups[2] = groups[2][::-1]  # the best above all others
    rows: Index = np.concatenate(groups)
    axes: list[dict[str, Any]] = []
    for knob in knobs:
        shown = table.values[:, knob]
        axis = {"label": plot_text(shortened(table.knobs[knob].title, AXIS_LETTERS)), "values": numbers(shown[rows])}
        ends = numbers(np.array([np.min(shown), np.max(shown)]))
        axes.append(axis | {"range": ends} if ends[0] != ends[1] else axis)
    low, high = duration_ends(table) if len(table.ranked) else (0.0, 1.0)
    share = (table.duration[rows] - low) / (high - low) if high > low else np.full(len(rows), 0.5)
    heights = np.where(np.isnan(table.duration[rows]), NO_DURATION, np.minimum(share, 1))
    ticks = np.linspace(0, 1, 6)
    names = [span_texts(low, low + tick * (high - low))[1] for tick in ticks]
    names[-1] = f"≥ {names[-1]}"
    axes.append({"label": "duration [s]", "values": numbers(heights), "range": [0, NO_DURATION],
                 "tickvals": [*ticks.tolist(), NO_DURATION], "ticktext": [*names, "none"]})  # fmt: skip
    kind = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    scale = [[end / 3, color] for code, color in enumerate(LINE_COLOURS) for end in (code, code + 1)]
    trace = {
        "type": "parcoords",
        "dimensions": axes,
        "line": {"color": kind.tolist(), "colorscale": scale, "cmin": -0.5, "cmax": 2.5, "showscale": False},
        "labelangle": -20,
        "labelfont": {"size": 12},
        "unselected": {"line": {"color": "#eee", "opacity": 0.15}},
    }
    shape = {
        "font": FONT | {"size": 12},
        "margin": {"l": 110, "r": 90, "t": 110, "b": 30},
        "paper_bgcolor": "#fff",
        "height": LINES_HEIGHT,
    }
    remarks = []
    if len(knobs) < len(table.knobs):
        remarks.append(f"the {len(knobs)} of {len(table.knobs)} numbers that matter most")
    if len(rows) < table.variants:
        remarks.append(f"an even choice of {len(rows)} of {table.variants} variants")
    return {"data": [trace], "layout": shape, "clock": "", "remark": ", ".join(remarks)}


def _some(rows: Index) -> Index:
    if len(rows) <= MOST_LINES:
        return rows
    return np.asarray(rows[np.linspace(0, len(rows) - 1, MOST_LINES).round().astype(int)])
