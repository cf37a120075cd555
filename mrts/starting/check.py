# SPDX-License-Identifier: MIT
"""Everything that is wrong with a cell and a motion at once."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from mrts.base.argument_types import Progress, as_path, check_callable
from mrts.base.errors import InputError, Mistakes, MotionError, MrtsError
from mrts.base.remark import Remark
from mrts.cell.cell import Cell
from mrts.cell.loading import uncompiled_cell
from mrts.cell.remarks import COLLISIONS_UNKNOWN, FAR, LONGEST_ARM, NEAR, arm_length, base_remarks
from mrts.cell.source_files import is_generated, read_without_generating
from mrts.collisions.clearance import clearance_remarks
from mrts.following.coordinate import columns_by_joint, coordinate
from mrts.following.coordinated_motion import CoordinatedMotion, check_motion
from mrts.motion.joint_table import JointTable
from mrts.motion.motion_file import load_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.starting.arm_reach import ArmReach, reach_of
from mrts.starting.cell_check import CellCheck

OBJECTS = (Mapping, ObjectMotion, JointTable, CoordinatedMotion)
"""Of a motion that is no file."""


def check(
    cell: Cell | Path | str,
    motion: Path | str | Mapping[str, Any] | ObjectMotion | JointTable | CoordinatedMotion | None = None,
    *,
    progress: Progress = lambda _done, _total: None,
) -> CellCheck:
    """Check a cell file, its URDFs and a motion, and how far each arm follows it.

    Only the last needs a compiled library, a small one. What is wrong is found all at once and does not raise: it is
    listed in the answer.

    Args:
        cell: The cell file, or a cell, which is checked as the cell file that it writes: without limits of your own.
        motion: As in `mrts.load_motion`, or what that gives, or a motion of the whole cell; None checks the cell alone.
        progress: Told how many of how many arms are done.

    Raises:
        InputError: If an argument is none of these, the cell is a folder of generated files, or no cell file can hold
            it.
    """
    check_callable("progress", progress)
    if isinstance(cell, Cell):
        with TemporaryDirectory() as folder:
            path = Path(folder) / "cell.yaml"
            cell.to_yaml(path)
            return replace(check(path, motion, progress=progress), cell=Path(cell.name))
    path = as_path("cell", cell)
    named = None if motion is None else Path("motion") if isinstance(motion, OBJECTS) else as_path("motion", motion)
    if is_generated(path):
        raise InputError(path, "is generated; check the cell file that it was made from.")
    model, wrong = read_without_generating(path)
    mistakes = Mistakes(wrong)
    given: ObjectMotion | JointTable | CoordinatedMotion | None = None
    with mistakes.noted():
        given = load_motion(motion) if isinstance(motion, Path | str | Mapping) else motion
    found = CellCheck(cell=path, motion=named, mistakes=tuple(mistakes.found))
    if model is None:
        return found
    whole = uncompiled_cell(model, path.resolve().parent)
    found = replace(found, robots=whole.robots, remarks=whole.all_remarks)
    return found if given is None else _with_reach(found, model, whole, given, progress)


def _with_reach(
    found: CellCheck,
    model: Any,
    cell: Cell,
    motion: ObjectMotion | JointTable | CoordinatedMotion,
    progress: Progress,
) -> CellCheck:
    if isinstance(motion, ObjectMotion):
        found = replace(found, remarks=(*found.remarks, *motion.remarks, *_motion_units(cell, motion)))
    try:
        if not isinstance(motion, ObjectMotion):
            closed = coordinate(cell, motion)
            return _with_clearance(replace(found, remarks=(*found.remarks, *closed.remarks)), cell, closed)
        check_motion(cell, motion)
    except InputError as error:
        return replace(found, mistakes=(*found.mistakes, *error.each()))
    except MotionError as error:
        swapped = _swapped_columns(cell, motion) if isinstance(motion, JointTable) else ()
        return replace(found, problem=str(error), remarks=(*found.remarks, *swapped))
    arms = [uncompiled_cell(alone, cell.folder or Path()) for alone in model.arms_alone()]
    reaches: list[ArmReach] = []
    for number, arm in enumerate(arms):
        progress(number, len(arms))
        reaches.append(reach_of(arm, motion))
    progress(len(arms), len(arms))
    found = replace(found, arms=tuple(reaches))
    if found.status != "fine" or found.hints:  # collisions of a cell that is likely mistyped say little
        return found
    return _with_clearance(found, cell, motion)


def _with_clearance(found: CellCheck, cell: Cell, motion: ObjectMotion | CoordinatedMotion) -> CellCheck:
    """The same with the least distance between bodies in the place of the remark that it is not known."""
    near, said = clearance_remarks(cell, motion)
    others = [remark for remark in found.remarks if remark.code != COLLISIONS_UNKNOWN]
    return replace(found, clearance=near, remarks=(*others, *said))


def _swapped_columns(cell: Cell, table: JointTable) -> Iterator[Remark]:
    """A hint where given joints would hold the grasps if two arms had each other's columns."""
    columns = columns_by_joint(cell, table.path, [*table.positions])
    for one, other in combinations(cell.robots, 2):
        ours, theirs = ([columns[f"{robot.name}/{joint}"] for joint in robot.joints] for robot in (one, other))
        if len(ours) != len(theirs):
            continue
        try:
            coordinate(cell, table.renamed(dict(zip(ours + theirs, theirs + ours, strict=True))))
        except MrtsError:
            continue
        yield Remark.hint(
            "swapped-columns",
            f"the joints would hold the grasps if '{one.name}' and '{other.name}' had each other's columns of "
            f"{table.path.name}: are the two swapped?",
        )
        return


def _motion_units(cell: Cell, motion: ObjectMotion) -> Iterator[Remark]:
    """Remarks on lengths of a motion, or of bases beside it, that are likely in mm."""
    longest = max(arm_length(robot) for robot in cell.robots)
    if not 0 < longest <= LONGEST_ARM:
        return
    bases = max(float(np.linalg.norm(robot.T_world_base.p)) for robot in cell.robots)
    furthest = float(np.max(np.linalg.norm(motion.position, axis=1)))
    if furthest > FAR * longest + bases and furthest / 1000 < NEAR * longest + bases:
        yield Remark.hint(
            "motion-millimetres",
            f"the motion takes the object {furthest:.4g} m from the origin, no base is farther from it than "
            f"{bases:.3g} m, and the longest arm is {longest:.3g} m long: its lengths seem to be in mm.",
        )
    if not any(remark.code == "base-millimetres" for remark in cell.all_remarks):
        for robot in cell.robots:
            yield from base_remarks(robot, motion.position[0], motion.position[0], longest)
