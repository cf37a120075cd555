# SPDX-License-Identifier: MIT
"""Everything that is wrong with a cell and a motion, or with a URDF by itself, at once."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mrts.base.argument_types import Progress, as_path, check_callable
from mrts.base.errors import InputError, Mistakes, MotionError
from mrts.base.remark import Remark
from mrts.cell.cell import Cell, uncompiled_cell
from mrts.cell.generation import arm_of_urdf, is_generated, read_urdf, read_without_generating
from mrts.cell.remarks import (
    COLLISIONS_UNKNOWN,
    joint_assumptions,
    missing_masses,
    urdf_remarks,
)
from mrts.collisions.clearance import clearance_remarks
from mrts.following.coordinate import coordinate
from mrts.following.coordinated_motion import CoordinatedMotion, check_motion
from mrts.motion.joint_table import JointTable
from mrts.motion.motion_file import load_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.starting.arm import Arm, plane_of
from mrts.starting.arm_reach import reach_of
from mrts.starting.cell_check import CellCheck, is_urdf
from mrts.starting.request import check_movable
from mrts.starting.tips import FEWEST_JOINTS, first_link, hands

OBJECTS = (Mapping, ObjectMotion, JointTable, CoordinatedMotion)
"""Of a motion that is no file."""


def check(
    cell: Cell | Path | str,
    motion: Path | str | Mapping[str, Any] | ObjectMotion | JointTable | CoordinatedMotion | None = None,
    *,
    progress: Progress = lambda _done, _total: None,
) -> CellCheck:
    """Check a cell file, its URDFs and a motion, and how far each arm follows it; or one URDF, before there is a cell.

    Only the last needs a compiled library, a small one. What is wrong is found all at once and does not raise: it is
    listed in the answer.

    Args:
        cell: The cell file, or a cell, which is checked as the cell file that it writes: without limits of your own;
            or a URDF.
        motion: As in `mrts.load_motion`, or what that gives, or a motion of the whole cell; None checks the cell alone.
        progress: Told how many of how many arms are done.

    Raises:
        InputError: If an argument is none of these, the cell is a folder of generated files or no cell file can hold
            it, or there is a motion beside a URDF.
    """
    check_callable("progress", progress)
    if isinstance(cell, Cell):
        with TemporaryDirectory() as folder:
            path = Path(folder) / "cell.yaml"
            cell.to_yaml(path)
            return replace(check(path, motion, progress=progress), cell=Path(cell.name))
    path = as_path("cell", cell)
    if is_urdf(path):
        if motion is not None:
            raise InputError("motion", "does not go with a URDF, which is checked by itself.")
        return _check_urdf(path)
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
        found = replace(found, remarks=(*found.remarks, *motion.remarks))
    try:
        if not isinstance(motion, ObjectMotion):
            closed = coordinate(cell, motion)
            return _with_clearance(replace(found, remarks=(*found.remarks, *closed.remarks)), cell, closed)
        check_motion(cell, motion)
    except InputError as error:
        return replace(found, mistakes=(*found.mistakes, *error.each()))
    except MotionError as error:
        return replace(found, problem=str(error))
    arms = [uncompiled_cell(alone, cell.folder or Path()) for alone in model.arms_alone()]
    reaches = []
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


def _check_urdf(path: Path) -> CellCheck:
    read = read_urdf(path, Path(), str(path))
    mistakes, tree, arms = Mistakes(read.mistakes), read.urdf, []
    if tree is not None:
        tips = [*hands(tree)]
        if not tips:
            mistakes.add(InputError(path, f"has no link that {FEWEST_JOINTS} joints or more move: it is no arm."))
        for tip in tips:
            with mistakes.noted():
                arms.append(Arm(*arm_of_urdf(read.path, tree, first_link(tree, tips), tip), read.path))
    robots = tuple(arm.robot for arm in arms)
    remarks = [hint for arm in arms for hint in _urdf_hints(arm)]
    remarks += [*read.remarks, *missing_masses(robots), *joint_assumptions(robots)]
    return CellCheck(cell=path, mistakes=tuple(mistakes.found), robots=robots, remarks=tuple(remarks))


def _urdf_hints(arm: Arm) -> Iterator[Remark]:
    likely = [*urdf_remarks(arm.robot)]
    yield from likely
    try:
        check_movable(arm, plane_of([arm]))
    except InputError as error:
        if error.rule not in {hint.text for hint in likely}:
            yield Remark.hint("cannot-hold", f"{arm.robot.source.tip_link}: {error.rule}")
