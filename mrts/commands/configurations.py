# SPDX-License-Identifier: MIT
"""`mrts configurations`."""

from pathlib import Path
from typing import Any

from click import IntRange, option

from mrts.base.errors import InputError
from mrts.commands import options
from mrts.commands.console import FEASIBLE, INFEASIBLE, Outputs, working


@options.command
@options.cell
@options.motion
@options.share
@options.between
@options.limits
@option("--show", type=IntRange(0), default=10, show_default=True, metavar="N", help="rows to print")
@options.solver
@options.json
def run(cell: Path, motion: Path, show: int, json: Path | None = None, **given: Any) -> int:
    """Compare all inverse-kinematics branches of the arms.

    Examples:
        mrts configurations cell.yaml motion.yaml --show 5
        mrts configurations cell.yaml motion.yaml --share equal --json ranking.json
    """
    from mrts.motion.motion_file import load_motion
    from mrts.motion.object_motion import ObjectMotion
    from mrts.studies.configurations import rank_configurations

    given_motion = load_motion(motion)
    if not isinstance(given_motion, ObjectMotion):
        raise InputError(motion, "a table of joint motion fixes the configuration; give the object's motion.")
    limited = options.compiled_cell(cell, **options.take(given, options.LIMITS))
    with working(f"configurations of {limited.name}") as progress:
        study = rank_configurations(limited, given_motion, **given, progress=progress)
    feasible = bool(study.ranked) and study.ranked[0].range.status.admits_motion
    return Outputs(study, json).answer(study.lines(show), FEASIBLE if feasible else INFEASIBLE)
