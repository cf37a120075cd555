# SPDX-License-Identifier: MIT
"""The page of a result, of a plan in closed loop, or of a study."""

from pathlib import Path
from types import NoneType

from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import InputError, as_path, check_type
from mrts.control.simulate import Simulation
from mrts.control.speed_override import Stops
from mrts.output import report_tables as tables
from mrts.output.report import document
from mrts.output.report_player import player
from mrts.plots import phase_plane, range_plots, study_plots, trajectory_plots
from mrts.plots.card import answer_card
from mrts.plots.plan_plots import simulation_plot, stops_plot
from mrts.plots.study_plots import StudyTable
from mrts.scaling.scale import ScalingResult
from mrts.scene.scene import PACES
from mrts.timing.result import RetimingResult


def write_report(
    result: ScalingResult | RetimingResult | Simulation | StudyTable, path: Path | str, stops: Stops | None = None
) -> None:
    """Write a report: one HTML file that opens offline.

    Args:
        result: Any result, feasible or not; one of `mrts.retime` begins with its timing. Or what `mrts.simulate`
            found, or a study, as `mrts.plots.read_study_table` reads it.
        path: The file.
        stops: What stops take, from `SpeedOverride.stops`, where a page of a scaled or timed motion is to show it.

    Raises:
        InputError: If plotly or Jinja is not installed, stops come with anything else, or the file cannot be written.
    """
    check_type("result", result, ScalingResult, RetimingResult, Simulation, StudyTable)
    check_type("stops", stops, Stops, NoneType)
    if stops is not None and not isinstance(result, ScalingResult | RetimingResult):
        raise InputError("stops", "go with a result of mrts.scale or mrts.retime.")
    write_text_atomically(as_path("path", path), report_html(result, stops))


def report_html(result: ScalingResult | RetimingResult | Simulation | StudyTable, stops: Stops | None = None) -> str:
    """A report as text, with arguments of `write_report`; the same result gives the same text."""
    if isinstance(result, StudyTable):
        title = f"{result.name}: {result.variants} variants"
        return document("study.html", title, {}, study=result, plots=study_plots, tables=tables)
    if isinstance(result, Simulation):
        title = f"{result.plan.cell.name}: in closed loop"
        return document("simulation.html", title, {}, found=result, plot=simulation_plot(result))
    timing = result if isinstance(result, RetimingResult) else None
    shown = result if isinstance(result, ScalingResult) else result.retimed or result.constant
    scene = player(shown, None if timing is None or timing.retimed is None else phase_plane.played_way(timing))
    return document(
        "result.html",
        f"{shown.cell.name}: {result.status.value}",
        {"player": scene},
        result=shown,
        timing=timing,
        status=result.status,
        card=answer_card(result),
        sentences=_sentences(timing, shown),
        warnings=shown.warnings,
        player=scene,
        paces=PACES,
        tables=tables,
        phase_plane=phase_plane,
        range_plots=range_plots,
        trajectory_plots=trajectory_plots,
        stops=stops,
        stops_plot=stops_plot,
    )


def _sentences(timing: RetimingResult | None, shown: ScalingResult) -> list[str]:
    told = [shown.sentence()]
    if timing is not None:
        told = [f"{timing.sentence()[0].upper()}{timing.sentence()[1:]}"]
        if timing.retimed is None:
            return [*told, f"The best constant factor, which is shown below: {shown.sentence()}"]
    if shown.trajectory is not None:
        load = "" if shown.load is None else f"The torques below are those of a load of {shown.cell.mass:.4g} kg. "
        speed = "The" if timing is not None else f"At c² = {shown.trajectory.c2:.6g} the"
        told.append(f"{load}{speed} motors give {shown.trajectory.energy:.4g} J.")
    return told
