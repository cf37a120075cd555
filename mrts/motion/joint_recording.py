# SPDX-License-Identifier: MIT
"""What was measured of moving joints: positions and efforts, each joint at times of its own; from tables and bags."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, as_path
from mrts.base.formats.record import Shape, check_attributes
from mrts.base.input_file import LARGEST_NUMBER
from mrts.motion.csv_motion import read_joint_columns
from mrts.motion.ros_messages import NANOSECONDS, bag_messages, is_bag, joint_column

KIND = "sensor_msgs/msg/JointState"

NUMBERS = Shape("N", finite=True, least=-LARGEST_NUMBER, most=LARGEST_NUMBER)


@dataclass(frozen=True, eq=False)
class RecordedJoint:
    """What was measured of one joint.

    Attributes:
        time: Shape (N,) [s], strictly increasing.
        position: Shape (N,) [rad or m].
        effort: Torque or force of the motor, joint side of its gear, Shape (N,) [N m or N].

    Raises:
        InputError: If a number is not finite, shapes differ, or times do not increase.
    """

    time: Annotated[Array, NUMBERS]
    position: Annotated[Array, NUMBERS]
    effort: Annotated[Array, NUMBERS]

    def __post_init__(self) -> None:
        check_attributes(self, RecordedJoint, "joint")
        if len(self.time) < 2 or np.min(np.diff(self.time)) <= 0:  # noqa: PLR2004 (start and end)
            raise InputError("joint", "must be at least two times that strictly increase.", key="time")


@dataclass(frozen=True, repr=False)
class JointRecording:
    """Recorded joints by column name; which joint of a cell a column is, `mrts.identify` finds.

    Attributes:
        path: The file, for messages.
        joints: By "robot/joint".
        unusable: Columns that say too little, and why; raised when a cell needs one.
    """

    path: Path
    joints: dict[str, RecordedJoint]
    unusable: dict[str, InputError]

    def __repr__(self) -> str:
        return f"<JointRecording from {self.path.name}: {', '.join(self.joints)}>"


def load_recording(path: Path | str) -> JointRecording:
    """Read what was measured of moving joints.

    Args:
        path: A CSV table with t and, for every joint, `q.ROBOT/JOINT` and `tau.ROBOT/JOINT`, or a ROS 2 bag (a folder
            or one of its files; needs the extra 'ros') with messages sensor_msgs/JointState that have positions and
            efforts. Measured velocities are passed over: positions say the same, with a noise that is known.

    Raises:
        InputError: If the file is missing, malformed, or holds no efforts.
    """
    path = as_path("path", path)
    return _from_bag(path) if is_bag(path) else _from_table(path)


def _from_table(path: Path) -> JointRecording:
    time, parts = read_joint_columns(path)
    if not parts["q"]:
        raise InputError(path, "holds no column q.ROBOT/JOINT: a recording has positions and efforts of joints.")
    if not parts["tau"]:
        raise InputError(path, "holds no column tau.ROBOT/JOINT: efforts are needed, in N m (N of a prismatic joint).")
    joints, unusable = dict[str, RecordedJoint](), dict[str, InputError]()
    for name, q in parts["q"].items():
        if name in parts["tau"]:
            joints[name] = RecordedJoint(time, q, parts["tau"][name])
        else:
            unusable[name] = InputError(path, f"holds no column tau.{name}: the effort of every joint is needed.")
    return JointRecording(path, joints, unusable)


def _from_bag(path: Path) -> JointRecording:
    joints: dict[str, RecordedJoint] = {}
    unusable: dict[str, InputError] = {}
    found = bag_messages(path, KIND)
    with_positions = {
        topic: messages for topic, messages in found.items() if any(len(message.position) for _, message in messages)
    }
    by_topic = with_positions or found  # a plan's friction is a topic of efforts alone
    stamps_of = {topic: _stamps(messages) for topic, messages in by_topic.items()}
    first = min(int(np.min(stamps)) for stamps in stamps_of.values())  # seconds since 1970 leave few digits for steps
    for topic, messages in by_topic.items():
        stamps = stamps_of[topic] - first
        for joint, rows in _rows(stamps, [message for _, message in messages]).items():
            name = joint_column(topic, joint)
            if name in joints or name in unusable:
                joints.pop(name, None)
                rule = f"the joint '{joint}' is recorded in another topic as well: keep one of them in the bag."
                unusable[name] = InputError(path, rule, key=topic)
                continue
            try:
                joints[name] = _joint(path, topic, joint, rows)
            except InputError as error:
                unusable[name] = error
    if not joints:
        raise next(iter(unusable.values()), InputError(path, f"its messages {KIND} name no joint."))
    return JointRecording(path, joints, unusable)


def _stamps(messages: list[tuple[int, Any]]) -> NDArray[np.int64]:
    """When each message was measured [ns]: by its header, or, where a header has no time, when it was recorded."""
    headers = [message.header.stamp for _, message in messages]
    stamps = np.array([stamp.sec * NANOSECONDS + stamp.nanosec for stamp in headers], dtype=np.int64)
    return stamps if np.all(stamps > 0) else np.array([stamp for stamp, _ in messages], dtype=np.int64)


def _rows(stamps: NDArray[np.int64], messages: list[Any]) -> dict[str, list[tuple[float, ...]]]:
    """Stamp [ns], position and effort of every joint; no number where a message has none.

    A message may have some of the joints, in any order.
    """
    rows: dict[str, list[tuple[float, ...]]] = {}
    for stamp, message in zip(stamps.tolist(), messages, strict=True):
        none = [np.nan] * len(message.name)
        given = (of if len(of) == len(none) else none for of in (message.position, message.effort))
        for joint, *values in zip(message.name, *given, strict=True):
            rows.setdefault(joint, []).append((stamp, *values))
    return rows


def _joint(path: Path, topic: str, joint: str, rows: list[tuple[float, ...]]) -> RecordedJoint:
    stamps, *values = np.array(rows, dtype=np.float64).T
    for part, column in zip(("position", "effort"), values, strict=True):
        if np.all(np.isnan(column)):
            raise InputError(path, f"no message holds one; {part}s are needed.", key=f"{topic}, {part} of {joint}")
        wrong = np.flatnonzero(~(np.abs(column) <= LARGEST_NUMBER))
        if wrong.size:
            key = f"{topic}, message {wrong[0] + 1}, {part} of {joint}"
            raise InputError(path, "must be a finite number in every message.", key=key, value=float(column[wrong[0]]))
    if np.any(np.diff(stamps) < 0):
        message = int(np.argmax(np.diff(stamps) < 0)) + 2
        key = f"{topic}, message {message} of {joint}, header.stamp"
        raise InputError(path, "is earlier than that of the message before.", key=key)
    new = np.concatenate([[True], np.diff(stamps) > 0])
    if np.count_nonzero(new) < 2:  # noqa: PLR2004 (start and end)
        raise InputError(path, "one message is no motion.", key=f"{topic}, {joint}")
    return RecordedJoint(*(of[new] for of in (stamps / NANOSECONDS, *values)))
