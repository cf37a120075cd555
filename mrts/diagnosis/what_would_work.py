# SPDX-License-Identifier: MIT
"""Changes of a cell with which its arms would follow a motion, each tried out: what was perhaps meant."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, MrtsError
from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform, rotation_from_rpy, rpy_from_rotation
from mrts.cell.cell import Cell
from mrts.diagnosis.arm_reach import follows
from mrts.diagnosis.postures_at_start import posture_off, posture_turned
from mrts.following.coordinate import columns_by_joint, coordinate
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion

OTHER_SIDES = {
    "x": (np.pi, 0.0, 0.0),
    "y": (0.0, np.pi, 0.0),
}
"""Half turns of a hand that then holds from the other side, by axis of the tip."""


OtherOrders = Mapping[int, Mapping[str, RigidTransform]]
"""By arm, and "base" or "grasp", its pose if its quaternion were written in the other order."""


def what_would_work(
    arms: Sequence[Cell],
    failing: Sequence[int],
    motion: ObjectMotion,
    orders: OtherOrders,
    machines: Sequence[tuple[str, str]],
) -> Iterator[Remark]:
    """Hints on changes with which the arms that fail would follow, and those that follow still do.

    Args:
        arms: A cell of each arm.
        failing: Those that do not follow from any posture.
        motion: Of the object.
        orders: Poses that quaternions may mean.
        machines: Arms of one machine by two, whose bases are where its URDF has them.
    """
    names = [arm.robots[0].name for arm in arms]
    for one, other in combinations(range(len(arms)), 2):
        if not {one, other} & {*failing}:
            continue
        working = []
        for what, place in (("base", "T_world_base"), ("grasp", "T_object_tip")):
            if what == "base" and (names[one], names[other]) in machines:
                continue
            swapped = _swapped(arms, one, other, place)
            if swapped is not None and all(follows(arm, motion) for arm in swapped):
                working.append((sum(posture_off(arm, motion) for arm in swapped), what))
        if working:
            (_, likely), *less = sorted(working)
            also = f" (or with each other's {less[0][1]})" if less else ""
            yield Remark.hint(
                f"swapped-{likely}s",
                f"robots '{names[one]}' and '{names[other]}' would follow with each other's {likely}{also}: are the "
                "two swapped?",
            )
            return
    for index in failing:
        yield from _other_order(arms[index], orders.get(index, {}), motion)
        yield from _other_side(arms[index], motion)


def swapped_columns(cell: Cell, table: JointTable) -> Iterator[Remark]:
    """A hint where given joints would hold the grasps if two arms had each other's columns.

    Args:
        cell: The cell.
        table: Its joints, which do not hold them.
    """
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


def _swapped(arms: Sequence[Cell], one: int, other: int, place: str) -> tuple[Cell, Cell] | None:
    """Two arms with each other's pose; None where they are the same, or may not stand so."""
    poses = [getattr(arms[index].robots[0], place) for index in (one, other)]
    if np.array_equal(poses[0].numbers, poses[1].numbers):
        return None
    try:
        first, second = (_posed(arms[index], place, pose) for index, pose in ((one, poses[1]), (other, poses[0])))
    except InputError:  # out of the plane of a planar cell
        return None
    return first, second


def _posed(arm: Cell, place: str, pose: RigidTransform) -> Cell:
    (robot,) = arm.robots
    held = place == "T_object_tip"
    changed = replace(robot, T_object_tip=pose) if held else replace(robot, T_world_base=pose)
    return replace(arm, robots=(changed,))


def _other_order(arm: Cell, poses: Mapping[str, RigidTransform], motion: ObjectMotion) -> Iterator[Remark]:
    """A hint where a quaternion in the other order lets the arm follow."""
    (robot,) = arm.robots
    for what, pose in poses.items():
        try:
            meant = _posed(arm, "T_object_tip" if what == "grasp" else "T_world_base", pose)
        except InputError:  # out of the plane of a planar cell
            continue
        if follows(meant, motion):
            yield Remark.hint(
                "quaternion-order",
                f"robot '{robot.name}' would follow with the quaternion of its {what} in the other order: "
                "quaternion_wxyz has the real part first, quaternion_xyzw last.",
            )


def _other_side(arm: Cell, motion: ObjectMotion) -> Iterator[Remark]:
    """A hint where the hand could hold the object from the other side, as its posture does rather."""
    (robot,) = arm.robots
    for axis, turn in OTHER_SIDES.items():
        R: Array = robot.T_object_tip.R @ rotation_from_rpy(*turn)
        try:
            turned = _posed(arm, "T_object_tip", RigidTransform(R, robot.T_object_tip.p))
        except InputError:  # out of the plane of a planar cell
            continue
        if posture_turned(turned, motion) < posture_turned(arm, motion) / 2 and follows(turned, motion):
            shown = ", ".join(f"{angle:.6g}" for angle in rpy_from_rotation(turned.robots[0].T_object_tip.R))
            yield Remark.hint(
                "other-side",
                f"robot '{robot.name}' would follow if its hand were turned by half a turn about its {axis} axis, so "
                f"that it holds the object from the other side: grasp rpy: [{shown}]. Does its tool axis point the "
                "wrong way?",
            )
            return
