# SPDX-License-Identifier: MIT
"""Joint motion from a ROS 2 bag of trajectory_msgs/JointTrajectory; needs the extra 'ros' (rosbags)."""

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.rosbag2 import Reader

from mrts.errors import InputError
from mrts.input_file import LARGEST_NUMBER, read_text
from mrts.motion_table import JointTable, joint_motion
from mrts.regular_file import open_regular
from mrts.rigid_transform import Array
from mrts.ros_bag import NANOSECONDS, TYPES
from mrts.strict_yaml import MAX_YAML_BYTES, parse_yaml

METADATA = "metadata.yaml"

MAX_BAG_BYTES = 500_000_000
"""Of one file; a trajectory of a million points takes half of it."""

KIND = "trajectory_msgs/msg/JointTrajectory"


def read_joint_trajectories(path: Path, samples: int | None) -> JointTable:
    """Read the joint trajectories of a bag, one message a topic, as one motion.

    The first name of a topic, as in /ROBOT/joint_trajectory, is that of a robot; if the cell has none of this name, its
    joints are found by their own names. Points with accelerations are taken as they are; others lie on the C² spline
    through their positions. All trajectories have the same times; effort is passed over.

    Args:
        path: Folder of a bag, or one of its files by itself.
        samples: Number of samples on the spline; None takes the times of the points.

    Raises:
        InputError: If it is no bag, holds no trajectory or several on a topic, or a trajectory breaks a rule.
    """
    parts: dict[str, dict[str, Array]] = {"positions": {}, "velocities": {}, "accelerations": {}}
    trajectories = _trajectories(path)
    first, stamps = "", np.zeros(0, dtype=np.int64)
    for topic, message in trajectories.items():
        at = _stamps(path, topic, message)
        if not first:
            first, stamps = topic, at
        elif not np.array_equal(at, stamps):
            raise InputError(path, f"must have the times of {first}: the arms move together.", key=topic)
        robot = topic.strip("/").partition("/")[0]
        for part, columns in parts.items():
            values = _values(path, topic, message, part)
            for joint, column in zip(message.joint_names, values.T, strict=False):
                if f"{robot}/{joint}" in columns:
                    raise InputError(path, f"the joint '{joint}' of '{robot}' has another trajectory.", key=topic)
                columns[f"{robot}/{joint}"] = column
    q, dq, ddq = parts.values()
    if set(ddq) != set(q) or set(dq) != set(q):
        dq, ddq = {}, {}
    return joint_motion(path, (stamps - stamps[0]) / NANOSECONDS, q, dq, ddq, samples)


def _trajectories(path: Path) -> dict[str, Any]:
    """The one trajectory of each topic, by topic."""
    _check_files(path)
    try:
        with Reader(path) as bag:
            topics = sorted(bag.topics)
            wanted = [connection for connection in bag.connections if connection.msgtype == KIND]
            messages = bag.messages(wanted) if wanted else ()
            found = [(connection.topic, TYPES.deserialize_cdr(data, KIND)) for connection, _, data in messages]
    except Exception as error:  # noqa: BLE001 (what the reader raises of damaged bags is no short list)
        reason = " ".join(str(error).split()) or type(error).__name__  # a YAML error draws where it is
        raise InputError(path, f"cannot be read as a ROS 2 bag: {reason}") from None
    if not found:
        raise InputError(path, f"holds no message {KIND}; its topics are {', '.join(topics) or 'none'}.")
    trajectories = dict(sorted(found, key=lambda pair: pair[0]))
    for topic, count in Counter(of for of, _ in found).items():
        if count > 1:
            raise InputError(path, f"holds {count} trajectories; a motion is one. Keep one in the bag.", key=topic)
    return trajectories


def _check_files(path: Path) -> None:
    """Refuse what rosbags would wait for, or take long to parse."""
    if not path.is_dir():
        with open_regular(path, "bag", MAX_BAG_BYTES):
            return
    if not (path / METADATA).exists():
        raise InputError(path, f"this folder holds no {METADATA}; a ROS 2 bag does. Name the .mcap file by itself.")
    try:
        parse_yaml(read_text(path / METADATA, "description of a bag", MAX_YAML_BYTES))
    except ValueError as error:
        raise InputError(path / METADATA, f"this description of a bag {error}.") from None
    for file in path.iterdir():
        if not file.is_dir():
            with open_regular(file, "file of a bag", MAX_BAG_BYTES):
                pass


def _stamps(path: Path, topic: str, message: Any) -> NDArray[np.int64]:
    """Times of the points from the start, Shape (N,) [ns]."""
    times = [point.time_from_start for point in message.points]
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
