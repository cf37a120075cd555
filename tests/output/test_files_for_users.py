"""Files that planners hand on: CSV tables and ROS 2 bags, read back by independent readers."""

import csv
from itertools import pairwise

import numpy as np
import pytest
from conftest import DATA
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import mrts

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


def test_a_merged_bag_has_one_trajectory_of_all_arms(turned, dual_ur5, tmp_path):
    """Joints that both arms have are told apart by their robot, and the bag is a motion again."""
    mrts.write_ros_bag(turned, tmp_path / "bag", merged=True)
    ((_, _, trajectory),) = messages(tmp_path / "bag" / "bag.mcap", ["/joint_trajectory"])
    done = turned.trajectory
    assert trajectory.joint_names == [name.replace("/", "_") for name in dual_ur5.joint_names]
    for field, values in (("positions", done.q), ("accelerations", done.ddq), ("effort", done.torque)):
        np.testing.assert_array_equal([getattr(point, field) for point in trajectory.points], values)
    topics = {topic for _, topic, _ in messages(tmp_path / "bag" / "bag.mcap")}
    assert topics == {"/joint_trajectory", "/joint_states", "/left/contact_wrench", "/right/contact_wrench"}
    again = mrts.scale(dual_ur5, mrts.load_motion(tmp_path / "bag"), 1.0, between=None)
    np.testing.assert_array_equal(again.motion.q, done.q)
    cell = mrts.load_cell(DATA.parent / "upper_body" / "cell.yaml")  # one machine: no name is there twice
    unlike = mrts.scale(cell, mrts.load_motion(DATA.parent / "upper_body" / "lift.yaml"), between=None)
    mrts.write_ros_bag(unlike, tmp_path / "machine", merged=True)
    ((_, _, trajectory),) = messages(tmp_path / "machine" / "machine.mcap", ["/joint_trajectory"])
    assert trajectory.joint_names == [joint for robot in cell.robots for joint in robot.joints]


@pytest.mark.parametrize("write", [mrts.write_trajectory_csv, mrts.write_ros_bag])
def test_every_format_is_written_whole_or_not_at_all(write, turned, planar_cell, lift, tmp_path):
    write(turned, tmp_path / "written")
    with pytest.raises(mrts.InputError, match="none to write"):
        write(mrts.scale(planar_cell.with_mass(100.0), lift), tmp_path / "nothing")
    (tmp_path / "file").write_text("")
    with pytest.raises(mrts.InputError, match="cannot be written"):
        write(turned, tmp_path / "file" / "below")
    assert {path.name for path in tmp_path.iterdir()} == {"written", "file"}
