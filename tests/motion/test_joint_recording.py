"""Recordings of joints: tables and bags say the same, and what is wrong with one is said by file, column and rule."""

import numpy as np
import pytest
from motor_recordings import exact_recording, random_motors, write_recording
from ros_bags import TYPES
from rosbags.rosbag2 import StoragePlugin, Writer

import mrts

STATE = "sensor_msgs/msg/JointState"
START = 1_700_000_000 * 10**9
"""Of a clock that counts from 1970 [ns]."""


def state(stamp, joints, position, effort):
    make = TYPES.types
    header = make["std_msgs/msg/Header"](make["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9)), "")
    return make[STATE](header, list(joints), np.asarray(position, float), np.zeros(0), np.asarray(effort, float))


def write_states(folder, messages):
    """A bag of states: topic, when it was recorded [ns], message."""
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = {
            topic: writer.add_connection(topic, STATE, typestore=TYPES) for topic in {each[0] for each in messages}
        }
        for topic, stamp, message in messages:
            writer.write(topics[topic], stamp, TYPES.serialize_cdr(message, STATE))
    return folder


@pytest.fixture(scope="module")
def recorded(planar_cell):
    """Names, times, positions and efforts of both arms for a tenth of a second."""
    return exact_recording(planar_cell, random_motors(6), seconds=0.1)


def states(recorded, *, header=True):
    """Two robots on topics of their own, the first in halves and in turned order, as controllers publish them."""
    joints, time, q, effort = recorded
    messages = []
    for row, t in enumerate(time):
        stamp = START + round(t * 1e9)
        for robot, columns in (("left", [2, 0]), ("left", [1]), ("right", [5, 4, 3])):
            listed = [joints[column].partition("/")[2] for column in columns]
            content = state(stamp if header else 0, listed, q[row, columns], effort[row, columns])
            messages.append((f"/{robot}/joint_states", stamp + (7 if header else 0), content))
    return messages


@pytest.mark.quick
@pytest.mark.parametrize("header", [True, False])
def test_a_bag_says_what_a_table_says(recorded, tmp_path, header):
    """Times are those of the headers, or of the recorder where headers have none."""
    bag = mrts.load_recording(write_states(tmp_path / "bag", states(recorded, header=header)))
    table = mrts.load_recording(write_recording(tmp_path / "recorded.csv", *recorded))
    assert set(bag.joints) == set(table.joints) == set(recorded[0])
    assert (bag.unusable, table.unusable) == ({}, {})
    for name, joint in table.joints.items():
        np.testing.assert_allclose(bag.joints[name].time, joint.time, atol=1e-9)
        np.testing.assert_allclose(bag.joints[name].position, joint.position, rtol=1e-7)
        np.testing.assert_allclose(bag.joints[name].effort, joint.effort, rtol=1e-7)
    assert repr(table) == f"<JointRecording from recorded.csv: {', '.join(recorded[0])}>"


def broken(recorded, kind):
    """Messages of a bag with one mistake."""
    messages = states(recorded)
    topic, _, message = messages[0]
    if kind == "no efforts":
        for _, _, each in messages:
            each.effort = np.zeros(0)
    if kind == "not a number":
        message.effort[0] = np.nan
    if kind == "back in time":
        message.header.stamp.sec += 1
    if kind == "two topics":
        messages += [("/left/again", *each[1:]) for each in messages if each[0] == topic]
    return messages


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("no efforts", "effort of wrist: no message holds one; efforts are needed"),
        ("not a number", r"message 1, effort of wrist = nan: must be a finite number in every message"),
        ("back in time", "message 2 of shoulder, header.stamp: is earlier than that of the message before"),
        ("two topics", "the joint 'shoulder' is recorded in another topic as well"),
    ],
)
def test_states_that_cannot_be_used_are_refused_by_name(planar_cell, recorded, tmp_path, kind, said):
    bag = write_states(tmp_path / "bag", broken(recorded, kind))
    with pytest.raises(mrts.InputError, match=said, check=lambda error: error.where == str(bag)):
        mrts.identify(planar_cell, bag)
