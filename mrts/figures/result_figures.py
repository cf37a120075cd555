# SPDX-License-Identifier: MIT
"""All figures of one result, as files."""

from pathlib import Path

from mrts.base.argument_types import as_path, check_type
from mrts.figures.c2_range import range_figure
from mrts.figures.loads import study_figure
from mrts.figures.phase_plane import phase_plane_figure
from mrts.figures.power import power_figure
from mrts.figures.rates import rates_figure
from mrts.figures.style import NotebookFigure, check_form, write_figures
from mrts.figures.trajectory import trajectory_figure
from mrts.scaling.limit_use import limited_rate_kinds
from mrts.scaling.result import ScalingResult
from mrts.timing.result import RetimingResult

FULL_STOP = ". "
"""A title is the first sentence of what was done to a motion."""


def write_result_figures(result: ScalingResult | RetimingResult, folder: Path | str, form: str = "png") -> None:
    """Write the range of c², the study of the load, and torques, their rates, wrenches, power and energy.

    Of a retimed motion, these and the phase plane; without a profile, those of the best constant factor.

    Args:
        result: Any result; what it does not have is left out.
        folder: Made if missing; it gets all figures or none.
        form: "png", "svg" or "pdf".

    Raises:
        InputError: If there is no such format, or a file cannot be written.
    """
    check_type("result", result, ScalingResult, RetimingResult)
    folder = as_path("folder", folder)
    check_form(form)
    if isinstance(result, RetimingResult):
        figures = result_figures(result.retimed or result.constant)
        if result.pieces:
            figures["phase_plane"] = phase_plane_figure(result)
    else:
        figures = result_figures(result)
    write_figures(figures, folder, form)


def result_figures(result: ScalingResult) -> dict[str, NotebookFigure]:
    """All figures of a result, by file name without its ending.

    Args:
        result: Any result.
    """
    figures = {"c2_range": range_figure(result)}
    if result.load is not None and result.load.ranges:
        figures["load_study"] = study_figure(result)
    done = result.trajectory
    if done is not None:
        speed = f"{result.motion.object.time[-1]:.4g} s become {done.duration:.4g} s"
        title = f"{result.cell.name}: {result.origin.split(FULL_STOP)[0] or speed}"
        figures["torques_and_wrenches"] = trajectory_figure(result, title)
        if limited_rate_kinds(result):
            figures["rates"] = rates_figure(result, title)
        figures["power_and_energy"] = power_figure(result, title)
    return figures
