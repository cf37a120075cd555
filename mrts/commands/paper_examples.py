# SPDX-License-Identifier: MIT
"""`mrts demo`: the examples of the paper's section VI, beside the paper's own numbers."""

from importlib.resources import as_file, files
from math import nan
from pathlib import Path
from typing import Literal

from mrts.base.atomic_file import Write, text_writer, write_together
from mrts.base.errors import Progress
from mrts.base.formats.record import Record
from mrts.base.input_file import read_data
from mrts.cell.cell import Cell, load_cell
from mrts.limits.rows import row_labels
from mrts.motion.motion_file import load_motion
from mrts.program.load_sharing import LoadSharing
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.scaling.scale import ScalingResult, scale

NO_EXAMPLE = ("identified_cell.yaml",)
"""Files of the folders of examples that are part of the paper's comparison alone."""

NOTE = """\
The deviations are not tuned away. The paper leaves the size of the object, the direction of the last link and the
signs of the elbows unstated; docs/paper.md says how each is read here and why 6.4, whose worst load is
the one of 3 kg, is furthest off.
Exact in any reading, and exact here: 6.2 / 6.1 (b) = (6/20)², lower ends 0, limits reached at t = 0,
free > limited > even."""


class PaperCase(Record):
    """One example of section VI."""

    id: str
    title: str
    motion: str
    wrench_limits: bool = True
    even: bool = False
    postures: dict[str, list[float]] = {}  # noqa: RUF012 (each record has its own copy)
    mass: list[float] | None = None
    paper: float
    figure: int | None = None


Row = tuple[PaperCase, ScalingResult]


def largest_c2(result: ScalingResult) -> float:
    """c²⁺, nan where no speed is admissible."""
    return result.range.upper.c2 if result.range.upper else nan


def run_demo(
    solver: str = DEFAULT_SOLVER,
    progress: Progress = lambda _done, _total: None,
    cell: Literal["cell", "identified_cell"] = "cell",
) -> list[Row]:
    """Scale every example of section VI, with the shipped cell or the one identified from the paper's values."""
    with as_file(files("mrts") / "data") as data:
        given = read_data(data / "paper_section_6.yaml", "case file")
        shipped, rows = load_cell(data / given[cell]), []
        for number, keys in enumerate(given["cases"]):
            progress(number, len(given["cases"]))
            case = PaperCase(**keys)
            sharing = LoadSharing() if case.even else None
            motion = load_motion(data / case.motion)
            rows.append((case, scale(_variant(shipped, case), motion, sharing=sharing, solver=solver, between=None)))
        return rows


def _variant(cell: Cell, case: PaperCase) -> Cell:
    cell = cell.with_postures(case.postures)
    if case.mass is not None:
        least, largest = case.mass
        cell = cell.with_variation(mass=(least / cell.mass, largest / cell.mass))
    return cell if case.wrench_limits else cell.without_wrench_limits()


def format_table(rows: list[Row]) -> str:
    """The demo's table as text; ↑ and ↓ tell whether the upper or the lower limit binds."""
    head = f"{'case':<9} {'':<24} {'paper c²⁺':>9} {'mrts c²⁺':>9} {'deviation':>9} {'time':>8}"
    head += "  limited by (↑ upper, ↓ lower limit)"
    lines = [head, "-" * len(head)]
    for case, result in rows:
        end, c2 = result.range.upper, largest_c2(result)
        time = f"{result.trajectory.duration:.4f} s" if result.trajectory else "-"
        where = f"t = {end.time:.3g} s: {row_labels(end.rows, len(end.rows))}" if end else "-"
        lines.append(
            f"{case.id:<9} {case.title:<24} {case.paper:>9.3f} {c2:>#9.4g} {100 * (c2 / case.paper - 1):>+8.1f}% "
            f"{time:>8}  {where}"
        )
    return "\n".join(lines)


def write_demo_files(folder: Path, rows: list[Row]) -> bool:
    """Write the figures 4 to 8, the one of the uncertain load, and the files of every example cell to start from.

    Returns:
        Whether there are figures: they need the extra 'plot'.

    Raises:
        InputError: If the folder cannot be written.
    """
    writers = {}
    with as_file(files("mrts") / "data") as data:
        for path in sorted(data.glob("*/*")):
            if path.suffix in {".yaml", ".urdf"} and path.name not in NO_EXAMPLE:
                writers[folder / path.relative_to(data)] = text_writer(path.read_text("utf-8"))
    figures = _figure_writers(rows)
    write_together(writers | {folder / name: write for name, write in figures.items()})
    return bool(figures)


def _figure_writers(rows: list[Row]) -> dict[str, Write]:
    try:
        from mrts.plots import load_plot, trajectory_plot
        from mrts.plots.matplotlib_drawer import figure_writer
    except ImportError:
        return {}
    writers = {}
    for case, result in rows:
        if case.figure is not None:
            title = f"Figure {case.figure}: {case.id}, {case.title}, c² = {largest_c2(result):#.4g}"
            writers[f"figure_{case.figure}.png"] = figure_writer(trajectory_plot(result, title))
        if result.load is not None:
            answers = {name: scale(result.cell, result.motion, load=name, between=None)
                       for name in ("possible", "nominal")}  # fmt: skip
            answers["guaranteed"] = result
            writers["uncertain_load.png"] = figure_writer(load_plot(answers))
    return writers
