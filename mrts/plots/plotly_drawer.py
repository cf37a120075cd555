# SPDX-License-Identifier: MIT
"""Draws plots as plotly reads them: traces and a layout, for pages and notebooks. It needs no plotly itself."""

from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import printable
from mrts.plots.plot import Axis, Band, Item, Line, Panel, Plot, Points, shortened

DASHES = ("solid", "dash", "dashdot", "dot", "longdash", "longdashdot", "2px,6px")
"""A second difference between lines, for print without colour."""

SYMBOLS = {"circle": "circle", "dot": "circle", "cross": "x", "star": "star"}
SIZES = {"circle": 10, "dot": 3, "cross": 9, "star": 15}

MOST_SAMPLES = 500
"""Evenly chosen samples of a line; the extreme ones of every line are kept beside these."""

DIGITS = 6
"""Of the numbers in a plot."""

PANEL_HEIGHT, ROW_HEIGHT, AROUND = 260, 22, 62
"""Of a panel, of a row of names, and of what stands around them [px]; the page adds the height of the legend."""

OUTSIDE = 10.0
"""How far beyond what is shown the edge of an area may lie, of what is shown."""

FONT = {"family": "system-ui, sans-serif", "size": 13, "color": "#1b1b1b"}

FRAME = {"showline": True, "mirror": True, "linecolor": "#888", "gridcolor": "#e5e5e5", "zeroline": False}


def plotly_figure(plot: Plot) -> dict[str, Any]:
    """Traces ("data"), "layout", which holds its height, and "clock" of a plot whose panels stand below each other."""
    panels = [panel for row in plot.rows for panel in row]
    heights = [_height(panel) for panel in panels]
    closest = not any(isinstance(item, Line) for item in panels[0].items)
    shape: dict[str, Any] = {
        "font": FONT,
        "margin": {"l": 64, "r": 34, "t": 12, "b": 48},
        "modebar": {"orientation": "v"},
        "paper_bgcolor": "#fff",
        "plot_bgcolor": "#fff",
        "hovermode": "closest" if closest else "x unified",
        "hoverlabel": {"namelength": -1},
        "legend": {"orientation": "h", "x": 0, "y": 1.01, "yanchor": "bottom", "itemwidth": 42, "traceorder": "normal"},
        "height": sum(heights) + AROUND,
        "annotations": [],
    }
    traces: list[dict[str, Any]] = []
    top = 1.0
    for number, (panel, height) in enumerate(zip(panels, heights, strict=True)):
        last = "" if number == 0 else str(number + 1)
        bottom = top - height / sum(heights)
        shape[f"yaxis{last}"] = _axis(panel.y) | {
            "domain": [max(0.0, bottom + (0.03 if number < len(panels) - 1 else 0)), top]
        }
        top = bottom
        drawn = [trace for item in panel.items for trace in _traces(item, panel)]
        traces += [trace | {"yaxis": f"y{last}"} for trace in drawn]
        if panel.note:
            word = {"x": 0.5, "xref": "paper", "y": 0.5, "yref": f"y{last} domain", "showarrow": False}
            shape["annotations"].append(word | {"text": plot_text(panel.note), "bgcolor": "#ffffffc0"})
    below = panels[-1].x
    anchor = {"anchor": f"y{len(panels)}", "mirror": "all"} if len(panels) > 1 else {}
    shape["xaxis"] = _axis(below) | anchor | {"unifiedhovertitle": {"text": below.hover.format("%{x:.4g}")}}
    return {"data": traces, "layout": shape, "clock": plot.clock}


def _height(panel: Panel) -> int:
    return ROW_HEIGHT * len(panel.y.names) + 12 if panel.y.names else PANEL_HEIGHT


def plot_text(text: str) -> str:
    """Text for plotly, which reads some HTML in names and labels, and TeX between two $."""
    return escape(printable(text, lines=True), quote=False).replace("$", "&#36;")


def numbers(values: Array) -> list[Any]:
    """An array for JSON, to `DIGITS` digits; None stands for what is not finite."""
    flat = [float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None for value in np.ravel(values).tolist()]
    return flat if np.ndim(values) == 1 else np.reshape(np.array(flat, dtype=object), np.shape(values)).tolist()


def shown_samples(count: int, *values: Array) -> NDArray[np.int_]:
    """Samples that are enough to draw lines: all, or an even choice and the extremes of every line, Shape (N,) each."""
    if count <= MOST_SAMPLES:
        return np.arange(count)
    even = np.linspace(0, count - 1, MOST_SAMPLES).round().astype(int)
    finite = [np.nan_to_num(line, posinf=0.0, neginf=0.0) for line in values]
    extremes = [np.array([np.argmin(line), np.argmax(line)]) for line in finite]
    return np.unique(np.concatenate([even, *extremes]))


def _axis(axis: Axis) -> dict[str, Any]:
    shape = FRAME | {"title": {"text": plot_text(axis.label)}}
    if axis.ends is not None:
        shape["range"] = numbers(np.array(axis.ends))
    if not axis.names:
        return shape
    labels = [plot_text(name) for name in map(shortened, axis.names)]
    for place, strong in enumerate(axis.strong):
        labels[place] = f"<b>{labels[place]}</b>" if strong else labels[place]
    for place, color in enumerate(axis.colors):
        labels[place] = f'<span style="color:{color}">{labels[place]}</span>'
    ticks = {"tickvals": list(range(len(labels))), "ticktext": labels, "tickfont": {"size": 11}}
    return shape | ticks | {"automargin": True, "fixedrange": True, "showgrid": False}


def _traces(item: Item, panel: Panel) -> list[dict[str, Any]]:
    if isinstance(item, Line):
        return _line(item, panel)
    if isinstance(item, Points):
        return [_points(item, panel.x)]
    return [_band(item, panel.y)]


def _named(label: str) -> dict[str, Any]:
    return {"name": plot_text(shortened(label)), "showlegend": bool(label)}


def _line(line: Line, panel: Panel) -> list[dict[str, Any]]:
    alike = [other.y for other in panel.items if isinstance(other, Line) and len(other.y) == len(line.y)]
    shown = shown_samples(len(line.x), *alike)
    look = {"color": line.color, "dash": DASHES[line.dash % len(DASHES)], "width": line.width + 0.5}
    if line.steps:
        look["shape"] = "hv"
    group = f"{panel.items.index(line)}"
    own = {
        "x": numbers(line.x[shown]),
        "y": numbers(line.y[shown]),
        "mode": "lines",
        "line": look,
        "legendgroup": group,
    }
    own |= _named(line.label)
    own |= {"hoverinfo": "skip"} if line.unit is None else {"hovertemplate": f"%{{y:.4g}} {line.unit}".rstrip()}
    if line.texts:
        texts = [plot_text(line.texts[place]).replace("\n", "<br>") for place in shown.tolist()]
        own |= {"text": texts, "hovertemplate": f"{own['hovertemplate']}<br>%{{text}}"}
    thin: dict[str, Any] = {"mode": "lines", "hoverinfo": "skip", "legendgroup": group, "showlegend": False, "name": ""}
    traces = [own]
    for limit in line.limits:
        at = np.array([0, -1]) if np.all(limit == limit[0]) else shown
        traces.append(thin | {"x": numbers(line.x[at]), "y": numbers(limit[at]), "line": look | {"width": 0.8}})
    return traces


def _points(points: Points, along: Axis) -> dict[str, Any]:
    marker: dict[str, Any] = {"symbol": SYMBOLS[points.symbol], "size": SIZES[points.symbol], "color": points.color}
    if points.symbol == "star":
        marker["line"] = {"width": 1.5, "color": "#000"}
    own = {"x": numbers(points.x), "y": numbers(points.y), "marker": marker, "cliponaxis": False, "hoverinfo": "skip"}
    texts = [f"<b>{plot_text(text)}</b>" if text else "" for text in points.texts]
    low, high = along.ends if along.ends is not None else (0.0, np.inf)
    side = "bottom" if points.below else "top"
    sides = [f"{side} {'left' if x > (low + high) / 2 else 'right'}" for x in points.x.tolist()]
    written = {"mode": "markers+text", "text": texts, "textposition": sides} if any(texts) else {"mode": "markers"}
    return own | written | _named(points.label)


def _band(band: Band, y: Axis) -> dict[str, Any]:
    low, high = y.ends if y.ends is not None else (-np.inf, np.inf)
    reach = OUTSIDE * abs(high - low)
    lower, upper = (np.clip(side, min(low, high) - reach, max(low, high) + reach) for side in (band.lower, band.upper))
    around: list[Array] = []
    gaps = np.flatnonzero(np.isnan(band.x)).tolist()
    for start, end in zip([0, *(gap + 1 for gap in gaps)], [*gaps, len(band.x)], strict=True):
        part = slice(start, end)
        sides = [np.stack([band.x[part], lower[part]]), np.stack([band.x[part], upper[part]])[:, ::-1]]
        around += [*sides, np.full((2, 1), np.nan)] if end > start else []
    x, y_values = np.concatenate(around[:-1], axis=1)
    opaque = f"{band.color}{round(255 * band.opacity):02x}" if band.opacity < 1 else band.color
    look = {"mode": "lines", "line": {"width": 0}, "fill": "toself", "fillcolor": opaque, "hoverinfo": "skip"}
    return {"x": numbers(x), "y": numbers(y_values)} | look | _named(band.label)
