"""Plans as MoveIt leaves them in bags: RobotTrajectory and DisplayTrajectory, as the bag itself defines them."""

import numpy as np
import pytest
from conftest import UR5
from motion_tables import write_motion
from moveit_bags import MOVEIT, display, robot_trajectory, with_moveit
from ros_bags import trajectory, write_bag
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores

import mrts

TOPIC = "/display_planned_path"


@pytest.fixture(scope="module")
def followed(dual_ur5):
    return mrts.follow_object(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))


@pytest.fixture(scope="module")
def whole(dual_ur5, followed):
    """One trajectory of both arms, whose joints are called as in a machine of two equal arms."""
    parts = [
        trajectory(robot, followed, part)
        for robot, part in zip(dual_ur5.robots, dual_ur5.joint_slices.values(), strict=True)
    ]
    names = [f"{robot.name}_{joint}" for robot in dual_ur5.robots for joint in robot.joints]
    rows = [
        [one[0], *(np.concatenate(both) for both in zip(one[1:], other[1:], strict=True))]
        for one, other in zip(parts[0][1], parts[1][1], strict=True)
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
    assert "0: 40 points of 12 joints" in str(told.value)
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
