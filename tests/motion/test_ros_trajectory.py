"""Motions from files that people have: tables by themselves, ROS 2 bags of joint trajectories, plans of MoveIt."""

import json
from pathlib import Path

import numpy as np
import pytest
from cell_bank import random_planar_cell
from conftest import DATA, UR5
from mcap_ros2.writer import Writer as IndependentWriter
from motion_tables import joint_table, object_table, write_motion
from ros_bags import KIND, PARTS, TYPES, message, trajectory, write_bag
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import mrts
from mrts.cli import main

ROBOT, DISPLAY = "moveit_msgs/msg/RobotTrajectory", "moveit_msgs/msg/DisplayTrajectory"

CASES = Path(__file__).parents[1] / "cases"
DEFINITION = (CASES / "joint_trajectory.msg").read_text(encoding="utf-8")
PLANNED = (CASES / "moveit_display_trajectory.msg").read_text(encoding="utf-8")
"""Definition of a DisplayTrajectory and of what it holds, as moveit_msgs 2 has them."""


def with_moveit(release=Stores.ROS2_HUMBLE):
    """The types of a release of ROS 2, and MoveIt's."""
    types = get_typestore(release)
    types.register(get_types_from_msg(PLANNED, DISPLAY))
    return types


MOVEIT = with_moveit()


def header():
    return TYPES.types["std_msgs/msg/Header"](TYPES.types["builtin_interfaces/msg/Time"](0, 0), "world")


def robot_trajectory(names, points, floating=()):
    """RobotTrajectory; joints of several degrees of freedom, in `floating`, stand still at one point."""
    make = MOVEIT.types
    point = make["trajectory_msgs/msg/MultiDOFJointTrajectoryPoint"]
    still = point([], [], [], make["builtin_interfaces/msg/Duration"](0, 0))
    others = make["trajectory_msgs/msg/MultiDOFJointTrajectory"](header(), list(floating), [still] if floating else [])
    return make[ROBOT](message(names, points), others)


def display(*planned):
    """DisplayTrajectory of some trajectories."""
    make = MOVEIT.types
    joints = make["sensor_msgs/msg/JointState"](header(), [], *[np.zeros(0)] * 3)
    floating = make["sensor_msgs/msg/MultiDOFJointState"](header(), [], [], [], [])
    start = make["moveit_msgs/msg/RobotState"](joints, floating, [], is_diff=False)
    return make[DISPLAY]("cell", list(planned), start)


MOTIONS = {"planar_dual_arm": "lift", "dual_ur5": "lift_and_turn"}


@pytest.fixture(scope="module")
def followed(dual_ur5):
    return mrts.follow_object(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))


@pytest.fixture(scope="module")
def given(dual_ur5, followed):
    """The trajectory of each robot of the spatial cell, by name."""
    return {
        robot.name: trajectory(robot, followed, part)
        for robot, part in zip(dual_ur5.robots, dual_ur5.joint_slices.values(), strict=True)
    }


@pytest.mark.parametrize("name", MOTIONS)
def test_what_scale_writes_it_reads_again(name, tmp_path):
    """A plan played as written has the torques of the plan, and a range that is its range by its c²."""
    cell, motion = DATA.parent / name / "cell.yaml", DATA.parent / name / f"{MOTIONS[name]}.yaml"
    bag, table, plan = tmp_path / "bag", tmp_path / "plan.csv", tmp_path / "plan.json"
    files = ["--ros-bag", str(bag), "--csv", str(table), "--json", str(plan)]
    assert main(["scale", str(cell), str(motion), "--c2", "0.8", *files]) == 0
    planned = json.loads(plan.read_text())
    (tmp_path / "motion.yaml").write_text("joints: bag/bag.mcap\n")
    for file in (bag, bag / "bag.mcap", table, tmp_path / "motion.yaml"):
        assert main(["scale", str(cell), str(file), "--c2", "1", "--json", str(tmp_path / "again.json")]) == 0
        again = json.loads((tmp_path / "again.json").read_text())
        assert again["c2"]["upper"] == pytest.approx(planned["c2"]["upper"] / 0.8, rel=1e-9)
        assert again["selected"]["duration"] == pytest.approx(planned["selected"]["duration"], abs=1e-9)
        for robot, torque in planned["torque"].items():
            np.testing.assert_allclose(again["torque"][robot], torque, atol=1e-8, err_msg=f"{file} {robot}")


def test_a_bag_of_another_writer_is_read(dual_ur5, followed, given, tmp_path):
    """The MCAP library's own writer: compressed chunks, no metadata.yaml, other topics in between."""
    path = tmp_path / "recorded.mcap"
    with path.open("wb") as file:
        writer = IndependentWriter(file)
        schema = writer.register_msgdef(KIND, DEFINITION)
        for robot, (names, points) in given.items():
            listed = [
                {
                    "time_from_start": dict(zip(("sec", "nanosec"), divmod(stamp, 10**9), strict=True)),
                    **{name: row.tolist() for name, row in zip(PARTS, rows, strict=True)},
                }
                for stamp, *rows in points
            ]
            content = {"joint_names": names, "points": listed}
            writer.write_message(f"/{robot}/arm_controller/joint_trajectory", schema, content, 5)
        text = writer.register_msgdef("std_msgs/msg/String", "string data")
        writer.write_message("/chatter", text, {"data": "hello"}, 6)
        writer.finish()
    table = mrts.load_motion(path)
    np.testing.assert_array_equal(table.positions["right/elbow"], followed.q[:, 8])
    np.testing.assert_array_equal(table.accelerations["left/wrist_3_turn"], followed.ddq[:, 5])
    expected = mrts.scale(dual_ur5, followed)
    assert mrts.scale(dual_ur5, table).range.upper.c2 == pytest.approx(expected.range.upper.c2, rel=1e-9)


@pytest.mark.quick
def test_a_topic_that_names_no_robot_is_told_by_its_joints(dual_ur5, given, tmp_path):
    """One arm has each name: it is meant. Two arms have it: the topic must say which."""
    case = random_planar_cell(np.random.default_rng(3), tmp_path, 1)
    alone = case.cell
    lift = mrts.follow_object(alone, case.motion)
    points = trajectory(alone.robots[0], lift, slice(0, 3))
    write_bag(tmp_path / "one", [("/joint_trajectory_controller/joint_trajectory", message(*points))])
    write_bag(tmp_path / "bare", [("/joint_trajectory", message(*points))])
    for bag in ("one", "bare"):
        carried = mrts.scale(alone, mrts.load_motion(tmp_path / bag), between=None)
        np.testing.assert_array_equal(carried.motion.q, lift.q)
    messages = [(f"/{robot}_controller/joint_trajectory", message(*points)) for robot, points in given.items()]
    write_bag(tmp_path / "two", messages)
    with pytest.raises(mrts.InputError, match=r"nothing is said of joint 'left/shoulder_pan' .*/left/joint_trajectory"):
        mrts.scale(dual_ur5, mrts.load_motion(tmp_path / "two"))
    names, rows = points
    doubled = [("/one/joint_trajectory", message(names, rows)), ("/other/joint_trajectory", message(names, rows))]
    write_bag(tmp_path / "doubled", doubled)
    with pytest.raises(mrts.InputError, match="'one/j0' and 'other/j0' are the same joint"):
        mrts.scale(alone, mrts.load_motion(tmp_path / "doubled"))
    named = [("/arm0/joint_trajectory", message(names, rows)), ("/other/joint_trajectory", message(names, rows))]
    write_bag(tmp_path / "named", named)  # the other arm is none of the cell's
    carried = mrts.scale(alone, mrts.load_motion(tmp_path / "named"), between=None)
    np.testing.assert_array_equal(carried.motion.q, lift.q)
    assert "other/j0" in carried.motion.remarks[0].text


def at(point, place, value, joint=...):
    """A change of one point: its stamp [ns], positions, velocities or accelerations, all or those of a joint."""

    def change(_names, points):
        if joint is ...:
            points[point][place] = value
        else:
            points[point][place][joint] = value

    return change


def second_elbow(names, _points):
    names[0] = "elbow"


MISTAKES = {
    "times differ": (at(40, 0, 321_000_000), "right/joint_trajectory: must have the times of /left/joint_traj"),
    "times back": (at(7, 0, 1), "right/joint_trajectory, point 7, time_from_start = 1e-09: must be later"),
    "no points": (lambda _, points: points.clear(), "has 0 points"),
    "short positions": (at(9, 1, np.zeros(5)), "point 9: has 5 positions for 6 joints"),
    "some velocities": (at(9, 2, np.zeros(0)), "point 9: has 0 velocities for 6 joints; other points have 6"),
    "infinite": (at(5, 3, np.inf, 2), "point 5, accelerations of elbow = inf"),
    "wrong rates": (at(50, 2, 57.0, 2), "right/elbow: its rates do not lead"),
    "twice a joint": (second_elbow, "right/joint_trajectory: the joint 'elbow' of"),
    "twice a topic": (lambda *_: "again", "right/joint_trajectory: holds 2 trajectories; a motion is one"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_in_a_trajectory(mistake, dual_ur5, given, tmp_path):
    """Of the right arm."""
    change, words = MISTAKES[mistake]
    names, points = given["right"]
    names, points = list(names), [[stamp, *(row.copy() for row in rows)] for stamp, *rows in points]
    times = 2 if change(names, points) == "again" else 1
    right = [("/right/joint_trajectory", message(names, points))] * times
    bag = write_bag(tmp_path / "bag", [("/left/joint_trajectory", message(*given["left"])), *right])
    with pytest.raises(mrts.InputError, check=lambda error: words in str(error) and str(bag) in str(error)):
        mrts.scale(dual_ur5, mrts.load_motion(bag))


def test_tables_are_recognised_by_their_columns(dual_ur5, followed, tmp_path):
    (tmp_path / "object.csv").write_text(object_table(followed.object, rates=True))
    (tmp_path / "JOINTS.CSV").write_text(joint_table(dual_ur5, followed))
    expected = mrts.scale(dual_ur5, followed).range.upper.c2
    for name, kind in (("object.csv", mrts.ObjectMotion), ("JOINTS.CSV", mrts.JointTable)):
        motion = mrts.load_motion(tmp_path / name)
        assert isinstance(motion, kind)
        assert mrts.scale(dual_ur5, motion).range.upper.c2 == pytest.approx(expected, rel=1e-7)


TOPIC = "/display_planned_path"


@pytest.fixture(scope="module")
def whole(given):
    """One trajectory of both arms, whose joints are called as in a machine of two equal arms."""
    names = [f"{robot}_{joint}" for robot, (joints, _) in given.items() for joint in joints]
    rows = [
        [one[0], *(np.concatenate(both) for both in zip(one[1:], other[1:], strict=True))]
        for one, other in zip(*(points for _, points in given.values()), strict=True)
    ]
    return names, rows


def test_a_plan_is_a_motion(dual_ur5, followed, whole, tmp_path):
    """Either kind, either storage, types of another release: the very joints, and those of a gripper passed over."""
    names, rows = whole
    gripped = [*names, "finger"], [[stamp, *(np.append(part, 0.0) for part in parts)] for stamp, *parts in rows]
    write_bag(tmp_path / "shown", [(TOPIC, display(robot_trajectory(*gripped)))], types=MOVEIT)
    write_bag(tmp_path / "planned", [("/plan", robot_trajectory(*whole))], StoragePlugin.SQLITE3, types=MOVEIT)
    newer = with_moveit(Stores.ROS2_JAZZY)
    write_bag(tmp_path / "newer", [(TOPIC, display(robot_trajectory(*whole)))], types=newer)
    for name in ("shown", "planned", "newer"):
        motion = mrts.load_motion(tmp_path / name)
        table = mrts.scale(dual_ur5, motion, between=None).motion
        np.testing.assert_array_equal(table.q, followed.q)
        np.testing.assert_array_equal(table.ddq, followed.ddq)


def test_which_trajectory_is_named(whole, tmp_path):
    names, rows = whole
    short = names, rows[:40]
    part = [robot_trajectory(*short), robot_trajectory(*whole)]
    write_bag(
        tmp_path / "plans", [(TOPIC, display(*part)), (TOPIC, display(robot_trajectory(names, rows[:7])))], types=MOVEIT
    )
    with pytest.raises(mrts.InputError, match=r"3 trajectories.*'joints: plans' and 'trajectory: 0' to 2") as told:
        mrts.load_motion(tmp_path / "plans")
    assert f"of 40, {len(rows)}, 7 points" in str(told.value)
    counts = [
        len(mrts.load_motion(write_motion(tmp_path, joints="plans", trajectory=which)).time) for which in range(3)
    ]
    assert counts == [40, len(rows), 7]
    with pytest.raises(mrts.InputError, match=r"display_planned_path: holds 3 .*there is no trajectory 3"):
        mrts.load_motion(write_motion(tmp_path, joints="plans", trajectory=3))
    with pytest.raises(mrts.InputError, match="trajectory = -1: must be >= 0"):
        mrts.load_motion(write_motion(tmp_path, joints="plans", trajectory=-1))
    (tmp_path / "table.csv").write_text("t,q.a/b\n0,1\n1,1\n")
    with pytest.raises(mrts.InputError, match=r"trajectory: is of a ROS 2 bag, but table\.csv is none"):
        mrts.load_motion(write_motion(tmp_path, joints="table.csv", trajectory=0))
    with pytest.raises(mrts.InputError, match="'file' does not go with: trajectory"):
        mrts.load_motion(write_motion(tmp_path, file="table.csv", trajectory=0))


def test_what_a_controller_plays_comes_before_what_a_planner_shows(whole, tmp_path):
    names, rows = whole
    messages = [(TOPIC, display(robot_trajectory(*whole))), ("/both/joint_trajectory", message(names, rows[:30]))]
    write_bag(tmp_path / "both", messages, types=MOVEIT)
    assert len(mrts.load_motion(tmp_path / "both").time) == 30
