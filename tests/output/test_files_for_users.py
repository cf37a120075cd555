"""Files that planners hand on: CSV tables and ROS 2 bags, read back by independent readers."""

import csv
from itertools import pairwise

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import mrts
from mrts.output import TRAJECTORY_FORMATS

pytestmark = pytest.mark.quick


def messages(path, topics=None):
    """Schema, topic and decoded message of a bag, by a reader that shares nothing with the writer."""
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return [
            (schema.name, channel.topic, message)
            for schema, channel, _, message in reader.iter_decoded_messages(topics=topics)
        ]


def test_a_bag_holds_what_controllers_expect(turned, tmp_path):
    bag = tmp_path / "deep" / "lift"
    mrts.write_ros_bag(turned, bag)
    assert sorted(path.name for path in bag.iterdir()) == ["lift.mcap", "metadata.yaml"]
    assert [path.name for path in bag.parent.iterdir()] == ["lift"]  # nothing temporary is left
    seen = {}
    for schema, topic, message in messages(bag / "lift.mcap"):
        seen.setdefault(topic, []).append((schema, message))
    done = turned.trajectory
    stamps = np.rint(done.time * 1e9)
    for robot in turned.cell.robots:
        joints, wrenches = turned.cell.joint_slices[robot.name], turned.cell.wrench_slices[robot.name]
        ((schema, trajectory),) = seen[f"/{robot.name}/joint_trajectory"]
        assert schema == "trajectory_msgs/msg/JointTrajectory"
        assert trajectory.joint_names == list(robot.joints)
        points = trajectory.points
        at = [point.time_from_start.sec * 10**9 + point.time_from_start.nanosec for point in points]
        assert at == stamps.tolist()
        assert all(later > earlier for earlier, later in pairwise(at))
        for field, values in (("positions", done.q), ("velocities", done.dq), ("accelerations", done.ddq)):
            np.testing.assert_array_equal([getattr(point, field) for point in points], values[:, joints])
        np.testing.assert_array_equal([point.effort for point in points], done.torque[:, joints])
        states = [message for _, message in seen[f"/{robot.name}/joint_states"]]
        np.testing.assert_array_equal([state.position for state in states], done.q[:, joints])
        np.testing.assert_array_equal([state.effort for state in states], done.torque[:, joints])
        forces = [message.wrench for _, message in seen[f"/{robot.name}/contact_wrench"]]
        six = [[w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y, w.torque.z] for w in forces]
        np.testing.assert_array_equal(six, done.wrench[:, wrenches])
    assert len(seen) == 3 * len(turned.cell.robots)


def test_a_table_gives_every_number_back(turned, tmp_path):
    mrts.write_trajectory_csv(turned, tmp_path / "trajectory.csv")
    head, *rows = csv.reader((tmp_path / "trajectory.csv").read_text().splitlines())
    table = dict(zip(head, np.array(rows, dtype=float).T, strict=True))
    done = turned.trajectory
    np.testing.assert_array_equal(table["t"], done.time)
    np.testing.assert_array_equal(table["tau.left/elbow"], turned.torque["left"][:, 2])
    np.testing.assert_array_equal(table["dq.right/shoulder_pan"], done.dq[:, 6])
    np.testing.assert_array_equal(table["F.right/nz"], turned.wrench["right"][:, 5])
    assert len(head) == 1 + 4 * 12 + 12


@pytest.mark.parametrize("name", TRAJECTORY_FORMATS)
def test_every_format_is_written_whole_or_not_at_all(name, turned, planar_cell, lift, tmp_path):
    form = TRAJECTORY_FORMATS[name]
    form.write(turned, tmp_path / "written")
    assert (tmp_path / "written").is_dir() == form.is_folder
    with pytest.raises(mrts.InputError, match="none to write"):
        form.write(mrts.scale(planar_cell.with_mass(100.0), lift), tmp_path / "nothing")
    (tmp_path / "file").write_text("")
    with pytest.raises(mrts.InputError, match="cannot be written"):
        form.write(turned, tmp_path / "file" / "below")
    assert {path.name for path in tmp_path.iterdir()} == {"written", "file"}
