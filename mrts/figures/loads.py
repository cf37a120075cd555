# SPDX-License-Identifier: MIT
"""c²⁺(t) of a load that is known only within a box."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from mrts.base.arrays import Array
from mrts.drawing.axis_reach import c2_reach
from mrts.drawing.load_envelope import load_envelope
from mrts.figures.style import NotebookFigure, finish, legend_below, line_style, plain_text
from mrts.scaling.range import ScalingRange
from mrts.scaling.result import ScalingResult

LEGEND_COLUMNS = 3
"""Of the questions of one load: each names its c²⁺."""

LOAD_AXIS = "largest c² at the sample [1]"


def load_figure(results: Mapping[str, ScalingResult]) -> NotebookFigure:
    """c²⁺(t) for several questions of one load, and how fast each lets the whole motion be played.

    Args:
        results: By label, such as "nominal", "guaranteed", "possible".
    """
    figure = NotebookFigure(figsize=(7.0, 4.4), layout="constrained")
    axes = figure.subplots()
    for index, (label, result) in enumerate(results.items()):
        _draw_upper(axes, result.range, label, index)
    axes.set_ylim(0, max(c2_reach(result.range)[1] for result in results.values()))
    finish(axes, "time of the given motion [s]", LOAD_AXIS)
    legend_below(axes, columns=min(len(results), LEGEND_COLUMNS))
    return figure


def draw_load_study(axes: Axes, result: ScalingResult) -> None:
    """c²⁺(t) of the answer, and what the loads that were looked at span, with the worst and the best of them.

    Args:
        axes: Where to draw.
        result: A result of an uncertain load.

    Raises:
        ValueError: If the load is known.
    """
    study = result.load
    if study is None:
        raise ValueError("the load is known: there is no study to draw")
    low, high = c2_reach(result.range)
    envelope = load_envelope(study)
    if envelope is not None:
        worst, best = envelope.order[0], envelope.order[-1]
        high = max(high, c2_reach(study.ranges[best])[1])
        least, largest = (np.clip(side, low, high) for side in (envelope.least, envelope.largest))
        label = f"between {len(study.points)} loads"
        axes.fill_between(result.range.samples.time, least, largest, color="#dddddd", linewidth=0, label=label)
        _draw_upper(axes, study.ranges[best], f"best: {study.points[best]}", 2)
        _draw_upper(axes, study.ranges[worst], f"worst: {study.points[worst]}", 1)
    _draw_upper(axes, result.range, study.question, 0, linewidth=2.4)
    axes.set_ylim(low, high)
    finish(axes, "time of the given motion [s]", LOAD_AXIS)
    legend_below(axes, columns=1)


def study_figure(result: ScalingResult) -> NotebookFigure:
    """The picture of an uncertain load.

    Args:
        result: A result of an uncertain load.

    Raises:
        ValueError: If the load is known.
    """
    figure = NotebookFigure(figsize=(7.0, 5.0), layout="constrained")
    draw_load_study(figure.subplots(), result)
    figure.suptitle(plain_text(f"{result.cell.name}: {result.range.status.value}"), fontsize="medium")
    return figure


def _draw_upper(axes: Axes, found: ScalingRange, label: str, index: int, linewidth: float = 1.5) -> None:
    samples, end = found.samples, found.upper
    style = line_style(index)
    upper: Array = np.where(np.isfinite(samples.upper), samples.upper, np.nan)
    known = end is not None and np.isfinite(end.c2) and found.status.admits_motion
    reach = f"c²⁺ = {end.c2:.4g}" if end is not None and known else found.status.value
    axes.plot(samples.time, upper, label=plain_text(f"{label} ({reach})"), linewidth=linewidth, **style)
    if end is not None and end.time is not None:
        axes.plot(end.time, end.c2, "o", color=style["color"], clip_on=False)
