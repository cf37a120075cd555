# SPDX-License-Identifier: MIT
"""Everything that is wrong with a cell and a motion at once."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mrts.base.argument_types import Progress, as_path, check_callable
from mrts.base.errors import InputError, Mistakes, MotionError
from mrts.base.formats.pose import Pose
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.cell import Cell
from mrts.cell.cell_change import machine_of
from mrts.cell.loading import uncompiled_cell
from mrts.cell.remarks import COLLISIONS_UNKNOWN
from mrts.cell.source_files import is_generated, read_without_generating
from mrts.collisions.clearance import clearance_remarks
from mrts.following.coordinate import coordinate
from mrts.following.coordinated_motion import CoordinatedMotion, check_motion
from mrts.motion.joint_table import JointTable
from mrts.motion.motion_file import load_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.starting.arm_reach import ArmReach, of_machine, reach_of
from mrts.starting.cell_check import CellCheck
from mrts.starting.hints import motion_units, posture_hints, swapped_columns, what_would_work

OF_PLACES = frozenset(
    {"base-millimetres", "grasp-millimetres", "motion-millimetres", "urdf-millimetres", "posture-degrees"}
    | {"rpy-degrees", "limits-equal", "limits-degrees"}
)
"""Codes of remarks that explain why an arm does not follow: nothing else is looked for then."""

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
        found = replace(found, remarks=(*found.remarks, *motion.remarks, *motion_units(cell, motion)))
    try:
        if not isinstance(motion, ObjectMotion):
            closed = coordinate(cell, motion)
            return _with_clearance(replace(found, remarks=(*found.remarks, *closed.remarks)), cell, closed)
        check_motion(cell, motion)
    except InputError as error:
        return replace(found, mistakes=(*found.mistakes, *error.each()))
    except MotionError as error:
        swapped = swapped_columns(cell, motion) if isinstance(motion, JointTable) else ()
        return replace(found, problem=str(error), remarks=(*found.remarks, *swapped))
    arms = [uncompiled_cell(alone, cell.folder or Path()) for alone in model.arms_alone()]
    reaches: list[ArmReach] = []
    remarks = [*found.remarks]
    explained = any(remark.code in OF_PLACES for remark in remarks)
    for number, arm in enumerate(arms):
        progress(number, len(arms))
        reach = reach_of(arm, motion, seek=not explained)
        fellows = [arms[index] for index in _fellows(cell, number)]
        reaches.append(of_machine(reach, fellows, motion) if fellows else reach)
    lost = [index for index, reach in enumerate(reaches) if not reach.follows and reach.posture is None]
    if lost and not explained:
        remarks += what_would_work(arms, lost, motion, _other_orders(model), cell.machines)
    if len(remarks) == len(found.remarks) and not explained and any(not reach.follows for reach in reaches):
        remarks += posture_hints(arms, motion)
    progress(len(arms), len(arms))
    found = replace(found, arms=tuple(reaches), remarks=tuple(remarks))
    return found if explained or found.status != "fine" else _with_clearance(found, cell, motion)


def _with_clearance(found: CellCheck, cell: Cell, motion: ObjectMotion | CoordinatedMotion) -> CellCheck:
    """The same with the least distance between bodies in the place of the remark that it is not known."""
    near, said = clearance_remarks(cell, motion)
    others = [remark for remark in found.remarks if remark.code != COLLISIONS_UNKNOWN]
    return replace(found, clearance=near, remarks=(*others, *said))


def _fellows(cell: Cell, index: int) -> list[int]:
    names = [robot.name for robot in cell.robots]
    return [names.index(name) for name in machine_of(cell, names[index]) if name != names[index]]


def _other_orders(model: Any) -> dict[int, dict[str, RigidTransform]]:
    """By arm, its poses whose quaternion is written so that it may be meant in the other order."""
    other = {"quaternion_wxyz": "quaternion_xyzw", "quaternion_xyzw": "quaternion_wxyz"}
    found: dict[int, dict[str, RigidTransform]] = {}
    for index, robot in enumerate(model.description.robots):
        for key in ("base", "grasp"):
            pose = getattr(robot, key)
            if pose.rotation_key in other:
                given = getattr(pose, pose.rotation_key)
                meant = Pose(xyz=pose.xyz, **{other[pose.rotation_key]: given})
                found.setdefault(index, {})[key] = meant.transform
    return found
