# SPDX-License-Identifier: MIT
"""A plan from a table or a bag, as `mrts scale` writes them."""

from pathlib import Path

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, as_path, check_type
from mrts.cell.cell import Cell
from mrts.following.coordinate import coordinate
from mrts.following.joint_columns import required_columns
from mrts.motion.csv_motion import read_joint_columns
from mrts.motion.joint_table import JointTable
from mrts.motion.ros_messages import DERIVATIVES, KIND, bag_messages, is_bag, joint_columns
from mrts.motion.rows_at_rest import moving_rows
from mrts.scaling.scaled_trajectory import Holding, ScaledTrajectory

PARTS = ("q", "dq", "ddq", "tau", "F")
"""Of a plan, in the order of its columns."""

WRENCH_KIND = "geometry_msgs/msg/WrenchStamped"


def load_plan(cell: Cell, path: Path | str) -> ScaledTrajectory:
    """Read a plan that a cell is to play.

    Args:
        cell: The cell.
        path: A CSV table with t, q., dq., ddq. and tau. of every joint and F. of every wrench component, as `mrts scale
            --csv` writes, or a ROS 2 bag as `--ros-bag` does.

    Raises:
        InputError: If it is malformed, lacks something, or is of another cell.
        MotionError: If its joints do not carry one object.
    """
    time, found = read_plan(cell, path)
    path = as_path("path", path)
    if missing := [part for part in PARTS if part not in found]:
        raise InputError(path, f"says nothing of '{missing[0]}': a plan has it, as mrts scale writes it.")
    q, dq, ddq = (dict(zip(cell.joint_names, found[part].T, strict=True)) for part in ("q", "dq", "ddq"))
    motion = coordinate(cell, JointTable(path, time, q, dq, ddq))
    kept = moving_rows(time, found["q"], found["dq"], found["ddq"])
    ends = kept.start > 0, kept.stop < len(time)
    torque, wrench = found["tau"], found["F"]
    holding = Holding(ends, torque[[0, -1]], wrench[[0, -1]])
    return ScaledTrajectory(cell, motion, 1.0, torque[kept], wrench[kept], holding)


def read_plan(cell: Cell, path: Path | str) -> tuple[Array, dict[str, Array]]:
    """The numbers of a plan as they are, whoever made it.

    Args:
        cell: The cell.
        path: As in `load_plan`, but for what is not there.

    Returns:
        Times of the rows, Shape (N,) [s] from 0; and what there is of q, dq, ddq and tau of all joints and F of all
        wrench components, in the order of the cell, each Shape (N, …). There is q.

    Raises:
        InputError: If it is malformed, or lacks something of a joint or a component that it gives of another.
    """
    check_type("cell", cell, Cell)
    path = as_path("path", path)
    if path.suffix.lower() == ".npz":
        raise InputError(path, "is a saved result: give the plan that mrts scale writes with --csv or --ros-bag.")
    time, parts = _from_bag(cell, path) if is_bag(path) else read_joint_columns(path)
    joints, _ = required_columns(cell, cell.robots, path, parts["q"], {})
    wrenches = [f"{robot.name}/{part}" for robot in cell.robots for part in cell.wrench_components]
    found: dict[str, Array] = {}
    for part, columns in parts.items():
        names = wrenches if part == "F" else joints
        missing = [name for name in names if name not in columns]
        if columns and missing:
            raise InputError(path, f"says nothing of '{part}.{missing[0]}', but of others: give all or none.")
        if columns:
            found[part] = np.column_stack([columns[name] for name in names])
    return time, found


def _from_bag(cell: Cell, path: Path) -> tuple[Array, dict[str, dict[str, Array]]]:
    """What a table of the same plan has: times, and columns by q, dq, ddq, tau and F."""
    messages = {topic: [message for _, message in of] for topic, of in bag_messages(path, KIND, WRENCH_KIND).items()}
    planned = {topic: of for topic, of in messages.items() if of[0].__msgtype__ == KIND}
    if not planned:
        raise InputError(path, f"has no topic of {KIND}.")
    time, found, unusable = joint_columns(path, planned, 0, (*DERIVATIVES, "effort"))
    for error in unusable.values():
        raise error
    parts = dict(zip(PARTS, [*found, {}], strict=True))
    for robot in cell.robots:
        topic = f"/{robot.name}/contact_wrench"
        pushed = [message.wrench for message in messages.get(topic, [])]
        if len(pushed) not in {0, len(time)}:
            raise InputError(path, "must have the times of all others: the arms move together.", key=topic)
        if pushed:
            six = np.array([[of.x, of.y, of.z] for one in pushed for of in (one.force, one.torque)]).reshape(-1, 6)
            of_hand = zip(cell.wrench_components, six.T[cell.wrench_rows], strict=True)
            parts["F"] |= {f"{robot.name}/{component}": of for component, of in of_hand}
    return time, parts
