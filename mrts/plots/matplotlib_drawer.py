# SPDX-License-Identifier: MIT
"""Draws plots as figures of matplotlib, and writes them."""

import textwrap
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mrts.base.atomic_file import Write, write_atomically, write_together
from mrts.base.errors import InputError, as_path, check_type, printable
from mrts.plots import FIGURE_FORMATS
from mrts.plots.plot import LONGEST_LABEL, Item, Line, Panel, Plot, Points, shortened

DASHES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)), (0, (7, 3)))
"""A second difference between lines, for print without colour."""

SYMBOLS = {"circle": "o", "dot": ".", "cross": "x", "star": "*"}
SIZES = {"circle": 6.0, "dot": 2.0, "cross": 6.0, "star": 13.0}

DPI = 150
NOTEBOOK_DPI = 96

ALONE_WIDTH, COLUMN_WIDTH = 9.0, 5.5
"""Of the only column of panels, and of one of several, legends included [in]."""

PANEL_INCHES, ALONE_INCHES = 2.4, 3.6
"""Height of a panel, and of the only one."""

NAME_INCHES, LABEL_INCHES = 0.21, 0.6
"""Height of a row of names, and of what stands below and above a panel."""

NARROW_LABEL = 36
"""Letters of the name of an axis, where panels stand beside each other."""

BEHIND_TEXT = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}


def matplotlib_figure(plot: Plot) -> Figure:
    """The plot as a figure of matplotlib, to be changed before it is written or shown."""
    columns = max(map(len, plot.rows))
    width = max(ALONE_WIDTH, COLUMN_WIDTH * columns)
    figure = Figure(layout="constrained")
    title = [textwrap.fill(line, int(15 * width), subsequent_indent="    ") for line in plot.title.splitlines()]
    figure.suptitle(_plain("\n".join(title)), fontsize="small", x=0.01, ha="left")
    grid = figure.subplots(len(plot.rows), columns, squeeze=False, sharex="col" if plot.shared else False)
    alone, heights = len(plot.rows) == 1 and columns <= 2, []  # noqa: PLR2004 (side by side)
    for number, row in enumerate(plot.rows):
        labelled = number == len(plot.rows) - 1 or not plot.shared
        for axes, panel in zip(grid[number], row, strict=False):
            _draw(axes, panel, NARROW_LABEL if columns > 1 else LONGEST_LABEL, labelled=labelled)
            if panel.title and panel.title != plot.title:
                axes.set_title(_plain(panel.title), loc="left", fontsize="small")
            if axes.get_legend_handles_labels()[1]:
                axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="small", frameon=False)
        for axes in grid[number][len(row) :]:
            axes.set_axis_off()
        heights.append(max(_inches(panel, alone=alone) for panel in row))
    grid[0, 0].get_gridspec().set_height_ratios(heights)
    figure.set_size_inches(width, sum(heights) + LABEL_INCHES * len(heights) + 0.2 * "\n".join(title).count("\n") + 0.3)
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


def write_plots(plots: Sequence[Plot], folder: Path | str, form: str = "png") -> None:
    """Write plots into a folder, all or none, each into a file of its name: "png", "svg" or "pdf".

    Raises:
        InputError: If there is no such format, or a file cannot be written.
    """
    check_type("plots", plots, list, tuple)
    for plot in plots:
        check_type("plots", plot, Plot)
    check_type("form", form, str)
    if form not in FIGURE_FORMATS:
        raise InputError("form", f"figures are written as one of {', '.join(FIGURE_FORMATS)}.", value=form)
    folder = as_path("folder", folder)
    write_together({folder / f"{plot.name}.{form}": figure_writer(plot) for plot in plots})


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


def _draw(axes: Axes, panel: Panel, longest: int, *, labelled: bool) -> None:
    axes.margins(x=0)
    axes.set(xlabel=_label(panel.x.label, longest) if labelled else "", ylabel=_label(panel.y.label, longest))
    for name, axis in (("xlim", panel.x), ("ylim", panel.y)):
        if axis.ends:  # else they follow what is drawn
            axes.set(**{name: axis.ends})
    for item in panel.items:
        _add(axes, item)
    if panel.y.names:
        labels = [_label(name) for name in panel.y.names]
        ticks = axes.set_yticks(range(len(labels)), labels, fontsize="small")
        for tick, color, strong in zip(ticks, panel.y.colors, panel.y.strong, strict=True):
            tick.label1.set(color=color, fontweight="bold" if strong else "normal")
    if panel.note:
        axes.text(0.5, 0.5, _plain(panel.note), transform=axes.transAxes, ha="center", va="center")
    axes.grid(visible=True, alpha=0.3, axis="x" if panel.y.names else "both")
    axes.set_axisbelow(True)


def _add(axes: Axes, item: Item) -> None:
    if isinstance(item, Line):
        _add_line(axes, item)
    elif isinstance(item, Points):
        _add_points(axes, item)
    else:
        look: dict[str, Any] = {"color": item.color, "alpha": item.opacity, "label": _label(item.label) or "_"}
        axes.fill_between(item.x, item.lower, item.upper, linewidth=0, **look)


def _add_line(axes: Axes, line: Line) -> None:
    style: dict[str, Any] = {"color": line.color, "linestyle": DASHES[line.dash % len(DASHES)]}
    finite = np.where(np.isfinite(line.y), line.y, np.nan)
    drawstyle, label = "steps-post" if line.steps else "default", _label(line.label) or "_"
    axes.plot(line.x, finite, label=label, linewidth=line.width, drawstyle=drawstyle, **style)
    for limit in line.limits:
        axes.plot(line.x, limit, linewidth=0.7, alpha=0.8, **style)


def _add_points(axes: Axes, points: Points) -> None:
    (marks,) = axes.plot(points.x, points.y, SYMBOLS[points.symbol], color=points.color, zorder=5)
    marks.set(markersize=SIZES[points.symbol], label=_label(points.label) or "_", clip_on=points.symbol == "dot")
    if points.symbol == "star":
        marks.set_markeredgecolor("black")
    low, high = axes.get_xlim()
    for x, y, text in zip(points.x, points.y, points.texts, strict=False):
        right = x > (low + high) / 2
        axes.annotate(
            _plain(text), (x, y), xytext=(-8 if right else 8, -12 if points.below else 10), textcoords="offset points",
            ha="right" if right else "left", va="center", fontsize="small", bbox=BEHIND_TEXT, zorder=6,
        )  # fmt: skip
