# SPDX-License-Identifier: MIT
"""Which column of a table, or joint of a bag, is which joint of a cell."""

from collections.abc import Sequence
from pathlib import Path

from mrts.base.errors import InputError
from mrts.cell.cell import Cell


def columns_by_joint(cell: Cell, path: Path, columns: Sequence[str]) -> dict[str, str]:
    """What a file calls the joints of a cell.

    Args:
        cell: The cell.
        path: The file, for the message.
        columns: "robot/joint" each; a first name that is no robot's may stand for it where one robot alone has such a
            joint, or where the joint is called robot_joint, as in a machine of two equal arms.

    Returns:
        Joint "robot/joint" of the cell to its column; joints without one are left out.

    Raises:
        InputError: If two columns are the same joint.
    """
    robots = {robot.name: robot.joints for robot in cell.robots}
    joints = {f"{robot}/{joint}" for robot in robots for joint in robots[robot]}
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


def meant_instead(joint: str, extra: Sequence[str]) -> str:
    """A question that names the column which is nearest to a joint that is missing; empty if none is near.

    Args:
        joint: "robot/joint".
        extra: Columns that are no joint of the cell.
    """
    import difflib  # noqa: PLC0415 (for this message only)

    close = difflib.get_close_matches(joint, extra, n=1)
    return f" There is '{close[0]}', which no arm of the cell has: is it meant?" if close else ""
