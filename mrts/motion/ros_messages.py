# SPDX-License-Identifier: MIT
"""ROS 2 bags: messages, and joint motion from trajectories of controllers or of MoveIt; needs the extra 'ros'."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, require_extra
from mrts.base.input_file import LARGEST_NUMBER, read_text
from mrts.base.regular_file import is_folder, open_regular
from mrts.base.yaml_text import MAX_YAML_BYTES, parse_yaml
from mrts.motion.joint_table import JointTable

NANOSECONDS = 1_000_000_000
"""A second in the unit of a bag's time stamps."""

METADATA = "metadata.yaml"

MAX_BAG_BYTES = 500_000_000
"""Of one file; a trajectory of a million points takes half of it."""


@cache
def message_types() -> Any:
    """The message types of the oldest ROS 2 that is supported; the ones used here have not changed since."""
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415 (an extra, needed when a bag is)

    return get_typestore(Stores.ROS2_HUMBLE)


def is_bag(path: Path) -> bool:
    """Whether a path names a bag: a folder, or one of its files by itself."""
    return is_folder(path) or path.suffix.lower() in {".mcap", ".db3"}


def joint_column(topic: str, joint: str) -> str:
    """What a joint of a topic is called: after the topic's first name, as in /ROBOT/joint_states."""
    return f"{topic.strip('/').partition('/')[0]}/{joint}"


def bag_messages(path: Path, *kinds: str) -> dict[str, list[tuple[int, Any]]]:
    """All messages of some types; of types that ROS 2 itself does not have, as the bag defines them.

    Returns:
        By topic in the order of their names: when each was recorded [ns], and the message.

    Raises:
        InputError: If the extra 'ros' is missing, it is no bag, or holds no such message.
    """
    require_extra(path, "ros", "rosbags")
    from rosbags.rosbag2 import Reader  # noqa: PLC0415 (an extra, needed when a bag is)

    _check_files(path)
    found: dict[str, list[tuple[int, Any]]] = {}
    try:
        with Reader(path) as bag:
            topics = sorted(bag.topics)
            wanted = [connection for connection in bag.connections if connection.msgtype in kinds]
            types = {connection.id: _types_of(path, connection) for connection in wanted}
            for connection, stamp, data in bag.messages(wanted) if wanted else ():
                message = types[connection.id].deserialize_cdr(data, connection.msgtype)
                found.setdefault(connection.topic, []).append((stamp, message))
    except InputError:
        raise
    except Exception as error:  # noqa: BLE001 (what the reader raises of damaged bags is no short list)
        reason = " ".join(str(error).split()) or type(error).__name__  # a YAML error draws where it is
        raise InputError(path, f"cannot be read as a ROS 2 bag: {reason}") from None
    if not found:
        raise InputError(path, f"holds no message {' or '.join(kinds)}; its topics are {', '.join(topics) or 'none'}.")
    return dict(sorted(found.items()))


def _types_of(path: Path, connection: Any) -> Any:
    if connection.msgtype in message_types().types:
        return message_types()
    from rosbags.interfaces import MessageDefinitionFormat  # noqa: PLC0415 (an extra, needed when a bag is)
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415

    if connection.msgdef.format != MessageDefinitionFormat.MSG:
        raise InputError(
            path,
            f"does not define {connection.msgtype}, as bags of ROS 2 before Iron in SQLite do not. Record it in MCAP: "
            "`ros2 bag record --storage mcap`, or convert it: `ros2 bag convert`.",
            key=connection.topic,
        )
    types = get_typestore(Stores.EMPTY)  # all of them as the bag has them: those of another release may differ
    types.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
    return types


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


KIND = "trajectory_msgs/msg/JointTrajectory"
OF_MOVEIT = "moveit_msgs/msg/RobotTrajectory", "moveit_msgs/msg/DisplayTrajectory"
"""Read where a bag has no messages of `KIND`: what a planner shows, a controller mostly plays."""

DERIVATIVES = ("positions", "velocities", "accelerations")
"""Parts of a trajectory's points that are a motion."""


def read_joint_trajectories(path: Path, samples: int | None, trajectory: int | None = None) -> JointTable:
    """Read the joint trajectories of a bag, one a topic, as one motion.

    The first name of a topic, as in /ROBOT/joint_trajectory, is that of a robot; if the cell has none of this name, its
    joints are found by their own names. Points with velocities and accelerations are taken as they are; without
    accelerations they lie on the spline of their velocities, with positions only on the C² spline through these. Effort
    is passed over. Trajectories that the cell needs have the same times; others, a gripper's for example, may not.

    Args:
        samples: Number of samples on the spline; None takes the times of the points.
        trajectory: Which trajectory of a topic, counted from 0 through its messages, each of which may hold several;
            None where there is one.

    Raises:
        InputError: If it is no bag, holds no trajectory that can be read, or a trajectory breaks a rule.
    """
    time, (q, dq, ddq), unusable = joint_columns(path, _trajectories(path), trajectory)
    ddq = {name: column for name, column in ddq.items() if name in dq}
    return JointTable(path, time, q, dq, ddq, samples=samples, unusable=unusable)


def joint_columns(
    path: Path, trajectories: dict[str, list[Any]], which: int | None, parts: tuple[str, ...] = DERIVATIVES
) -> tuple[Array, list[dict[str, Array]], dict[str, InputError]]:
    """Times of trajectories by topic, Shape (N,) [s] from 0, their parts by column, and columns with other times.

    Raises:
        InputError: If no trajectory can be read, or two are of the same joint.
    """
    usable: dict[str, tuple[Any, NDArray[np.int64]]] = {}
    unusable: dict[str, InputError] = {}
    failure: InputError | None = None
    for name, planned in trajectories.items():
        try:
            message = _chosen(path, name, planned, which)
            usable[name] = message, _point_stamps(path, name, message)
        except InputError as error:
            unusable |= dict.fromkeys(_names(name, planned[0]) if planned else [], error)
            failure = failure or error
    if failure is not None and not usable:
        raise failure

    def joints_at(stamps: NDArray[np.int64]) -> int:
        return sum(len(message.joint_names) for message, at in usable.values() if np.array_equal(at, stamps))

    first = max(usable, key=lambda name: joints_at(usable[name][1]))
    stamps = usable[first][1]
    found: dict[str, dict[str, Array]] = {part: {} for part in parts}
    for name, (message, at) in usable.items():
        names = _names(name, message)
        if not np.array_equal(at, stamps):
            rule = f"must have the times of {first}: the arms move together."
            unusable |= dict.fromkeys(names, InputError(path, rule, key=name))
            continue
        for part, columns in found.items():
            values = _point_values(path, name, message, part)
            for column, numbers in zip(names, values.T, strict=False):
                if column in columns:
                    robot, _, joint = column.rpartition("/")
                    raise InputError(path, f"the joint '{joint}' of '{robot}' has another trajectory.", key=name)
                columns[column] = numbers
    return (stamps - stamps[0]) / NANOSECONDS, [*found.values()], unusable


def _names(topic: str, message: Any) -> list[str]:
    return [joint_column(topic, joint) for joint in message.joint_names]


def _trajectories(path: Path) -> dict[str, list[Any]]:
    found = bag_messages(path, KIND, *OF_MOVEIT)
    listed = {name: [message for _, message in messages] for name, messages in found.items()}
    played = {name: messages for name, messages in listed.items() if messages[0].__msgtype__ == KIND}
    # what is displayed may hold several
    return played or {
        name: [
            _of_joints(path, name, part) for message in messages for part in getattr(message, "trajectory", [message])
        ]
        for name, messages in listed.items()
    }


def _of_joints(path: Path, topic: str, planned: Any) -> Any:
    others = planned.multi_dof_joint_trajectory
    if len(others.points):
        names = ", ".join(others.joint_names)
        raise InputError(
            path,
            f"moves joints of several degrees of freedom ({names}): a base that drives or floats, say. The bases of a "
            "cell stand still. Plan for the arms alone.",
            key=topic,
        )
    return planned.joint_trajectory


def _chosen(path: Path, topic: str, planned: list[Any], which: int | None) -> Any:
    if which is None and len(planned) == 1:
        return planned[0]
    if which is not None and which < len(planned):
        return planned[which]
    count = f"holds {len(planned)} trajectories"
    if which is not None or not planned:
        raise InputError(path, f"{count}, counted from 0; there is no trajectory {which or 0}.", key=topic)
    sizes = ", ".join(str(len(part.points)) for part in planned)
    raise InputError(
        path,
        f"{count}; a motion is one. Say which in a motion file, 'joints: {path.name}' and 'trajectory: 0' to "
        f"{len(planned) - 1} (of {sizes} points).",
        key=topic,
    )


def _point_stamps(path: Path, topic: str, planned: Any) -> NDArray[np.int64]:
    """Times of a trajectory's points from its start, strictly increasing, Shape (N,) [ns]."""
    times = [point.time_from_start for point in planned.points]
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


def _point_values(path: Path, topic: str, message: Any, part: str) -> Array:
    """A part of a trajectory's points, such as positions: Shape (N, joints), or (N, 0) where it is not given."""
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
