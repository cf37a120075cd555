# SPDX-License-Identifier: MIT
"""Plots as files: all of a result, of a study, of an identification."""

from collections.abc import Iterable
from pathlib import Path

from mrts.base.argument_types import as_path, check_type
from mrts.base.atomic_file import write_together
from mrts.base.errors import InputError
from mrts.identification.identified_motors import MotorIdentification
from mrts.plots import FIGURE_FORMATS
from mrts.plots.card import answer_card
from mrts.plots.limit_plots import limits_plot
from mrts.plots.motor_plots import motor_plot
from mrts.plots.phase_plane import phase_plane_plot
from mrts.plots.plot import Plot
from mrts.plots.range_plots import load_study_plot, range_plot
from mrts.plots.reserve_plot import reserve_plot
from mrts.plots.simulation_plots import simulation_plot
from mrts.plots.study_plots import durations_plot, study_map_plot
from mrts.plots.study_table import StudyTable, read_study_table
from mrts.plots.trajectory_plots import power_plot, trajectory_plot
from mrts.scaling.result import ScalingResult
from mrts.simulation.reserve import ReserveSearch
from mrts.simulation.simulate import Simulation
from mrts.timing.result import RetimingResult


def result_plots(result: ScalingResult | RetimingResult) -> list[Plot]:
    """All plots of a result; without a profile, those of the best constant factor.

    A retimed motion has no range of c² to draw: its own answer is c² = 1.
    """
    timing = result if isinstance(result, RetimingResult) else None
    shown = result if isinstance(result, ScalingResult) else result.retimed or result.constant
    title = f"{shown.cell.name}: {answer_card(result).outcome}"
    plots = [] if shown.origin else [range_plot(shown)]
    if timing is not None and timing.pieces:
        plots.append(phase_plane_plot(timing))
    if shown.load is not None and shown.load.ranges:
        plots.append(load_study_plot(shown))
    if shown.trajectory is not None:
        plots += [trajectory_plot(shown, title), limits_plot(shown, title), power_plot(shown, title)]
    return plots


def write_result_plots(
    result: ScalingResult | RetimingResult,
    folder: Path | str,
    form: str = "png",
    search: ReserveSearch | None = None,
) -> None:
    """Write the plots of a result: range of c², phase plane, loads, torques and wrenches, use of limits, power.

    Args:
        result: Any result; what it does not have is left out.
        folder: Made if missing; it gets all files or none.
        form: "png", "svg" or "pdf".
        search: That found its reserve: its plot comes with them.

    Raises:
        InputError: If there is no such format, or a file cannot be written.
    """
    check_type("result", result, ScalingResult, RetimingResult)
    further = [] if search is None else [reserve_plot(search)]
    _write([*result_plots(result), *further], as_path("folder", folder), form)


def write_simulation_plot(found: Simulation, folder: Path | str, form: str = "png") -> None:
    """Write the plot `simulation`; arguments and errors as of `write_result_plots`."""
    check_type("found", found, Simulation)
    _write([simulation_plot(found)], as_path("folder", folder), form)


def write_study_plots(study: StudyTable | Path | str, to: Path | str, form: str = "png") -> None:
    """Write the plots of what a sweep has found so far: how durations spread, and the map or the line.

    Args:
        study: The table, or the folder of the study, as `mrts sweep -o` wrote it.
        to: Folder for the files, made if missing; it gets all or none.
        form: "png", "svg" or "pdf".

    Raises:
        InputError: If there is no study, none of its variants is solved, there is no such format, or a file
            cannot be written.
    """
    table = study if isinstance(study, StudyTable) else read_study_table(as_path("study", study))
    _write([durations_plot(table), *([study_map_plot(table)] if table.knobs else [])], as_path("to", to), form)


def write_motor_plots(found: MotorIdentification, folder: Path | str, form: str = "png") -> None:
    """Write a plot `motors_ROBOT` of every recorded robot, all or none.

    Args:
        found: What `mrts.identify` found.
        folder: Is made if it is not there.
        form: "png", "svg" or "pdf".

    Raises:
        InputError: If there is no such format, or a file cannot be written.
    """
    _write([motor_plot(arm) for arm in found.arms], as_path("folder", folder), form)


def _write(plots: Iterable[Plot], folder: Path, form: str) -> None:
    check_type("form", form, str)
    if form not in FIGURE_FORMATS:
        raise InputError("form", f"figures are written as one of {', '.join(FIGURE_FORMATS)}.", value=form)
    from mrts.plots.matplotlib_drawer import figure_writer  # noqa: PLC0415 (the extra 'plot')

    write_together({folder / f"{plot.name.replace('-', '_')}.{form}": figure_writer(plot) for plot in plots})
