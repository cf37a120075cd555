# SPDX-License-Identifier: MIT
"""Motion of the whole cell from whatever is known of it: the object, a table of joints, or both."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import NoneType

from mrts.base.errors import InputError, Remark, check_type
from mrts.base.words import first_names
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion, carried_by_first, follow_object
from mrts.following.grasp_closure import ClosureBound, close_chain
from mrts.following.tracking import PRINTED_TOLERANCE, check_joint_limits
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion

MOST_NAMED = 12
"""Joints named in a remark; a humanoid has more."""


def coordinate(
    cell: Cell, motion: ObjectMotion | JointTable | CoordinatedMotion, closure: ClosureBound | None = None
) -> CoordinatedMotion:
    """Motion of the whole cell from whatever is known of it.

    Args:
        motion: Of the object (the joints follow it), of the joints (they carry the object), or of both.
        closure: How far given joints may be off the grasps, onto which they are then moved; None allows 2 mm and
            5 mrad.

    Raises:
        InputError: If a joint table does not fit the cell, or `closure` is none.
        MotionError: If the arms cannot follow the object, or given joints do not close the chain.
    """
    check_type("cell", cell, Cell)
    check_type("motion", motion, ObjectMotion, JointTable, CoordinatedMotion)
    check_type("closure", closure, ClosureBound, NoneType)
    if isinstance(motion, ObjectMotion):
        return follow_object(cell, motion)
    bound = closure or ClosureBound()
    if isinstance(motion, JointTable):
        return _follow_joints(cell, motion, bound)
    joints = len(cell.joint_names)
    if motion.q.shape[1] != joints:
        raise InputError("motion.q", f"has {motion.q.shape[1]} columns, cell '{cell.name}' has {joints} joints.")
    check_joint_limits(cell, motion.object.time, motion.q)
    return close_chain(cell, motion, bound, "motion", carried=False)


def _follow_joints(cell: Cell, table: JointTable, bound: ClosureBound) -> CoordinatedMotion:
    names, extra = required_columns(cell, table.path, [*table.positions, *table.unusable])
    for name in names:
        if name in table.unusable:
            raise table.unusable[name]
    told = f"joints that no arm of cell '{cell.name}' has were passed over: {first_names(sorted(extra), MOST_NAMED)}."
    remarks = (Remark("extra-joints", told),) if extra else ()
    time, joints, course, said = table.of(names)
    check_joint_limits(cell, time, joints[0], PRINTED_TOLERANCE)
    carried = carried_by_first(cell, time, *joints)
    given = replace(carried, remarks=(*said, *remarks), course=course)
    return close_chain(cell, given, bound, str(table.path), carried=True)


def required_columns(cell: Cell, path: Path, columns: Sequence[str]) -> tuple[list[str], list[str]]:
    """The column of each joint of a cell, in its order, and the columns of other joints.

    Raises:
        InputError: If a joint has no column, or two.
    """
    found = columns_by_joint(cell, path, columns)
    extra = [name for name in columns if name not in found.values()]
    for joint in cell.joint_names:
        if joint not in found:
            raise InputError(
                path,
                f"nothing is said of joint '{joint}' of cell '{cell.name}': the column 'q.{joint}' is needed, in a bag "
                f"a trajectory under /{joint.partition('/')[0]}/joint_trajectory.{other_columns(extra)}",
            )
    return [found[joint] for joint in cell.joint_names], extra


def columns_by_joint(cell: Cell, path: Path, columns: Sequence[str]) -> dict[str, str]:
    """Joints "robot/joint" of a cell with the columns of a file that are theirs, if any.

    "joint" alone, or a first name that is no robot's, may stand for it where one robot alone has such a joint, or where
    the joint is called robot_joint, as in a machine of two equal arms.

    Raises:
        InputError: If two columns are the same joint.
    """
    robots = {robot.name: robot.joints for robot in cell.robots}
    joints = {*cell.joint_names}
    found = {name: name for name in columns if name in joints}
    for name in columns:
        prefix, _, joint = name.rpartition("/")
        owners = [f"{robot}/{joint}" for robot in robots if joint in robots[robot]] or [
            f"{robot}/{own}" for robot in robots for own in robots[robot] if joint == f"{robot}_{own}"
        ]
        if name in found or prefix in robots or len(owners) != 1:
            continue
        meant = owners[0]
        if found.get(meant) == meant:
            continue  # another robot's joint of the same name
        if meant in found:
            raise InputError(path, f"'{found[meant]}' and '{name}' are the same joint of cell '{cell.name}'.")
        found[meant] = name
    return found


def other_columns(extra: Sequence[str]) -> str:
    """What is said where a joint is missing, of columns that are none's or may be two's; empty if there are none."""
    names = first_names(sorted(extra), MOST_NAMED)
    return f" Of no joint of the cell, or of two, are {names}: is one of them meant?" if extra else ""
