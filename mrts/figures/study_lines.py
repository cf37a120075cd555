# SPDX-License-Identifier: MIT
"""The variants of a study as lines through parallel axes."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from mrts.drawing.colours import COLOURS
from mrts.drawing.study_lines import NO_DURATION, ParallelAxes, parallel_axes
from mrts.drawing.study_table import StudyTable
from mrts.drawing.study_words import span_texts
from mrts.figures.study_maps import study_title
from mrts.figures.style import NotebookFigure, in_lines, plain

AXIS_INCHES = 1.25
LINE_LETTERS, MOST_LETTERS = 15, 44
"""Of a line of an axis' name, and of the name."""

BELOW, ABOVE = -0.03, 1.03
"""Where the ends of an axis are written, its own at 0 and 1."""

BESIDE = 0.06
"""From the last axis to what is written beside it, of the distance of the axes."""

LOOKS: dict[str, dict[str, Any]] = {
    "without": {"color": "#9a9a9a", "linewidth": 0.5, "alpha": 0.5, "linestyle": ":", "label": "cannot be played"},
    "others": {"color": "#7f93a8", "linewidth": 0.6, "alpha": 0.45, "label": "the others"},
    "best": {"color": COLOURS[1], "linewidth": 1.0, "alpha": 0.7, "label": "the best 5 %"},
    "first": {"color": "black", "linewidth": 2.2, "label": "the best"},
}


def draw_parallel_coordinates(axes: Axes, table: StudyTable, drawn: ParallelAxes) -> None:
    """The best variants strong, other ones thin, those without a duration faint.

    Args:
        axes: Where to draw; the legend stands below.
        table: The study.
        drawn: Its axes and lines.
    """
    count = len(drawn.knobs) + 1
    place = np.arange(count)
    groups = {"without": drawn.without, "others": drawn.others, "best": drawn.best[::-1], "first": drawn.best[:1]}
    for name, rows in groups.items():
        if len(rows):
            lines = [np.column_stack([place, line]) for line in drawn.heights(table, rows)]
            axes.add_collection(LineCollection(lines, **LOOKS[name]))
    axes.vlines(place, 0, 1, color="black", linewidth=0.9)
    white = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
    for at, (low, high) in enumerate(zip(drawn.low.tolist(), drawn.high.tolist(), strict=True)):
        first, last = span_texts(low, high)
        axes.text(at, BELOW, first, ha="center", va="top", fontsize="small")
        if at < count - 1:
            axes.text(at, ABOVE, last, ha="center", va="bottom", fontsize="small", bbox=white)
        else:
            axes.text(at + BESIDE, 1, last, va="center", fontsize="small", bbox=white)
    if len(drawn.without):
        axes.text(count - 1 + BESIDE, NO_DURATION, "none", fontsize="small", va="center")
    axes.xaxis.tick_top()
    titles = [in_lines(plain(table.knobs[knob].title, MOST_LETTERS), LINE_LETTERS) for knob in drawn.knobs]
    axes.set_xticks(place, [*titles, "duration\n[s]"], fontsize="small")
    axes.tick_params(length=0)
    axes.set_yticks([])
    axes.set_xlim(-0.3, count - 0.6)
    axes.set_ylim(2 * BELOW - 0.02, NO_DURATION + 0.02)
    axes.spines[:].set_visible(False)
    legend = axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=4, fontsize="small", frameon=False)
    for line in legend.get_lines():
        line.set_alpha(1.0)


def parallel_coordinates_figure(table: StudyTable) -> NotebookFigure:
    """The variants of a study through an axis for each number and one for the duration.

    Args:
        table: The study, with at least one variant.
    """
    drawn = parallel_axes(table)
    figure = NotebookFigure(figsize=(max(8.0, 1.5 + AXIS_INCHES * (len(drawn.knobs) + 1)), 5.6), layout="constrained")
    draw_parallel_coordinates(figure.subplots(), table, drawn)
    figure.suptitle(study_title(table, drawn.remark(table)), fontsize="small", x=0.01, ha="left")
    return figure
