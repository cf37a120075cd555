# SPDX-License-Identifier: MIT
"""The durations of a study over one or two of its numbers, and which limit binds where."""

import textwrap
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray

from mrts.drawing.study_map import (
    LIMIT_COLOURS,
    Cells,
    StudyMap,
    duration_ends,
    map_binding,
    map_remark,
    spreads_widely,
    study_map,
)
from mrts.drawing.study_table import StudyTable
from mrts.drawing.study_words import best_text, outcome_text
from mrts.figures.style import NotebookFigure, finish, legend_below, plain, plain_text

FASTER = "viridis_r"
"""Bright is fast; ordered in grey and for every kind of colour vision (van der Walt and Smith, 2015)."""

HATCHES = {"infeasible": "////", "empty": "\\\\\\\\", "unreachable": "xxxx", "invalid": "....", "failed": "****",
           "unbounded": "||||"}  # fmt: skip
"""Of what has no duration."""

WITHOUT: dict[str, Any] = {"facecolor": "#e9e9e9", "edgecolor": "#8a8a8a", "linewidth": 0}

BAND = 0.3
"""Opacity of a band behind a line."""

BEST: dict[str, Any] = {"marker": "*", "markersize": 13, "color": "white", "markeredgecolor": "black",
                        "linestyle": "", "label": "the best", "clip_on": False, "zorder": 5}  # fmt: skip

CONTOURS = 4
"""Of one duration each; a map with fewer cells along an axis has none."""

MOST_POINTS = 60
"""Of a line, up to which each has a mark."""

LEGEND_INCHES = 0.2
TITLE_LETTERS = 120


def draw_study_map(axes: Axes, table: StudyTable, drawn: StudyMap) -> None:
    """Duration of the best variant in every cell over two numbers; cells without one are hatched.

    Args:
        axes: Where to draw; a bar of colours is put beside it, a legend below.
        table: The study.
        drawn: Its map over two numbers.
    """
    durations = np.ma.masked_invalid(drawn.of_best(table.duration))
    x, y = drawn.axes
    if durations.count():
        low, high = duration_ends(table)
        mesh = axes.pcolormesh(x.edges, y.edges, durations, cmap=FASTER, vmin=low, vmax=high)
        figure = axes.get_figure()
        assert figure is not None  # noqa: S101 (axes that are drawn into belong to a figure)
        beyond = "max" if float(np.max(durations)) > high else "neither"
        figure.colorbar(mesh, ax=axes, label="shortest duration [s]", extend=beyond)
        if drawn.exact and min(x.count, y.count) >= CONTOURS and high > low:
            levels = np.linspace(low, high, CONTOURS + 2)[1:-1]
            near = np.ma.masked_greater(durations, high)  # far longer ones beside them would draw an edge as contours
            lines = axes.contour(x.middles, y.middles, near, levels=levels, colors="white", linewidths=0.8)
            axes.clabel(lines, fmt="%.3g s", fontsize="x-small")
    _draw_without(axes, table, drawn)
    _finish_map(axes, table, drawn)


def draw_limit_map(axes: Axes, table: StudyTable, drawn: StudyMap) -> None:
    """Which limit binds at c²⁺ of the best variant in every cell over two numbers.

    Args:
        axes: Where to draw; the legend stands below.
        table: The study.
        drawn: Its map over two numbers.
    """
    for where, name, colour in _limits(table, drawn):
        _fill(axes, drawn, where, name, color=colour, linewidth=0.2)
    _draw_without(axes, table, drawn)
    _finish_map(axes, table, drawn)


def draw_study_line(axes: Axes, table: StudyTable, drawn: StudyMap) -> None:
    """Duration of the best variant over one number, with what binds as bands; cells without one are hatched.

    Args:
        axes: Where to draw; the legend stands below.
        table: The study.
        drawn: Its map over one number.
    """
    cells, marked = drawn.axes[0], "o" if drawn.axes[0].count <= MOST_POINTS else ""
    axes.plot(cells.middles, drawn.of_best(table.duration), color="black", marker=marked, markersize=3)
    for where, name, colour in _limits(table, drawn):
        _bands(axes, cells, where, name, color=colour, alpha=BAND, linewidth=0)
    for code, count in table.outcome.counts(np.ones(table.variants, dtype=bool)):
        name = table.outcome.names[code]
        if count and name in HATCHES:
            _bands(axes, cells, drawn.outcome == code, name, hatch=HATCHES[name], **WITHOUT)
    if len(table.ranked):
        best = table.ranked[0]
        axes.plot(table.values[best, cells.knob], table.duration[best], **BEST)
        if spreads_widely(table):
            axes.set_yscale("log")
    finish(axes, plain(table.knobs[cells.knob].title), "shortest duration [s]")
    axes.set_xlim(cells.edges[0], cells.edges[-1])
    legend_below(axes, 1)


def study_map_figure(table: StudyTable) -> NotebookFigure:
    """The map over both numbers of a study, or the two that matter most; the line over its only one.

    Args:
        table: The study, with at least one variant and one number.
    """
    drawn = study_map(table)
    kinds = len(map_binding(table, drawn).names) + len(set(drawn.outcome[drawn.outcome >= 0]))
    height = 4.8 + LEGEND_INCHES * (kinds + 1)
    title = study_title(table, map_remark(table, drawn))
    if len(drawn.axes) == 1:
        figure = NotebookFigure(figsize=(8.0, height), layout="constrained")
        draw_study_line(figure.subplots(), table, drawn)
    else:
        figure = NotebookFigure(figsize=(12.0, height), layout="constrained")
        left, right = figure.subplots(1, 2)
        draw_study_map(left, table, drawn)
        left.set_title("shortest duration", fontsize="medium")
        draw_limit_map(right, table, drawn)
        right.set_title("what limits it", fontsize="medium")
    figure.suptitle(title, fontsize="small", x=0.01, ha="left")
    return figure


def study_title(table: StudyTable, *remarks: str) -> str:
    """What was found, the best, and what a figure shows, a line each.

    Args:
        table: The study.
        *remarks: What the figure shows; empty ones are left out.
    """
    lines = [f"{table.name}: {outcome_text(table)}", best_text(table), *(remark for remark in remarks if remark)]
    return plain_text("\n".join(textwrap.fill(line, TITLE_LETTERS, subsequent_indent="    ") for line in lines))


def _limits(table: StudyTable, drawn: StudyMap) -> Iterator[tuple[NDArray[np.bool_], str, str]]:
    """Where each limit binds, its name and its colour."""
    binding = map_binding(table, drawn)
    for code, (name, colour) in enumerate(zip(binding.names, LIMIT_COLOURS, strict=False)):
        yield binding.codes == code, plain(name), colour


def _draw_without(axes: Axes, table: StudyTable, drawn: StudyMap) -> None:
    for name, hatch in HATCHES.items():
        _fill(axes, drawn, drawn.outcome == table.outcome.names.index(name), name, hatch=hatch, **WITHOUT)


def _fill(axes: Axes, drawn: StudyMap, where: NDArray[np.bool_], label: str, **look: Any) -> None:
    """Fill cells of a map over two numbers; nothing is drawn, or named, where there are none."""
    x, y = (cells.edges for cells in drawn.axes)
    row, column = np.nonzero(where)
    if len(row):
        left, right, low, high = x[column], x[column + 1], y[row], y[row + 1]
        corners = np.stack([left, low, right, low, right, high, left, high], axis=1).reshape(-1, 4, 2)
        axes.add_collection(PolyCollection(list(corners), label=label, **look))


def _bands(axes: Axes, cells: Cells, where: NDArray[np.bool_], label: str, **look: Any) -> None:
    """Fill cells over one number from bottom to top; neighbours as one."""
    steps = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(int))).reshape(-1, 2)
    for number, (first, last) in enumerate(steps):
        axes.axvspan(cells.edges[first], cells.edges[last], label="" if number else label, **look)


def _finish_map(axes: Axes, table: StudyTable, drawn: StudyMap) -> None:
    """The best, labels and legend."""
    x, y = drawn.axes
    if len(table.ranked):
        best = table.ranked[0]
        axes.plot(table.values[best, x.knob], table.values[best, y.knob], **BEST)
    axes.set_xlim(x.edges[0], x.edges[-1])
    axes.set_ylim(y.edges[0], y.edges[-1])
    axes.set_xlabel(plain(table.knobs[x.knob].title))
    axes.set_ylabel(plain(table.knobs[y.knob].title))
    legend_below(axes, 1)
