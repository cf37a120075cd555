# SPDX-License-Identifier: MIT
"""What all figures share: colours, dashes, labels, legends outside the curves, writing."""

import re
from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

from mrts.base.argument_types import as_path, check_type
from mrts.base.atomic_file import Write, write_atomically, write_together
from mrts.base.errors import InputError
from mrts.base.formats.figure_formats import FIGURE_FORMATS
from mrts.base.printable import printable
from mrts.drawing.colours import COLOURS
from mrts.drawing.labels import LONGEST_LABEL, shortened
from mrts.scaling.result import ScalingResult

DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)), (0, (7, 3)))
"""A second difference between lines, for print without colour."""

DPI = 150
NOTEBOOK_DPI = 96

LEGEND_DROP = 34.0
"""From the axes down to a legend below its tick and axis labels [pt]."""

TWO_COLUMNS = 16
"""Letters up to which labels stand in several columns."""

SIDE_BY_SIDE = 2
"""More robots than this stand below each other, to fit a page."""

Draw = Callable[[Axes, ScalingResult, str], None]
"""What draws something of one robot, by its name, into axes."""


class NotebookFigure(Figure):
    """A figure that a notebook shows by itself, without pyplot and its backends."""

    def _repr_png_(self) -> bytes:
        drawn = BytesIO()
        self.savefig(drawn, format="png", dpi=NOTEBOOK_DPI)
        return drawn.getvalue()


def line_style(index: int) -> dict[str, Any]:
    """Colour and dashes of the line with this number."""
    turn = index // len(COLOURS)
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": DASHES[(index + turn) % len(DASHES)]}


def plain_text(text: str) -> str:
    """Printable text without a meaning for matplotlib, to which $ is mathematics."""
    return printable(text, lines=True).replace("$", r"\$")


def plain(name: str, longest: int = LONGEST_LABEL) -> str:
    """A name as a label: short enough, and not hidden from the legend by a first _."""
    name = shortened(name, longest)
    return plain_text(f" {name}" if name.startswith("_") else name)


def in_lines(text: str, longest: int) -> str:
    """Text in lines; a path or a name breaks after its dots and slashes too, and no line begins with an arrow.

    Args:
        text: Any.
        longest: Letters of a line, which a longer word exceeds.
    """
    lines = [""]
    for piece in re.split(r"(?<=[./])(?=[^\W\d])|(?<= )(?![↑↓])", text):
        if lines[-1] and len(lines[-1]) + len(piece.rstrip()) > longest:
            lines.append("")
        lines[-1] += piece
    return "\n".join(line.rstrip() for line in lines)


def legend_below(axes: Axes, columns: int | None = None) -> None:
    """A legend under the axes, where it hides no curve."""
    handles, labels = axes.get_legend_handles_labels()
    if not labels:
        return
    longest = max(len(label) for label in labels)
    if columns is None:
        columns = min(len(labels), 3) if longest <= TWO_COLUMNS else 1
    figure = axes.get_figure()
    assert figure is not None  # noqa: S101 (axes that are drawn into belong to a figure)
    drop = ScaledTranslation(0, -LEGEND_DROP / 72, figure.dpi_scale_trans)
    axes.legend(
        handles,
        labels,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=axes.transAxes + drop,
        fontsize="small",
        ncols=columns,
        frameon=False,
        borderaxespad=0,
    )


def robot_figure(result: ScalingResult, title: str, draws: Sequence[Draw]) -> NotebookFigure:
    """Several quantities of every robot with their limits: a column a robot, or a row where there are many.

    Args:
        result: A result with a trajectory.
        title: Title of the figure.
        draws: What draws them.
    """
    robots = [robot.name for robot in result.cell.robots]
    count, kinds = len(robots), len(draws)
    if count <= SIDE_BY_SIDE:
        figure = NotebookFigure(figsize=(max(6.0, 4.4 * count), 0.5 + 2.7 * kinds), layout="constrained")
        grid = figure.subplots(kinds, count, squeeze=False)
    else:
        figure = NotebookFigure(figsize=(0.2 + 3.6 * kinds, 3.1 * count + 0.6), layout="constrained")
        grid = figure.subplots(count, kinds, squeeze=False).T
    figure.suptitle(plain_text(f"{title}\n(thin lines: limits)"), fontsize="medium")
    for column, robot in enumerate(robots):
        for axes, draw in zip(grid[:, column], draws, strict=True):
            draw(axes, result, robot)
        grid[0, column].set_title(f"robot '{plain(robot)}'", fontsize="medium")
    for quantity in grid if count <= SIDE_BY_SIDE else ():
        reaches = np.array([axes.get_ylim() for axes in quantity])
        for axes in quantity:
            axes.set_ylim(np.min(reaches[:, 0]), np.max(reaches[:, 1]))
    return figure


def finish(axes: Axes, xlabel: str, ylabel: str) -> None:
    """Labels, grid, and no empty time before and after."""
    axes.set_xlabel(xlabel)
    axes.set_ylabel(ylabel)
    axes.grid(visible=True, alpha=0.3)
    axes.margins(x=0)


def write_figure(figure: Figure, path: Path | str) -> None:
    """Write a figure, whole or not at all; the file name's ending chooses the format.

    Raises:
        InputError: If it cannot be written, or there is no such format.
    """
    check_type("figure", figure, Figure)
    path = as_path("path", path)
    formats = figure.canvas.get_supported_filetypes()
    if path.suffix[1:].lower() not in formats:
        raise InputError(path, f"the ending chooses a figure's format; there are {', '.join(sorted(formats))}.")
    write_atomically(path, figure_writer(figure))


def figure_writer(figure: Figure) -> Write:
    """What writes a figure; the file name's ending chooses the format."""

    def write(path: Path) -> None:
        undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(path.suffix[1:].lower())
        with mpl.rc_context({"svg.hashsalt": "mrts"}):  # else every file of one figure has other identifiers
            figure.savefig(path, dpi=DPI, metadata=undated)

    return write


def check_form(form: str) -> None:
    """Check the format of figures before they are drawn.

    Args:
        form: What was asked for.

    Raises:
        InputError: If there is no such format.
    """
    check_type("form", form, str)
    if form not in FIGURE_FORMATS:
        raise InputError("form", f"figures are written as one of {', '.join(FIGURE_FORMATS)}.", value=form)


def write_figures(figures: Mapping[str, Figure], folder: Path, form: str) -> None:
    """Write figures into a folder, all or none.

    Args:
        figures: By the file's name without its ending.
        folder: Made if missing.
        form: One of `FIGURE_FORMATS`.

    Raises:
        InputError: If a file cannot be written.
    """
    write_together({folder / f"{name}.{form}": figure_writer(figure) for name, figure in figures.items()})
