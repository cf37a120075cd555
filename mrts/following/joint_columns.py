# SPDX-License-Identifier: MIT
"""Which columns of a file are those of a cell's joints."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from mrts.base.errors import InputError
from mrts.base.words import first_names
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot

MOST_NAMED = 12
"""Joints named in a message; a humanoid has more."""


def required_columns(
    cell: Cell, robots: Sequence[Robot], path: Path, given: Iterable[str], unusable: Mapping[str, InputError]
) -> tuple[list[str], list[str]]:
    """The columns of a file that are those of the joints of some robots, in their order, and columns of no joint.

    Raises:
        InputError: If a joint has no column, or two, or one that is of no use.
    """
    columns = [*given, *unusable]
    found = columns_by_joint(cell, path, columns)
    extra = [name for name in columns if name not in found.values()]
    joints = [f"{robot.name}/{joint}" for robot in robots for joint in robot.joints]
    for joint in joints:
        if joint not in found:
            names = first_names(sorted(extra), MOST_NAMED)
            others = f" Of no joint of the cell, or of two, are {names}: is one of them meant?" if extra else ""
            topic = f"/{joint.partition('/')[0]}/joint_trajectory"
            rule = f"nothing is said of joint '{joint}' of cell '{cell.name}': a column 'q.{joint}' is needed, in a bag"
            raise InputError(path, f"{rule} a topic such as {topic} (of a recording joint_states).{others}")
        if found[joint] in unusable:
            raise unusable[found[joint]]
    return [found[joint] for joint in joints], extra


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
