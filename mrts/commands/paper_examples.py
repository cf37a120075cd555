# SPDX-License-Identifier: MIT
"""`mrts demo`: the examples of the paper's section VI, beside the paper's own numbers."""

from dataclasses import dataclass
from importlib.resources import as_file, files
from math import nan
from pathlib import Path

from mrts.base.argument_types import Progress
from mrts.base.atomic_file import Write, text_writer, write_together
from mrts.base.formats.record import Record
from mrts.base.input_file import read_data
from mrts.cell.cell import Cell, load_cell
from mrts.limits.rows import row_labels
from mrts.motion.motion_file import load_motion
from mrts.program.load_sharing import LoadSharing
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.scaling.result import ScalingResult
from mrts.scaling.scale import scale

NO_EXAMPLE = ("identified_cell.yaml",)
"""Files of the folders of examples that are part of the paper's comparison alone."""

NOTE = """\
The deviations are not tuned away. The paper leaves the size of the object, the direction of the last link and the
signs of the elbows unstated; docs/paper.md says how each is read here and why 6.4, whose worst load is
the one of 3 kg, is furthest off.
Exact in any reading, and exact here: 6.2 / 6.1 (b) = (6/20)², lower ends 0, limits reached at t = 0,
free > limited > even.
The column "identified" is not a prediction: its cell has the half-width, contact height and direction of the last link
that fit these seven values best (three numbers fitted to six independent ones; found by
benchmarks/paper/paper_identification.py)."""


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


@dataclass(frozen=True)
class DemoRow:
    """One line of the demo's table.

    Attributes:
        case: The example.
        result: Of the shipped cell.
        c2: c²⁺ of it.
        identified_c2: c²⁺ of the cell whose contacts were identified from the paper's values.
    """

    case: PaperCase
    result: ScalingResult
    c2: float
    identified_c2: float

    @property
    def deviation(self) -> float:
        """Relative difference from the paper's c²⁺."""
        return self.c2 / self.case.paper - 1


def run_demo(solver: str = DEFAULT_SOLVER, progress: Progress = lambda _done, _total: None) -> list[DemoRow]:
    """Scale every example of section VI."""
    with as_file(files("mrts") / "data") as data:
        given = read_data(data / "paper_section_6.yaml", "case file")
        cells = [load_cell(data / given[name]) for name in ("cell", "identified_cell")]
        cases, rows = [PaperCase(**case) for case in given["cases"]], []
        for number, case in enumerate(cases):
            progress(number, len(cases))
            sharing = LoadSharing() if case.even else None
            motion = load_motion(data / case.motion)
            shipped, identified = (
                scale(_variant(cell, case), motion, sharing=sharing, solver=solver, between=None) for cell in cells
            )
            c2, identified_c2 = (each.range.upper.c2 if each.range.upper else nan for each in (shipped, identified))
            rows.append(DemoRow(case, shipped, c2, identified_c2))
        return rows


def _variant(cell: Cell, case: PaperCase) -> Cell:
    cell = cell.with_postures(case.postures)
    if case.mass is not None:
        least, largest = case.mass
        cell = cell.with_variation(mass=(least / cell.mass, largest / cell.mass))
    return cell if case.wrench_limits else cell.without_wrench_limits()


def format_table(rows: list[DemoRow]) -> str:
    """The demo's table as text; ↑ and ↓ tell whether the upper or the lower limit binds."""
    head = f"{'case':<9} {'':<24} {'paper c²⁺':>9} {'mrts c²⁺':>9} {'deviation':>9} {'identified':>10} {'time':>8}"
    head += "  limited by (↑ upper, ↓ lower limit)"
    lines = [head, "-" * len(head)]
    for row in rows:
        end = row.result.range.upper
        trajectory = row.result.trajectory
        time = f"{trajectory.duration:.4f} s" if trajectory else "-"
        where = f"t = {end.time:.3g} s: {row_labels(end.rows, len(end.rows))}" if end else "-"
        lines.append(
            f"{row.case.id:<9} {row.case.title:<24} {row.case.paper:>9.3f} {_four_digits(row.c2):>9} "
            f"{100 * row.deviation:>+8.1f}% {_four_digits(row.identified_c2):>10} {time:>8}  {where}"
        )
    return "\n".join(lines)


def _four_digits(value: float) -> str:
    return f"{value:#.4g}"


def write_demo_files(folder: Path, rows: list[DemoRow]) -> bool:
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


def _figure_writers(rows: list[DemoRow]) -> dict[str, Write]:
    try:
        from mrts.plots import load_plot, trajectory_plot
        from mrts.plots.matplotlib_drawer import figure_writer
    except ImportError:
        return {}
    writers = {}
    for row in rows:
        if row.case.figure is not None:
            title = f"Figure {row.case.figure}: {row.case.id}, {row.case.title}, c² = {_four_digits(row.c2)}"
            writers[f"figure_{row.case.figure}.png"] = figure_writer(trajectory_plot(row.result, title))
        if row.result.load is not None:
            cell, motion = row.result.cell, row.result.motion
            answers = {name: scale(cell, motion, load=name, between=None) for name in ("possible", "nominal")}
            answers["guaranteed"] = row.result
            writers["uncertain_load.png"] = figure_writer(load_plot(answers))
    return writers
