"""Bags of joint trajectories, written by the rosbags library alone."""

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

KIND = "trajectory_msgs/msg/JointTrajectory"

TYPES = get_typestore(Stores.ROS2_HUMBLE)

PARTS = ("positions", "velocities", "accelerations")


def trajectory(robot, followed, part):
    """A robot's trajectory as plain values: names, and for each point its stamp [ns], positions, rates."""
    values = {"positions": followed.q, "velocities": followed.dq, "accelerations": followed.ddq}
    columns = [values[name][:, part] for name in PARTS]
    stamps = np.rint(followed.object.time * 1e9).astype(int).tolist()
    return list(robot.joints), [[stamp, *rows] for stamp, *rows in zip(stamps, *columns, strict=True)]


def message(names, points):
    make = TYPES.types
    duration, point = make["builtin_interfaces/msg/Duration"], make["trajectory_msgs/msg/JointTrajectoryPoint"]
    header = make["std_msgs/msg/Header"](make["builtin_interfaces/msg/Time"](0, 0), "")
    listed = [point(*rows, np.zeros(0), duration(*divmod(stamp, 10**9))) for stamp, *rows in points]
    return make[KIND](header, names, listed)


def write_bag(folder, messages, storage=StoragePlugin.MCAP, types=TYPES):
    """A bag of one message a pair of topic and message, of any kinds, with their definitions."""
    with Writer(folder, version=9, storage_plugin=storage) as writer:
        kinds = {topic: content.__msgtype__ for topic, content in messages}
        topics = {topic: writer.add_connection(topic, kind, typestore=types) for topic, kind in kinds.items()}
        for topic, content in messages:
            writer.write(topics[topic], 1, types.serialize_cdr(content, content.__msgtype__))
    return folder
