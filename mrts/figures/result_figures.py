# SPDX-License-Identifier: MIT
"""All figures of one result, as files."""

from pathlib import Path

from mrts.figures.c2_range import range_figure
from mrts.figures.loads import study_figure
from mrts.figures.power import power_figure
from mrts.figures.style import write_figure
from mrts.figures.trajectory import trajectory_figure
from mrts.result import ScalingResult


def write_result_figures(result: ScalingResult, folder: Path) -> None:
    """Write the range of c², the study of the load, and torques, wrenches, power and energy of the trajectory.

    Args:
        result: Any result; what it does not have is left out.
        folder: Made if missing.

    Raises:
        InputError: If a file cannot be written.
    """
    write_figure(range_figure(result), folder / "c2_range.png")
    if result.load is not None and result.load.ranges:
        write_figure(study_figure(result), folder / "load_study.png")
    done = result.trajectory
    if done is not None:
        speed = f"{result.motion.object.time[-1]:.4g} s become {done.duration:.4g} s"
        title = f"{result.cell.name}: {result.origin or speed}"
        write_figure(trajectory_figure(result, title), folder / "torques_and_wrenches.png")
        write_figure(power_figure(result, title), folder / "power_and_energy.png")
