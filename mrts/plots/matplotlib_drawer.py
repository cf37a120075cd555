# SPDX-License-Identifier: MIT
"""Draws plots as figures of matplotlib, and writes them."""

import textwrap
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

from mrts.base.argument_types import as_path, check_type
from mrts.base.atomic_file import Write, write_atomically
from mrts.base.errors import InputError
from mrts.base.printable import printable
from mrts.plots.labels import LONGEST_LABEL, shortened
from mrts.plots.plot import Axis, Band, Bars, HeatMap, Item, Line, Panel, Plot, Points, Rule

DASHES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)), (0, (7, 3)))
"""A second difference between lines, for print without colour."""

SYMBOLS = {"circle": "o", "dot": ".", "cross": "x", "star": "*", "up": "^"}
SIZES = {"circle": 6.0, "dot": 2.0, "cross": 6.0, "star": 13.0, "up": 5.0}

DPI = 150
NOTEBOOK_DPI = 96

WIDTHS = {1: 8.0, 2: 9.4}
"""Of a figure with so many columns [in]; of more, 3.6 in each."""

PANEL_INCHES, ALONE_INCHES = 2.4, 3.6
"""Height of a panel, and of the only one."""

NAME_INCHES, LEGEND_INCHES, LABEL_INCHES = 0.21, 0.2, 0.6
"""Height of a row of names, of a line of a legend, and of what stands below and above a panel."""

LETTER_INCHES = 0.075
NARROW_LABEL = 36
"""Letters of the name of an axis, where panels stand beside each other."""

NAME_LETTERS = 72
"""Of a name beside a row, which makes the figure wider beyond `LONGEST_LABEL`."""

LEGEND_DROP, SHARED_DROP = 34.0, 8.0
"""From the axes down to a legend below tick and axis labels, and without these [pt]."""


def matplotlib_figure(plot: Plot) -> Figure:
    """The plot as a figure of matplotlib, to be changed before it is written or shown."""
    columns = max(map(len, plot.rows))
    legends = [max(_legend_lines(panel, columns) for panel in row) for row in plot.rows]
    alone = len(plot.rows) == 1 and columns <= 2  # noqa: PLR2004 (side by side)
    heights = [
        max(_inches(panel, alone=alone) for panel in row) + lines * LEGEND_INCHES
        for row, lines in zip(plot.rows, legends, strict=True)
    ]
    longest = max((len(name) for row in plot.rows for name in row[0].y.names), default=0)
    wide = LETTER_INCHES * max(min(longest, NAME_LETTERS) - LONGEST_LABEL, 0)
    width = WIDTHS.get(columns, 3.6 * columns) + wide
    title = [textwrap.fill(line, int(13 * width), subsequent_indent="    ") for line in plot.title.splitlines()]
    height = sum(heights) + LABEL_INCHES * len(heights) + 0.2 * "\n".join(title).count("\n") + 0.3
    figure = Figure(figsize=(width, height), layout="constrained")
    figure.suptitle(_plain("\n".join(title)), fontsize="small", x=0.01, ha="left")
    grid = figure.subplots(
        len(plot.rows), columns, squeeze=False, sharex="col" if plot.shared else False, height_ratios=heights
    )
    for number, row in enumerate(plot.rows):
        below = number == len(plot.rows) - 1
        for axes, panel in zip(grid[number], row, strict=False):
            _draw(axes, panel, columns, labelled=below or not plot.shared, headed=panel.title != plot.title)
        for axes in grid[number][len(row) :]:
            axes.set_axis_off()
    return figure


def png(plot: Plot) -> bytes:
    """The plot as a picture for a notebook."""
    drawn = BytesIO()
    matplotlib_figure(plot).savefig(drawn, format="png", dpi=NOTEBOOK_DPI)
    return drawn.getvalue()


def write_plot(plot: Plot, path: Path | str) -> None:
    """Write a plot, whole or not at all; the file name's ending chooses the format.

    Raises:
        InputError: If it cannot be written, or there is no such format.
    """
    check_type("plot", plot, Plot)
    path, formats = as_path("path", path), Figure().canvas.get_supported_filetypes()
    if path.suffix[1:].lower() not in formats:
        raise InputError(path, f"the ending chooses a figure's format; there are {', '.join(sorted(formats))}.")
    write_atomically(path, figure_writer(plot))


def figure_writer(plot: Plot) -> Write:
    """What writes a plot; the file name's ending chooses the format."""

    def write(path: Path) -> None:
        undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(path.suffix[1:].lower())
        with mpl.rc_context({"svg.hashsalt": "mrts"}):  # else every file of one figure has other identifiers
            matplotlib_figure(plot).savefig(path, dpi=DPI, metadata=undated)

    return write


def _inches(panel: Panel, *, alone: bool) -> float:
    if panel.y.names:
        return NAME_INCHES * len(panel.y.names) + 0.2
    return ALONE_INCHES if alone else PANEL_INCHES


def _plain(text: str) -> str:
    """Printable text without a meaning for matplotlib, to which $ is mathematics."""
    return printable(text, lines=True).replace("$", r"\$")


def _label(name: str, longest: int = LONGEST_LABEL) -> str:
    """A name short enough, and not hidden from the legend by a first _."""
    name = shortened(name, longest)
    return _plain(f" {name}" if name.startswith("_") else name)


def _legend_names(panel: Panel) -> list[str]:
    names: list[str] = []
    for item in panel.items:
        names += [item.names[code] for code in item.found] if isinstance(item, HeatMap) else [item.label]
    return list(filter(None, names)) + (["goes on above"] if panel.cuts() is not None else [])


def _legend_columns(panel: Panel, columns: int) -> int:
    longest = max((len(_label(name)) for name in _legend_names(panel)), default=0)
    return max(1, int(WIDTHS.get(columns, 3.6 * columns) / columns / (LETTER_INCHES * longest + 0.65)))


def _legend_lines(panel: Panel, columns: int) -> int:
    return -(-len(_legend_names(panel)) // _legend_columns(panel, columns))


def _draw(axes: Axes, panel: Panel, columns: int, *, labelled: bool, headed: bool) -> None:
    _scale(axes, panel)
    for item in panel.items:
        _add(axes, item)
    cuts = panel.cuts()
    if cuts is not None:
        _add(axes, cuts)
    if panel.note:
        axes.text(0.5, 0.5, _plain(panel.note), transform=axes.transAxes, ha="center", va="center")
    if headed and panel.title:
        axes.set_title(_plain(panel.title), loc="left", fontsize="small")
    longest = LONGEST_LABEL if columns == 1 else NARROW_LABEL
    axes.set_xlabel(_label(panel.x.label, longest) if labelled else "")
    axes.set_ylabel(_label(panel.y.label, longest))
    if not any(isinstance(item, HeatMap) for item in panel.items):
        axes.grid(visible=True, alpha=0.3, axis="x" if panel.y.names else "both")
    axes.set_axisbelow(True)
    handles, labels = axes.get_legend_handles_labels()
    if labels:
        drop = ScaledTranslation(0, -(LEGEND_DROP if labelled else SHARED_DROP) / 72, axes.figure.dpi_scale_trans)
        axes.legend(
            handles,
            labels,
            loc="upper center",
            bbox_to_anchor=(0.5, 0.0),
            bbox_transform=axes.transAxes + drop,
            fontsize="small",
            ncols=_legend_columns(panel, columns),
            frameon=False,
            borderaxespad=0,
        )


def _scale(axes: Axes, panel: Panel) -> None:
    axes.margins(x=0)
    for axis, set_scale, set_ends in (
        (panel.x, axes.set_xscale, axes.set_xlim),
        (panel.y, axes.set_yscale, axes.set_ylim),
    ):
        if axis.log:
            set_scale("log")
        if axis.ends is not None:
            set_ends(*axis.ends)
    if panel.y.names:
        _name_rows(axes, panel.y)


def _name_rows(axes: Axes, axis: Axis) -> None:
    rows = range(len(axis.names))
    axes.set_yticks(rows, [_label(name, NAME_LETTERS) for name in axis.names], fontsize="small")
    for tick, color in zip(axes.get_yticklabels(), axis.colors, strict=False):
        tick.set_color(color)
    for tick, strong in zip(axes.get_yticklabels(), axis.strong, strict=False):
        tick.set_fontweight("bold" if strong else "normal")
    axes.set_ylim(len(rows) - 0.4, -0.6)


def _add(axes: Axes, item: Item) -> None:
    if isinstance(item, Line):
        _add_line(axes, item)
    elif isinstance(item, Points):
        _add_points(axes, item)
    elif isinstance(item, Band):
        color, label = item.color, _label(item.label)
        axes.fill_between(
            item.x, item.lower, item.upper, color=color, alpha=item.opacity, linewidth=0, label=label or "_"
        )
    elif isinstance(item, Rule):
        draw = axes.axvline if item.upright else axes.axhline
        draw(item.at, color=item.color, linestyle=DASHES[item.dash], linewidth=1, label=_label(item.label) or "_")
    elif isinstance(item, Bars):
        _add_bars(axes, item)
    elif item.names:
        _add_named_cells(axes, item)
    else:
        _add_heat_map(axes, item)


def _add_line(axes: Axes, line: Line) -> None:
    style: dict[str, Any] = {"color": line.color, "linestyle": DASHES[line.dash % len(DASHES)]}
    course = "steps-post" if line.steps else "default"
    finite = np.where(np.isfinite(line.y), line.y, np.nan)
    label = _label(line.label) or "_"
    axes.plot(line.x, finite, label=label, linewidth=line.width, drawstyle=course, **style)
    for limit in line.limits:
        if np.all(limit == limit[0]):
            axes.axhline(limit[0], linewidth=0.7, alpha=0.8, **style)
        else:
            axes.plot(line.x, limit, linewidth=0.7, alpha=0.8, **style)


def _add_points(axes: Axes, points: Points) -> None:
    edge: dict[str, Any] = {"markeredgecolor": "black"} if points.symbol == "star" else {}
    axes.plot(
        points.x,
        points.y,
        SYMBOLS[points.symbol],
        color=points.color,
        markersize=SIZES[points.symbol],
        label=_label(points.label) or "_",
        clip_on=points.symbol == "dot",
        zorder=5,
        **edge,
    )
    low, high = axes.get_xlim()
    for x, y, text in zip(points.x, points.y, points.texts, strict=False):
        right = x > (low + high) / 2
        axes.annotate(
            _plain(text),
            (x, y),
            xytext=(-8 if right else 8, -12 if points.below else 10),
            textcoords="offset points",
            ha="right" if right else "left",
            va="center",
            fontsize="small",
            bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75},
            zorder=6,
        )


def _add_bars(axes: Axes, bars: Bars) -> None:
    look: dict[str, Any] = {"color": bars.color, "label": _label(bars.label) or "_"}
    if bars.upright:
        axes.bar(bars.place, bars.end - bars.start, bars.thickness, bars.start, **look)
    else:
        axes.barh(bars.place, bars.end - bars.start, bars.thickness, bars.start, **look)


def _add_heat_map(axes: Axes, heat: HeatMap) -> None:
    values = np.ma.masked_invalid(heat.z)
    colors = LinearSegmentedColormap.from_list("mrts", list(heat.colors))
    mesh = axes.pcolormesh(heat.x, heat.y, values, cmap=colors, vmin=heat.low, vmax=heat.high)
    beyond = "max" if values.count() and float(np.max(values)) > heat.high else "neither"
    axes.figure.colorbar(mesh, ax=axes, label=_plain(heat.title), extend=beyond)


def _add_named_cells(axes: Axes, cells: HeatMap) -> None:
    for code in cells.found:
        row, column = np.nonzero(cells.z == code)
        left, right, low, high = cells.x[column], cells.x[column + 1], cells.y[row], cells.y[row + 1]
        corners = np.stack([left, low, right, low, right, high, left, high], axis=1).reshape(-1, 4, 2)
        color, label = cells.colors[code], _label(cells.names[code])
        axes.add_collection(PolyCollection(list(corners), label=label, facecolor=color, edgecolor=color, linewidth=0.2))
