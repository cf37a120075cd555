# SPDX-License-Identifier: MIT
"""The scaled trajectory as a ROS 2 bag in MCAP format; needs the extra 'ros' (rosbags)."""

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.atomic_file import make_folder_atomically
from mrts.base.errors import InputError, as_path
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.motion.ros_messages import NANOSECONDS, message_types
from mrts.output.trajectory_table import played_rows, trajectory_to_write
from mrts.scaling.scale import ScalingResult

if TYPE_CHECKING:
    from rosbags.rosbag2 import Writer

Stamps = NDArray[np.int64]

BAG_VERSION: Literal[9] = 9
"""Of rosbag2's metadata: what ROS 2 Iron and later write; Humble reads the MCAP file itself."""


def write_ros_bag(result: ScalingResult, folder: Path | str, *, merged: bool = False) -> None:
    """Write a bag: folder/metadata.yaml and folder/NAME.mcap, whole or not at all.

    Topics, for each robot: /ROBOT/joint_trajectory (trajectory_msgs/JointTrajectory, one message with positions,
    velocities, accelerations and effort feed-forward, joints named as in the URDF, times from the start strictly
    increasing), /ROBOT/joint_states (sensor_msgs/JointState) and /ROBOT/contact_wrench (geometry_msgs/WrenchStamped on
    the object at the contact, in the robot's base axes) at every sample. Where motors have friction also
    /ROBOT/joint_friction (sensor_msgs/JointState with effort alone): the part of the effort that overcomes it.

    Args:
        result: A result with a trajectory.
        folder: A new one.
        merged: Whether joints of all robots are in one message each, /joint_trajectory, /joint_states and
            /joint_friction, as one controller of all arms takes them; joints whose names several robots have are then
            called ROBOT_JOINT.

    Raises:
        InputError: If there is no trajectory, or the folder exists or cannot be made.
    """
    done = trajectory_to_write(result)
    folder = as_path("folder", folder)
    if folder.exists():
        raise InputError(folder, "exists already: a bag is written into a new folder. Remove it, or name another.")
    rows = played_rows(done)
    stamps = np.rint(rows["t"] * NANOSECONDS).astype(np.int64)
    if not np.all(np.diff(stamps) > 0):
        raise InputError(folder, "samples lie less than a nanosecond apart at this speed, which ROS cannot tell apart.")
    make_folder_atomically(folder, lambda bag: _write(result, rows, stamps, bag, merged=merged))


def _write(result: ScalingResult, rows: dict[str, Array], stamps: Stamps, bag: Path, *, merged: bool) -> None:
    from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: PLC0415 (an extra, needed when a bag is)

    cell = result.cell
    groups = [(f"/{robot.name}", list(robot.joints), cell.joint_slices[robot.name]) for robot in cell.robots]
    if merged:
        groups = [("", _unique_names(cell), slice(None))]
    with Writer(bag, version=BAG_VERSION, storage_plugin=StoragePlugin.MCAP) as writer:
        for prefix, names, part in groups:
            own = {name: values[:, part] for name, values in rows.items() if name not in {"t", "F"}}
            _add(writer, f"{prefix}/joint_trajectory", [(0, _trajectory(names, stamps, own))])
            states = _joint_states(names, stamps, own["tau"], own["q"], own["dq"])
            _add(writer, f"{prefix}/joint_states", states)
            if "tau_friction" in own:
                _add(writer, f"{prefix}/joint_friction", _joint_states(names, stamps, own["tau_friction"]))
        for robot in cell.robots:
            six = np.zeros((len(stamps), 6))
            six[:, cell.wrench_rows] = rows["F"][:, cell.wrench_slices[robot.name]]
            wrenches = [(int(stamp), _wrench(robot, int(stamp), six[k])) for k, stamp in enumerate(stamps)]
            _add(writer, f"/{robot.name}/contact_wrench", wrenches)


def _unique_names(cell: Cell) -> list[str]:
    """Joints as in the URDF, ROBOT_JOINT where several robots have one of that name."""
    count = Counter(joint for robot in cell.robots for joint in robot.joints)
    return [joint if count[joint] == 1 else f"{robot.name}_{joint}" for robot in cell.robots for joint in robot.joints]


def _add(writer: "Writer", topic: str, messages: list[tuple[int, Any]]) -> None:
    kind = messages[0][1].__msgtype__
    connection = writer.add_connection(topic, kind, typestore=message_types())
    for stamp, message in messages:
        writer.write(connection, stamp, message_types().serialize_cdr(message, kind))


def _message(kind: str, **fields: Any) -> Any:
    return message_types().types[kind](**fields)


def _time(kind: str, stamp: int) -> Any:
    return _message(f"builtin_interfaces/msg/{kind}", sec=stamp // NANOSECONDS, nanosec=stamp % NANOSECONDS)


def _header(stamp: int, frame: str) -> Any:
    return _message("std_msgs/msg/Header", stamp=_time("Time", stamp), frame_id=frame)


def _trajectory(names: list[str], stamps: Stamps, rows: dict[str, Array]) -> Any:
    points = [
        _message(
            "trajectory_msgs/msg/JointTrajectoryPoint",
            positions=rows["q"][k],
            velocities=rows["dq"][k],
            accelerations=rows["ddq"][k],
            effort=rows["tau"][k],
            time_from_start=_time("Duration", stamp),
        )
        for k, stamp in enumerate(stamps.tolist())
    ]
    kind = "trajectory_msgs/msg/JointTrajectory"
    return _message(kind, header=_header(0, ""), joint_names=names, points=points)


def _joint_states(names: list[str], stamps: Stamps, effort: Array, *motion: Array) -> list[tuple[int, Any]]:
    q, dq = motion or [np.zeros((len(stamps), 0))] * 2
    kind = "sensor_msgs/msg/JointState"
    return [
        (stamp, _message(kind, header=_header(stamp, ""), name=names, position=q[k], velocity=dq[k], effort=effort[k]))
        for k, stamp in enumerate(stamps.tolist())
    ]


def _wrench(robot: Robot, stamp: int, six: Array) -> Any:
    force, torque = (
        _message("geometry_msgs/msg/Vector3", x=float(part[0]), y=float(part[1]), z=float(part[2]))
        for part in (six[:3], six[3:])
    )
    wrench = _message("geometry_msgs/msg/Wrench", force=force, torque=torque)
    return _message("geometry_msgs/msg/WrenchStamped", header=_header(stamp, f"{robot.name}/base"), wrench=wrench)
