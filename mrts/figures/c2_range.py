# SPDX-License-Identifier: MIT
"""c²⁻(t) and c²⁺(t), the range over the motion, and which rows bind where."""

import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from mrts.drawing.axis_reach import c2_reach
from mrts.drawing.colours import ADMISSIBLE, CONFLICT, END_COLOURS
from mrts.drawing.labels import LANE_LETTERS
from mrts.drawing.lanes import Lane, binding_lanes, infeasible_spans, spans
from mrts.drawing.range_sentences import range_facts, range_text
from mrts.figures.style import NotebookFigure, finish, plain, plain_text
from mrts.program.range_status import RangeStatus
from mrts.scaling.result import ScalingResult

FACT_LETTERS = 110
"""Letters of a line above the figure."""

LANE_INCHES = 0.21

NAME_LETTERS = 72
"""Letters of a row's name; beyond `LANE_LETTERS` they make the figure wider."""

LETTER_INCHES = 0.075
"""Width of a bold one."""

HATCHED: dict[str, Any] = {"facecolor": "#e4e4e4", "edgecolor": "#9a9a9a", "hatch": "///", "linewidth": 0}
"""Where no c² keeps the limits."""

LANE_WORDS = {
    "upper": "orange: bind at c²⁺(t)",
    "lower": "blue: bind at c²⁻(t)",
    "conflict": "black: in conflict",
}


def draw_range(axes: Axes, result: ScalingResult) -> None:
    """c²⁻(t), c²⁺(t), the range over the motion and what sets it; samples without any c² are hatched.

    Args:
        axes: Where to draw; the legend stands above.
        result: Any result.
    """
    found = result.range
    samples = found.samples
    for values, kind, dash, name in ((samples.upper, "upper", "-", "c²⁺(t)"), (samples.lower, "lower", "--", "c²⁻(t)")):
        finite = np.isfinite(values)
        if np.any(finite):
            shown = np.where(finite, values, np.nan)
            axes.plot(samples.time, shown, color=END_COLOURS[kind], linestyle=dash, label=name)
    low, high = c2_reach(found)
    if found.status.admits_motion and found.lower and found.upper:
        ends = found.lower.c2, min(found.upper.c2, high)
        axes.axhspan(*ends, color=ADMISSIBLE, alpha=0.15, label=f"range {range_text(found)}")
    for number, (start, end) in enumerate(infeasible_spans(samples)):
        label = "" if number else "no c² at all"
        axes.axvspan(start, end, **HATCHED, label=label)
    _mark_what_sets_it(axes, result)
    if found.status is RangeStatus.UNBOUNDED:
        axes.text(0.5, 0.5, "no limit depends on the speed", transform=axes.transAxes, ha="center", va="center")
    axes.set_ylim(low, high)
    finish(axes, "time of the given motion [s]", "c² [1]")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1.01), ncols=4, fontsize="small", frameon=False, borderaxespad=0)


def _mark_what_sets_it(axes: Axes, result: ScalingResult) -> None:
    found = result.range
    for kind, end, name in (("lower", found.lower, "c²⁻"), ("upper", found.upper, "c²⁺")):
        if end is None or end.time is None or (kind == "lower" and end.c2 <= 0):
            continue
        axes.plot(end.time, end.c2, "o", color=END_COLOURS[kind], markersize=7, clip_on=False, zorder=5)
        if found.status is RangeStatus.EMPTY:
            axes.axhline(end.c2, color=END_COLOURS[kind], linestyle=":")
        right = end.time > np.mean(axes.get_xlim())
        axes.annotate(
            f"{name} = {end.c2:.4g}",
            (end.time, end.c2),
            xytext=(-8 if right else 8, 10 if kind == "lower" else -12),
            textcoords="offset points",
            ha="right" if right else "left",
            va="center",
            fontsize="small",
            bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75},
            zorder=6,
        )
    if found.samples.conflicts:
        worst = max(found.samples.conflicts, key=lambda conflict: conflict.widening)
        axes.plot(worst.time, 1, "v", color=CONFLICT, transform=axes.get_xaxis_transform(), clip_on=False, zorder=5)


def draw_binding_rows(axes: Axes, result: ScalingResult) -> None:
    """Which rows bind where, a lane each: ↑ at an upper limit, ↓ at a lower one.

    Args:
        axes: Where to draw, best below those of `draw_range` with the same time axis.
        result: Any result.
    """
    _draw_lanes(axes, result, binding_lanes(result.range))


def _draw_lanes(axes: Axes, result: ScalingResult, lanes: list[Lane]) -> None:
    found = result.range
    time = found.samples.time
    for row, lane in enumerate(lanes):
        bars = [(start, end - start) for start, end in spans(time, lane.binds)]
        axes.broken_barh(bars, (row - 0.36, 0.72), facecolor=END_COLOURS[lane.kind], linewidth=0)
    for end in (found.lower, found.upper):
        if end is not None and end.time is not None and end.c2 > 0:
            axes.axvline(end.time, color="black", linewidth=0.8, linestyle=":")
    axes.set_yticks(range(len(lanes)), [plain(lane.label, NAME_LETTERS) for lane in lanes], fontsize="small")
    for tick, lane in zip(axes.get_yticklabels(), lanes, strict=True):
        tick.set(color=END_COLOURS[lane.kind], fontweight="bold" if lane.sets else "normal")
    axes.set_ylim(len(lanes) - 0.4, -0.6)
    axes.set_xlim(float(time[0]), float(time[-1]))
    finish(axes, "time of the given motion [s]", "")
    axes.grid(visible=False, axis="y")
    axes.set_axisbelow(True)


def range_figure(result: ScalingResult) -> NotebookFigure:
    """c²⁻(t) and c²⁺(t) above the rows that bind; what no c² satisfies is marked.

    Args:
        result: Any result.
    """
    lanes = binding_lanes(result.range)
    below = LANE_INCHES * len(lanes)
    longest = min(max((len(lane.label) for lane in lanes), default=0), NAME_LETTERS)
    width = 8.0 + LETTER_INCHES * max(longest - LANE_LETTERS, 0)
    figure = NotebookFigure(figsize=(width, 4.2 + below + (0.5 if lanes else 0.0)), layout="constrained")
    facts = [f"{result.cell.name}: {result.status.value}", *range_facts(result.range)]
    title = "\n".join(textwrap.fill(fact, FACT_LETTERS, subsequent_indent="    ") for fact in facts)
    figure.suptitle(plain_text(title), fontsize="small", x=0.01, ha="left")
    if not lanes:
        draw_range(figure.subplots(), result)
        return figure
    above, lane_axes = figure.subplots(2, 1, sharex=True, height_ratios=[3.4, below + 0.1])
    draw_range(above, result)
    above.set_xlabel("")
    _draw_lanes(lane_axes, result, lanes)
    bold = ", bold: set the range" if any(lane.sets for lane in lanes) else ""
    words = [LANE_WORDS[kind] for kind in dict.fromkeys(lane.kind for lane in lanes)]
    lane_axes.set_title(f"rows ({', '.join(words)}{bold})", loc="left", fontsize="small")
    return figure
