# SPDX-License-Identifier: MIT
"""What was perhaps meant by a cell and a motion that do not fit: changes with which they would, each tried out."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, MrtsError
from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform, angles_of_rotations, rotation_from_rpy, rpy_from_rotation
from mrts.cell.cell import Cell
from mrts.cell.remarks import FAR, LONGEST_ARM, NEAR, arm_length, base_remarks
from mrts.following.coordinate import columns_by_joint, coordinate
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.scene.cell_shapes import tip_at_posture
from mrts.starting.arm_reach import follows

AGREE = (0.05, 0.2)
"""Distance [m] and angle [rad] within which the postures of all arms hold one object."""

ELSEWHERE = (0.1, 0.5)
"""Distance [m] and angle [rad] from which on that is not where the motion starts."""

OTHER_SIDES = {"x": (np.pi, 0.0, 0.0), "y": (0.0, np.pi, 0.0)}
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
    """Hints on changes with which the arms that fail would follow, and those that follow still do."""
    names = [arm.robots[0].name for arm in arms]
    for one, other in combinations(range(len(arms)), 2):
        if not {one, other} & {*failing}:
            continue
        working = []
        for what in ("base", "grasp"):
            ours, theirs = (_pose(arms[index], what) for index in (one, other))
            if (what == "base" and (names[one], names[other]) in machines) or np.array_equal(
                ours.numbers, theirs.numbers
            ):
                continue
            swapped = [_posed(arms[one], what, theirs), _posed(arms[other], what, ours)]
            if all(arm is not None and follows(arm, motion) for arm in swapped):
                working.append((sum(_off(arm, motion)[0] for arm in swapped if arm is not None), what))
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


def _pose(arm: Cell, what: str) -> RigidTransform:
    (robot,) = arm.robots
    return robot.T_world_base if what == "base" else robot.T_object_tip


def _posed(arm: Cell, what: str, pose: RigidTransform) -> Cell | None:
    try:
        return arm.with_values({f"robots[0].{what}": pose})
    except InputError:
        return None


def _other_order(arm: Cell, poses: Mapping[str, RigidTransform], motion: ObjectMotion) -> Iterator[Remark]:
    for what, pose in poses.items():
        meant = _posed(arm, what, pose)
        if meant is not None and follows(meant, motion):
            yield Remark.hint(
                "quaternion-order",
                f"robot '{arm.robots[0].name}' would follow with the quaternion of its {what} in the other order: "
                "quaternion_wxyz has the real part first, quaternion_xyzw last.",
            )


def _other_side(arm: Cell, motion: ObjectMotion) -> Iterator[Remark]:
    """A hint where the hand could hold the object from the other side, as its posture does rather."""
    (robot,) = arm.robots
    for axis, turn in OTHER_SIDES.items():
        R: Array = robot.T_object_tip.R @ rotation_from_rpy(*turn)
        turned = _posed(arm, "grasp", RigidTransform(R, robot.T_object_tip.p))
        if turned is not None and _off(turned, motion)[1] < _off(arm, motion)[1] / 2 and follows(turned, motion):
            shown = ", ".join(f"{angle:.6g}" for angle in rpy_from_rotation(turned.robots[0].T_object_tip.R))
            yield Remark.hint(
                "other-side",
                f"robot '{robot.name}' would follow if its hand were turned by half a turn about its {axis} axis, so "
                f"that it holds the object from the other side: grasp rpy: [{shown}]. Does its tool axis point the "
                "wrong way?",
            )
            return


def posture_hints(arms: Sequence[Cell], motion: ObjectMotion) -> Iterator[Remark]:
    """A hint where the postures of all arms hold the object together, but elsewhere than the motion starts."""
    held = [_held(arm) for arm in arms]
    if len(held) < 2 or any(_beyond(held[0], other, AGREE) for other in held[1:]):  # noqa: PLR2004 (one agrees always)
        return
    if _beyond(held[0], RigidTransform(motion.rotation[0], motion.position[0]), ELSEWHERE):
        ours, theirs = (", ".join(f"{value:.3g}" for value in p) for p in (held[0].p, motion.position[0]))
        yield Remark.hint(
            "other-start-pose",
            f"the postures hold the object at [{ours}] m, and the motion starts at [{theirs}] m or turned otherwise: "
            "were they made for another motion?",
        )


def motion_units(cell: Cell, motion: ObjectMotion) -> Iterator[Remark]:
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


def _held(arm: Cell) -> RigidTransform:
    (robot,) = arm.robots
    return tip_at_posture(robot) @ robot.T_object_tip.inverse()


def _off(arm: Cell, motion: ObjectMotion) -> tuple[float, float]:
    """How far from its start the posture of an arm holds the object [m], and how far turned [rad]."""
    return _apart(_held(arm), RigidTransform(motion.rotation[0], motion.position[0]))


def _apart(one: RigidTransform, other: RigidTransform) -> tuple[float, float]:
    turn = float(angles_of_rotations((one.R.T @ other.R)[None])[0])
    return float(np.linalg.norm(one.p - other.p)), turn


def _beyond(one: RigidTransform, other: RigidTransform, bound: tuple[float, float]) -> bool:
    distance, turn = _apart(one, other)
    return distance > bound[0] or turn > bound[1]
