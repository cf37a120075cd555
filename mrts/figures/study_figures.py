# SPDX-License-Identifier: MIT
"""All figures of a study's folder, as files; how its durations spread, and its best variants as a table."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import StrMethodFormatter
from matplotlib.transforms import Bbox

from mrts.base.argument_types import as_path
from mrts.drawing.colours import COLOURS
from mrts.drawing.study_map import spreads_widely
from mrts.drawing.study_table import StudyTable, read_study_table
from mrts.drawing.study_words import SHARES, best_rows, managed, managed_texts
from mrts.figures.study_lines import parallel_coordinates_figure
from mrts.figures.study_maps import study_map_figure, study_title
from mrts.figures.style import NotebookFigure, check_form, finish, in_lines, plain_text, write_figures

FEWEST_BINS, MOST_BINS = 4, 60
"""Of a histogram: about the square root of the number of values."""

SAME = 0.01
"""Durations that differ by less than this share of them have one picture."""

MOST_COLUMNS = 5
"""Best variants in the table."""

CELL_LETTERS = 16
"""Of a line in a cell of the table."""


def draw_managed(axes: Axes, table: StudyTable) -> None:
    """Which share of all variants manages a duration.

    Args:
        axes: Where to draw; the legend stands above.
        table: The study, with a variant that has a duration.
    """
    durations = table.duration[table.ranked]
    percent = 100 * np.arange(1, len(durations) + 1) / table.variants
    axes.set_xscale("log" if spreads_widely(table) else "linear")
    axes.step(durations, percent, where="post", color=COLOURS[0], label="manage this duration")
    axes.axhline(percent[-1], color=COLOURS[1], linewidth=1, linestyle="--", label="can be played at all")
    for share in SHARES:
        duration = managed(table, share)
        if duration is not None:
            axes.plot(duration, share, "o", color=COLOURS[0], markersize=5)
            axes.annotate(f"{share} %: {duration:.4g} s", (duration, share), xytext=(6, -5),
                          textcoords="offset points", va="top", fontsize="small")  # fmt: skip
    finish(axes, "shortest duration [s]", "share of all variants [%]")
    axes.set_ylim(0, 104)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1.01), ncols=2, fontsize="small", frameon=False, borderaxespad=0)


def draw_durations(axes: Axes, table: StudyTable) -> None:
    """How the shortest durations spread.

    Args:
        axes: Where to draw.
        table: The study, with a variant that has a duration.
    """
    durations = table.duration[table.ranked]
    wide = spreads_widely(table)
    count = int(np.clip(np.sqrt(len(durations)), FEWEST_BINS, MOST_BINS))
    divided = np.geomspace if wide else np.linspace
    bins = divided(durations[0], max(durations[-1], durations[0] * (1 + SAME)), count + 1)
    axes.hist(durations, bins.tolist(), weights=np.full(len(durations), 100 / table.variants), color=COLOURS[5])
    finish(axes, "shortest duration [s]", "in each bin [%]")
    if wide:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.set_xlim(bins[0], bins[-1])


def durations_figure(table: StudyTable) -> NotebookFigure:
    """How the durations of a study spread, and which share of the variants manages which.

    Args:
        table: The study.
    """
    figure = NotebookFigure(figsize=(8.0, 5.6), layout="constrained")
    words = [] if not len(table.ranked) else managed_texts(table)
    figure.suptitle(study_title(table, "; ".join(words)), fontsize="small", x=0.01, ha="left")
    if not len(table.ranked):
        axes = figure.subplots()
        axes.text(0.5, 0.5, "no variant has a duration", transform=axes.transAxes, ha="center", va="center")
        axes.set_axis_off()
        return figure
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    draw_managed(above, table)
    above.set_xlabel("")
    draw_durations(below, table)
    return figure


def best_variants_figure(table: StudyTable) -> NotebookFigure:
    """The best variants as a table: what they have, reach, and are limited by.

    Args:
        table: The study, with a variant that has a duration.
    """
    head, rows = best_rows(table, MOST_COLUMNS)
    longest = [2 * CELL_LETTERS] + [CELL_LETTERS] * (len(head) - 1)
    cells = [[plain_text(in_lines(text, most)) for text, most in zip(row, longest, strict=True)] for row in rows]
    lines = [max(text.count("\n") + 1 for text in row) for row in cells]
    figure = NotebookFigure(figsize=(2.6 + 1.35 * (len(head) - 1), 0.9 + 0.22 * (sum(lines) + len(lines))))
    figure.suptitle(study_title(table), fontsize="small", x=0.01, ha="left", y=0.99, va="top")
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.99 - 0.55 / figure.get_figheight()))
    axes.set_axis_off()
    drawn = axes.table(cells, colLabels=head, cellLoc="left", colLoc="left", edges="horizontal", bbox=Bbox.unit(),
                       colWidths=[2.4, *[1.35] * (len(head) - 1)])  # fmt: skip
    drawn.auto_set_font_size(False)  # noqa: FBT003 (matplotlib's)
    drawn.set_fontsize(8)
    for (row, column), cell in drawn.get_celld().items():
        cell.set_height(lines[row - 1] + 0.6 if row else 1.6)
        cell.PAD = 0.02
        if not row or not column:
            cell.set_text_props(color="#555b63")
    return figure


def study_figures(table: StudyTable) -> dict[str, NotebookFigure]:
    """All figures that suit a study, by file name without its ending.

    Args:
        table: The study, with at least one variant.
    """
    figures = {"durations": durations_figure(table)}
    if table.knobs:
        figures["map" if len(table.knobs) > 1 else "line"] = study_map_figure(table)
    if len(table.knobs) > 2:  # noqa: PLR2004 (up to two, the map shows all)
        figures["parallel_coordinates"] = parallel_coordinates_figure(table)
    if len(table.ranked):
        figures["best_variants"] = best_variants_figure(table)
    return figures


def write_study_figures(study: StudyTable | Path | str, to: Path | str, form: str = "png") -> None:
    """Write the figures of what a sweep has found so far.

    Args:
        study: The table, or the folder of the study, as `mrts sweep -o` wrote it.
        to: Folder for the figures, made if missing; it gets all figures or none.
        form: "png", "svg" or "pdf".

    Raises:
        InputError: If there is no study, none of its variants is solved, there is no such format, or a file
            cannot be written.
    """
    check_form(form)
    table = study if isinstance(study, StudyTable) else read_study_table(as_path("study", study))
    write_figures(study_figures(table), as_path("to", to), form)
