# SPDX-License-Identifier: MIT
"""c²⁻(t) and c²⁺(t) above the rows that bind, as plotly reads them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.drawing.axis_reach import c2_reach
from mrts.drawing.colours import ADMISSIBLE, END_COLOURS
from mrts.drawing.labels import row_label, shortened_apart
from mrts.drawing.lanes import Lane, binding_lanes, infeasible_spans, spans
from mrts.drawing.range_sentences import range_text
from mrts.limits.rows import Side
from mrts.program.range_status import RangeStatus
from mrts.report.markup import plot_text
from mrts.report.plots import Plot, layout, line, numbers, shown_samples
from mrts.scaling.range import ScalingRange

CURVES_HEIGHT = 380
LANE_HEIGHT = 22
"""[px]."""

TITLE = "c²⁻(t), c²⁺(t) and the rows that bind (↑ at an upper limit, ↓ at a lower one; bold: they set the range)"


def range_plot(found: ScalingRange, motion: str = "given") -> Plot:
    """The ranges of all samples; hovering names the rows that bind.

    Args:
        found: The range over the motion.
        motion: Whose time it counts: the given or the retimed one.
    """
    samples = found.samples
    low, high = c2_reach(found)
    shape = layout(f"time of the {motion} motion [s]", "c² [1]", (low, high))
    shape["xaxis"]["range"] = numbers(samples.time[[0, -1]])
    word = {"y": 0.5, "yref": "y domain", "showarrow": False, "bgcolor": "#ffffffc0"}
    shape["shapes"], shape["annotations"] = [], []
    for start, end in infeasible_spans(samples):
        area = {"type": "rect", "x0": start, "x1": end, "yref": "y domain", "y0": 0, "y1": 1}
        shape["shapes"].append(area | {"fillcolor": "#ddd", "line": {"width": 0}, "layer": "below"})
    if samples.conflicts:
        widest = max(infeasible_spans(samples), key=lambda span: span[1] - span[0])
        shape["annotations"].append(word | {"x": sum(widest) / 2, "text": "no c² at all"})
    if found.status is RangeStatus.EMPTY and found.lower is not None and found.upper is not None:
        for kind, c2 in (("lower", found.lower.c2), ("upper", found.upper.c2)):
            level = {"type": "line", "x0": 0, "x1": 1, "xref": "x domain", "y0": c2, "y1": c2}
            shape["shapes"].append(level | {"line": {"color": END_COLOURS[kind], "dash": "dot", "width": 1.5}})
    if found.status is RangeStatus.UNBOUNDED:
        shape["annotations"].append(word | {"x": 0.5, "xref": "paper", "text": "no limit depends on the speed"})
    traces = [*_admissible(found, high), *_curves(found), *_ends(found)]
    lanes = binding_lanes(found)
    below = LANE_HEIGHT * len(lanes) + 12
    if lanes:
        share = below / (below + CURVES_HEIGHT - 120)
        shape["yaxis"]["domain"] = [share + 0.03, 1]
        shape["xaxis"] |= {"anchor": "y2", "mirror": "all"}
        shape["yaxis2"] = _lane_axis(lanes, share)
        traces += _lane_traces(lanes, samples.time)
    return Plot("c2-range", TITLE, traces, shape, CURVES_HEIGHT + (below if lanes else 0), "given")


def _curves(found: ScalingRange) -> list[dict[str, Any]]:
    samples = found.samples
    values = np.nan_to_num(np.stack([samples.lower, samples.upper], axis=1), posinf=0.0, neginf=0.0)
    shown = shown_samples(len(samples.time), values)
    ends = [end.sample for end in (found.lower, found.upper) if end is not None and end.sample is not None]
    shown = np.unique(np.concatenate([shown, np.array(ends, dtype=int)]))
    return [
        _curve("c²⁺(t)", "upper", "solid", found, samples.upper, shown),
        _curve("c²⁻(t)", "lower", "dash", found, samples.lower, shown),
    ]


def _curve(
    name: str, kind: Side, dash: str, found: ScalingRange, values: Array, shown: NDArray[np.int_]
) -> dict[str, Any]:
    texts = ["<br>".join(plot_text(row_label(row)) for row in found.binding(sample, kind)) for sample in shown]
    return line(found.samples.time[shown], values[shown], name, 0, "", color=END_COLOURS[kind], dash=dash) | {
        "text": texts,
        "hovertemplate": "%{y:.4g}<br>%{text}",
    }


def _admissible(found: ScalingRange, high: float) -> list[dict[str, Any]]:
    """The range over the motion as a band."""
    if not found.status.admits_motion or found.lower is None or found.upper is None:
        return []
    time = found.samples.time[[0, -1]]
    ends = found.lower.c2, min(found.upper.c2, high)
    sides = [line(time, np.array([c2, c2]), f"range {range_text(found)}", 0, None, width=0) for c2 in ends]
    sides[0] |= {"showlegend": False}
    sides[1] |= {"fill": "tonexty", "fillcolor": f"{ADMISSIBLE}30"}
    return sides


def _ends(found: ScalingRange) -> list[dict[str, Any]]:
    """The points that set the range over the motion."""
    marks = []
    middle = float(np.mean(found.samples.time[[0, -1]]))
    for name, kind, end in (("c²⁺", "upper", found.upper), ("c²⁻", "lower", found.lower)):
        if end is None or end.time is None or (kind == "lower" and end.c2 <= 0):
            continue
        marks.append(
            {
                "x": numbers(np.array([end.time])),
                "y": numbers(np.array([end.c2])),
                "mode": "markers+text",
                "text": [f"<b>{name} = {end.c2:.4g}</b>"],
                "textposition": f"{'bottom' if kind == 'upper' else 'top'} {'right' if end.time < middle else 'left'}",
                "marker": {"color": END_COLOURS[kind], "size": 11},
                "cliponaxis": False,
                "hoverinfo": "skip",
                "showlegend": False,
            }
        )
    return marks


def _lane_axis(lanes: list[Lane], share: float) -> dict[str, Any]:
    labels = []
    for lane, name in zip(lanes, shortened_apart([lane.label for lane in lanes]), strict=True):
        label = plot_text(name)
        label = f"<b>{label}</b>" if lane.sets else label
        labels.append(f'<span style="color:{END_COLOURS[lane.kind]}">{label}</span>')
    return {
        "domain": [0, share],
        "range": [len(lanes) - 0.4, -0.6],
        "tickvals": list(range(len(lanes))),
        "ticktext": labels,
        "tickfont": {"size": 11},
        "automargin": True,
        "fixedrange": True,
        "showline": True,
        "mirror": True,
        "linecolor": "#888",
        "showgrid": False,
        "zeroline": False,
    }


def _lane_traces(lanes: list[Lane], time: Array) -> list[dict[str, Any]]:
    words = {"conflict": "in conflict", "upper": "binds at c²⁺(t)", "lower": "binds at c²⁻(t)"}
    traces = []
    for kind, word in words.items():
        x: list[float | None] = []
        y: list[int | None] = []
        for row, lane in enumerate(lanes):
            for start, end in spans(time, lane.binds) if lane.kind == kind else ():
                x += [start, end, None]
                y += [row, row, None]
        if x:
            bar = {"color": END_COLOURS[kind], "width": 12}
            traces.append(
                {"x": x, "y": y, "yaxis": "y2", "mode": "lines", "line": bar, "name": word, "hoverinfo": "skip"}
            )
    return traces
