# SPDX-License-Identifier: MIT
"""Plots of a study as plotly reads them: maps over one or two numbers, parallel coordinates, how durations spread."""

from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.drawing.colours import COLOURS
from mrts.drawing.labels import shortened
from mrts.drawing.study_lines import NO_DURATION, ParallelAxes, parallel_axes
from mrts.drawing.study_map import LIMIT_COLOURS, StudyMap, duration_ends, map_binding, spreads_widely, study_map
from mrts.drawing.study_table import OUTCOMES, Index, StudyTable
from mrts.drawing.study_words import SHARES, limits_text, managed, span_texts, variant_text
from mrts.report.markup import plot_text
from mrts.report.plots import Plot, layout, line, numbers, shown_samples

FASTER = "Viridis"
"""Of durations, reversed: bright is fast."""

GREYS = ("#fff", "#e3f1e9", "#bbb", "#a9a9a9", "#d9d9d9", "#8d8d8d", "#6f6f6f")
OUTCOME_COLOURS = dict(zip(OUTCOMES, GREYS, strict=True))
"""Of what has no duration: greys, which no duration has."""

MAP_HEIGHT, LINES_HEIGHT = 460, 480
"""[px]."""

AXIS_LETTERS = 26
"""Of the name of an axis among parallel ones."""

LINE_COLOURS = ("#cfd3d8", "#9db4cc", COLOURS[1])
"""Without a duration, others, the best."""


def map_plots(table: StudyTable) -> tuple[StudyMap, list[Plot]]:
    """The map over both numbers of a study or the two that matter most, or the line over its only one.

    Args:
        table: The study, with at least one variant and one number.
    """
    drawn = study_map(table)
    return drawn, [_line_plot(table, drawn)] if len(drawn.axes) == 1 else _heat_maps(table, drawn)


def _heat_maps(table: StudyTable, drawn: StudyMap) -> list[Plot]:
    texts = _texts(table, drawn)
    heat: list[dict[str, Any]] = []
    if len(table.ranked):
        ends = dict(zip(("zmin", "zmax"), duration_ends(table), strict=True))
        bar = {"title": {"text": "duration [s]", "side": "right"}, "thickness": 14}
        look = {"colorscale": FASTER, "reversescale": True, "colorbar": bar} | ends
        heat = [_cells(drawn, drawn.of_best(table.duration), texts) | look]
    binding = map_binding(table, drawn)
    limits = [_codes(drawn, np.where(binding.codes < 0, np.nan, binding.codes), LIMIT_COLOURS, texts)]
    without = _codes(drawn, np.where(drawn.outcome < 0, np.nan, drawn.outcome), tuple(OUTCOME_COLOURS.values()), texts)
    found = sorted(set(drawn.outcome[drawn.outcome >= 0].tolist()))
    keys = [_key(table.outcome.names[code], OUTCOME_COLOURS[table.outcome.names[code]]) for code in found]
    named = [_key(shortened(name), colour) for name, colour in zip(binding.names, LIMIT_COLOURS, strict=False)]
    x, y = (table.knobs[cells.knob].title for cells in drawn.axes)
    plots = []
    for name, title, traces in (("duration-map", "Shortest duration", [*heat, without, *keys]),
                                ("limit-map", "What limits it", [*limits, without, *named, *keys])):  # fmt: skip
        shape = _map_layout(drawn, x, y)
        plots.append(Plot(name, title, [*traces, *_best(table, drawn)], shape, MAP_HEIGHT + 18 * len(keys + named)))
    return plots


def _map_layout(drawn: StudyMap, xtitle: str, ytitle: str) -> dict[str, Any]:
    x, y = drawn.axes
    shape = layout(plot_text(xtitle), plot_text(ytitle), (float(y.edges[0]), float(y.edges[-1])))
    shape["xaxis"] |= {"range": numbers(x.edges[[0, -1]]), "showgrid": False}
    shape["yaxis"] |= {"showgrid": False, "automargin": True}
    shape["hovermode"] = "closest"
    shape["xaxis"].pop("unifiedhovertitle")
    return shape


def _cells(drawn: StudyMap, values: Array, texts: list[list[str]]) -> dict[str, Any]:
    x, y = drawn.axes
    return {"type": "heatmap", "x": numbers(x.edges), "y": numbers(y.edges), "z": numbers(values), "text": texts,
            "hovertemplate": "%{text}<extra></extra>", "hoverongaps": False}  # fmt: skip


def _codes(drawn: StudyMap, codes: Array, colours: tuple[str, ...], texts: list[list[str]]) -> dict[str, Any]:
    """Cells in the colours of their codes."""
    count = len(colours)
    steps = [[end / count, colour] for code, colour in enumerate(colours) for end in (code, code + 1)]
    return _cells(drawn, codes, texts) | {"zmin": -0.5, "zmax": count - 0.5, "colorscale": steps, "showscale": False}


def _key(name: str, colour: str) -> dict[str, Any]:
    """An entry of the legend."""
    marker = {"symbol": "square", "size": 12, "color": colour, "line": {"width": 1, "color": "#666"}}
    return {"x": [None], "y": [None], "mode": "markers", "marker": marker, "name": plot_text(name)}


def _best(table: StudyTable, drawn: StudyMap) -> list[dict[str, Any]]:
    """The best as a star."""
    if not len(table.ranked):
        return []
    row = int(table.ranked[0])
    values = [table.values[row, cells.knob] for cells in drawn.axes]
    values = values if len(values) > 1 else [*values, table.duration[row]]
    x, y = (numbers(np.array([value])) for value in values)
    star = {"symbol": "star", "size": 15, "color": "#fff", "line": {"width": 1.5, "color": "#000"}}
    return [{"x": x, "y": y, "mode": "markers", "marker": star, "name": "the best", "cliponaxis": False,
             "hoverinfo": "skip"}]  # fmt: skip


def _texts(table: StudyTable, drawn: StudyMap) -> list[Any]:
    """What is said of each cell: its best variant, or what became of it."""
    texts = np.full(drawn.best.shape, "", dtype=object)
    for place, best in np.ndenumerate(drawn.best):
        row = int(best)
        if row >= 0:
            said = [variant_text(table, row)]
            said += [f"limited by {limits_text(table, row)}"] if table.limits(row) else []
            for number in (cells.knob for cells in drawn.axes):
                knob = table.knobs[number]
                said.append(f"{knob.path} = {table.values[row, number]:.4g} {knob.unit}".rstrip())
            texts[place] = "<br>".join(plot_text(shortened(each, 80)) for each in said)
        elif drawn.outcome[place] >= 0:
            name = table.outcome.names[drawn.outcome[place]]
            texts[place] = f"{name}: {OUTCOMES[name]}"
    return list(texts.tolist())


def _line_plot(table: StudyTable, drawn: StudyMap) -> Plot:
    cells = drawn.axes[0]
    durations = drawn.of_best(table.duration)
    binding = map_binding(table, drawn)
    finite = durations[np.isfinite(durations)]
    low, high = (float(np.min(finite)), float(np.max(finite))) if len(finite) else (0.0, 1.0)
    margin = 0.06 * (high - low) or 0.1 * high or 1.0
    shape = layout(plot_text(table.knobs[cells.knob].title), "shortest duration [s]", (low - margin, high + margin))
    shape["xaxis"] |= {"range": numbers(cells.edges[[0, -1]])}
    shape["xaxis"].pop("unifiedhovertitle")
    if len(finite) and spreads_widely(table):
        shape["yaxis"] |= {"type": "log", "range": numbers(np.log10([low / 1.1, high * 1.1]))}
    shape["hovermode"], shape["shapes"] = "closest", []
    keys = []
    fills = [(binding.codes == code, name, colour) for code, (name, colour) in
             enumerate(zip(binding.names, LIMIT_COLOURS, strict=False))]  # fmt: skip
    fills += [(drawn.outcome == code, name, OUTCOME_COLOURS[name]) for code, name in enumerate(table.outcome.names)]
    for where, name, colour in fills:
        if np.any(where):
            keys.append(_key(shortened(name), colour))
        for cell in np.flatnonzero(where).tolist():
            area = {"type": "rect", "x0": cells.edges[cell], "x1": cells.edges[cell + 1], "yref": "paper", "y0": 0}
            shape["shapes"].append(area | {"y1": 1, "fillcolor": colour, "opacity": 0.35, "line": {"width": 0},
                                           "layer": "below"})  # fmt: skip
    curve = line(cells.middles, durations, "shortest duration", 6, "s", color="#000") | {
        "mode": "lines+markers", "marker": {"size": 4}, "text": _texts(table, drawn),
        "hovertemplate": "%{text}<extra></extra>",
    }  # fmt: skip
    title = "Shortest duration, and what limits it"
    return Plot("duration-line", title, [curve, *keys, *_best(table, drawn)], shape, MAP_HEIGHT + 18 * len(keys))


def lines_plot(table: StudyTable) -> tuple[ParallelAxes, Plot]:
    """The variants through an axis for each number and one for the duration; a drag along an axis filters them.

    Args:
        table: The study, with at least one variant.
    """
    drawn = parallel_axes(table)
    groups = (drawn.without, drawn.others, drawn.best[::-1])
    rows: Index = np.concatenate(groups)
    kind = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    axes = []
    for at, knob in enumerate(drawn.knobs):
        ends = numbers(np.array([drawn.low[at], drawn.high[at]]))
        title = plot_text(shortened(table.knobs[knob].title, AXIS_LETTERS))
        axes.append({"label": title, "values": numbers(table.values[rows, knob]), "range": ends} if ends[0] != ends[1]
                    else {"label": title, "values": numbers(table.values[rows, knob])})  # fmt: skip
    heights = drawn.heights(table, rows)[:, -1]
    low, high = float(drawn.low[-1]), float(drawn.high[-1])
    ticks = np.linspace(0, 1, 6)
    names = [span_texts(low, low + tick * (high - low))[1] for tick in ticks]
    names[-1] = f"≥ {names[-1]}"
    axes.append({"label": "duration [s]", "values": numbers(heights), "range": [0, NO_DURATION],
                 "tickvals": [*ticks.tolist(), NO_DURATION], "ticktext": [*names, "none"]})  # fmt: skip
    scale = [[end / 3, colour] for code, colour in enumerate(LINE_COLOURS) for end in (code, code + 1)]
    trace = {
        "type": "parcoords",
        "dimensions": axes,
        "line": {"color": kind.tolist(), "colorscale": scale, "cmin": -0.5, "cmax": 2.5, "showscale": False},
        "labelangle": -20,
        "labelfont": {"size": 12},
        "unselected": {"line": {"color": "#eee", "opacity": 0.15}},
    }
    shape = {
        "font": {"family": "system-ui, sans-serif", "size": 12, "color": "#1b1b1b"},
        "margin": {"l": 110, "r": 90, "t": 110, "b": 30},
        "paper_bgcolor": "#fff",
    }
    return drawn, Plot("lines", "Orange: the best 5 %; blue: the others; grey: cannot be played", [trace], shape,
                       LINES_HEIGHT)  # fmt: skip


def durations_plot(table: StudyTable) -> Plot | None:
    """Which share of all variants manages a duration; None if none has one.

    Args:
        table: The study.
    """
    durations = table.duration[table.ranked]
    if not len(durations):
        return None
    percent = 100 * np.arange(1, len(durations) + 1) / table.variants
    shown = shown_samples(len(durations))
    curve = line(durations[shown], percent[shown], "manage this duration", 0, "%", shape="hv")
    ends = [(share, managed(table, share)) for share in SHARES]
    marks = [(share, value) for share, value in ends if value is not None]
    points = {
        "x": [value for _, value in marks],
        "y": [share for share, _ in marks],
        "text": [f"{share} %: {value:.4g} s" for share, value in marks],
        "mode": "markers+text",
        "textposition": ["bottom right" if share == marks[0][0] else "bottom left" for share, _ in marks],
        "marker": {"size": 9, "color": COLOURS[0]},
        "hoverinfo": "skip",
        "showlegend": False,
    }
    all_of_it = line(durations[[0, -1]], np.full(2, percent[-1]), "can be played at all", 1, None)
    shape = layout("duration [s]", "share of all variants [%]", (0.0, 104.0))
    shape["xaxis"]["type"] = "log" if spreads_widely(table) else "linear"
    shape["xaxis"]["unifiedhovertitle"] = {"text": "%{x:.4g} s"}
    return Plot("durations", "Which share of the variants manages which duration", [curve, all_of_it, points], shape)
