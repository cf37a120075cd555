# SPDX-License-Identifier: MIT
"""All figures of one result, as files."""

from pathlib import Path

from matplotlib.figure import Figure

from mrts.base.argument_types import as_path, check_type
from mrts.base.atomic_file import write_together
from mrts.figures.c2_range import range_figure
from mrts.figures.loads import study_figure
from mrts.figures.power import power_figure
from mrts.figures.rates import rates_figure
from mrts.figures.style import figure_writer
from mrts.figures.trajectory import trajectory_figure
from mrts.scaling.limit_use import limited_rate_kinds
from mrts.scaling.result import ScalingResult

FULL_STOP = ". "
"""A title is the first sentence of what was done to a motion."""


def write_result_figures(result: ScalingResult, folder: Path | str, *others: tuple[str, Figure]) -> None:
    """Write the range of c², the study of the load, and torques, their rates, wrenches, power and energy.

    Args:
        result: Any result; what it does not have is left out.
        folder: Made if missing; it gets all figures or none.
        *others: Further figures for the folder, each with its file name.

    Raises:
        InputError: If a file cannot be written.
    """
    check_type("result", result, ScalingResult)
    folder = as_path("folder", folder)
    figures = {"c2_range.png": range_figure(result)}
    if result.load is not None and result.load.ranges:
        figures["load_study.png"] = study_figure(result)
    done = result.trajectory
    if done is not None:
        speed = f"{result.motion.object.time[-1]:.4g} s become {done.duration:.4g} s"
        title = f"{result.cell.name}: {result.origin.split(FULL_STOP)[0] or speed}"
        figures["torques_and_wrenches.png"] = trajectory_figure(result, title)
        if limited_rate_kinds(result):
            figures["rates.png"] = rates_figure(result, title)
        figures["power_and_energy.png"] = power_figure(result, title)
    figures |= dict(others)
    write_together({folder / name: figure_writer(figure) for name, figure in figures.items()})
