# SPDX-License-Identifier: MIT
"""Joint motion from a ROS 2 bag of trajectory_msgs/JointTrajectory; needs the extra 'ros' (rosbags)."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.input_file import LARGEST_NUMBER
from mrts.motion.joint_table import JointTable, joint_motion
from mrts.motion.ros_messages import NANOSECONDS, bag_messages, joint_column

KIND = "trajectory_msgs/msg/JointTrajectory"


def read_joint_trajectories(path: Path, samples: int | None) -> JointTable:
    """Read the joint trajectories of a bag, one message a topic, as one motion.

    The first name of a topic, as in /ROBOT/joint_trajectory, is that of a robot; if the cell has none of this name, its
    joints are found by their own names. Points with velocities and accelerations are taken as they are; without
    accelerations they lie on the spline of their velocities, with positions only on the C² spline through these. Effort
    is passed over. Trajectories that the cell needs have the same times; others, a gripper's for example, may not.

    Args:
        path: Folder of a bag, or one of its files by itself.
        samples: Number of samples on the spline; None takes the times of the points.

    Raises:
        InputError: If it is no bag, holds no trajectory that can be read, or a trajectory breaks a rule.
    """
    usable: dict[str, tuple[Any, NDArray[np.int64]]] = {}
    unusable: dict[str, InputError] = {}
    failure: InputError | None = None
    for topic, messages in _trajectories(path).items():
        try:
            usable[topic] = messages[0], _stamps(path, topic, messages)
        except InputError as error:
            unusable |= dict.fromkeys(_names(topic, messages[0]), error)
            failure = failure or error
    if failure is not None and not usable:
        raise failure
    first = max(usable, key=lambda topic: _joints_at(usable, usable[topic][1]))
    stamps = usable[first][1]
    parts: dict[str, dict[str, Array]] = {"positions": {}, "velocities": {}, "accelerations": {}}
    for topic, (message, at) in usable.items():
        names = _names(topic, message)
        if not np.array_equal(at, stamps):
            rule = f"must have the times of {first}: the arms move together."
            unusable |= dict.fromkeys(names, InputError(path, rule, key=topic))
            continue
        for part, columns in parts.items():
            values = _values(path, topic, message, part)
            for name, column in zip(names, values.T, strict=False):
                if name in columns:
                    robot, _, joint = name.rpartition("/")
                    raise InputError(path, f"the joint '{joint}' of '{robot}' has another trajectory.", key=topic)
                columns[name] = column
    q, dq, ddq = parts.values()
    ddq = {name: column for name, column in ddq.items() if name in dq}
    table = joint_motion(path, (stamps - stamps[0]) / NANOSECONDS, q, dq, ddq, samples)
    return replace(table, unusable=unusable)


def _names(topic: str, message: Any) -> list[str]:
    """Columns of a trajectory."""
    return [joint_column(topic, joint) for joint in message.joint_names]


def _joints_at(usable: dict[str, tuple[Any, NDArray[np.int64]]], stamps: NDArray[np.int64]) -> int:
    """How many joints have these times."""
    return sum(len(message.joint_names) for message, at in usable.values() if np.array_equal(at, stamps))


def _trajectories(path: Path) -> dict[str, list[Any]]:
    """The trajectories of each topic, by topic in the order of their names."""
    return {topic: [content for _, content in messages] for topic, messages in bag_messages(path, KIND).items()}


def _stamps(path: Path, topic: str, messages: list[Any]) -> NDArray[np.int64]:
    """Times of the points of the one trajectory from the start, Shape (N,) [ns]."""
    if len(messages) > 1:
        raise InputError(path, f"holds {len(messages)} trajectories; a motion is one. Keep one in the bag.", key=topic)
    times = [point.time_from_start for point in messages[0].points]
    if len(times) < 2:  # noqa: PLR2004 (both ends)
        raise InputError(path, f"has {len(times)} points; a motion has at least 2.", key=topic)
    stamps = np.array([time.sec * NANOSECONDS + time.nanosec for time in times], dtype=np.int64)
    steps = np.diff(stamps)
    if np.min(steps) <= 0:
        point = int(np.argmax(steps <= 0)) + 1
        raise InputError(
            path, "must be later than the point before.", key=f"{topic}, point {point}, time_from_start",
            value=float(stamps[point] / NANOSECONDS),
        )  # fmt: skip
    return stamps


def _values(path: Path, topic: str, message: Any, part: str) -> Array:
    """Positions, velocities or accelerations of all points, Shape (N, joints), or (N, 0) where there are none."""
    joints = list(message.joint_names)
    rows = [getattr(point, part) for point in message.points]
    size = len(rows[0]) if part != "positions" else len(joints)
    for point, row in enumerate(rows):
        if len(row) != size or size not in {0, len(joints)}:
            raise InputError(
                path, f"has {len(row)} {part} for {len(joints)} joints; other points have {size}.",
                key=f"{topic}, point {point}",
            )  # fmt: skip
    values = np.array(rows, dtype=np.float64)
    wrong = np.argwhere(~(np.abs(values) <= LARGEST_NUMBER))
    if wrong.size:
        point, joint = wrong[0]
        raise InputError(
            path, "must be a finite number.", key=f"{topic}, point {point}, {part} of {joints[joint]}",
            value=float(values[point, joint]),
        )  # fmt: skip
    return values
