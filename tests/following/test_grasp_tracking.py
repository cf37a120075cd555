"""Inverse kinematics of planar, spatial and redundant arms, how far they reach, and its outcomes."""

from dataclasses import replace

import numpy as np
import pytest
from followed_motions import motion
from published_robots import CASES, urdf_path

import mrts
from mrts.cell.generation import arm_of_urdf, read_urdf
from mrts.following.tracking import CLEARLY, arm_reach, branches_at_start, random_starts
from mrts.starting.arm import Arm


@pytest.mark.quick
def test_unreachable_names_robot_sample_and_distance(dual_ur5):
    with pytest.raises(
        mrts.MotionError, match=r"robot 'left' cannot reach .* sample \d+ .* reaches 0\.918409 m: .* m too far"
    ):
        mrts.follow_object(dual_ur5, motion([0.9, 0.1, 0.35]))
    with pytest.raises(
        mrts.MotionError, match=r"cannot reach its grasp at sample 200 .* its shoulder and reaches .* m too far"
    ):
        mrts.follow_object(dual_ur5, motion([0.0, 0.1, 2.0], start=(0, 0.1, 1.9)))
    too_near = dual_ur5.with_values({"robots.left.base.xyz": [-0.25, 0.1, 0.35]})
    with pytest.raises(mrts.MotionError, match=r"'left' cannot reach its grasp at sample 0 .* 41 starts were tried"):
        mrts.follow_object(too_near, motion([0.03, 0.2, 0.5]))


def limited(cell, index, lower, upper):
    robots = list(cell.robots)
    robots[index] = replace(robots[index], position_lower=lower, position_upper=upper)
    return replace(cell, robots=tuple(robots))


def test_further_starts_are_tried_where_the_posture_leads_past_a_limit(dual_ur5):
    given = motion([0.03, 0.2, 0.5])
    free = mrts.follow_object(dual_ur5, given)
    assert free.remarks == ()
    upper = np.array([free.q[0, 6] - 0.01, np.inf, 3.2, np.inf, 7.0, 7.0])
    cell = limited(dual_ur5, 1, np.array([-3.2, -np.inf, -np.inf, -np.inf, -3.2, -3.2]), upper)
    moved = mrts.follow_object(cell, given)
    assert [remark.code for remark in moved.remarks] == ["other-start"]
    assert "'right'" in moved.remarks[0].text
    assert np.all(moved.q[:, 6:] <= upper)
    np.testing.assert_allclose(moved.q[:, :6], free.q[:, :6], atol=1e-9)
    np.testing.assert_array_equal(mrts.follow_object(cell, given).q, moved.q)
    away = limited(dual_ur5, 1, np.full(6, 2.0), np.full(6, 2.1))
    with pytest.raises(mrts.MotionError, match=r"'right' passes a position limit at sample 0 .* 41 starts were tried"):
        mrts.follow_object(away, given)


GIVEN_MISTAKES = {
    "one joint off": (lambda m: replace(m, q=m.q + 0.01 * np.eye(12)[4]), "'left' is off its grasp"),
    "no velocities": (lambda m: replace(m, dq=0 * m.dq), "velocities do not fit"),
    "no accelerations": (lambda m: replace(m, ddq=0 * m.ddq), "accelerations do not fit"),
}


@pytest.mark.quick
def test_a_motion_given_by_hand_is_checked(dual_ur5):
    followed = mrts.follow_object(dual_ur5, motion([0.03, 0.2, 0.5]))
    for spoil, message in GIVEN_MISTAKES.values():
        with pytest.raises(mrts.MotionError, match=message):
            mrts.scale(dual_ur5, spoil(followed))


DRAWN = 20_000

NEARLY = {6: 0.999, 7: 0.9}
"""Share of the bound that the furthest of the drawn positions reaches, by joints: seven are seldom all stretched."""


@pytest.mark.quick
@pytest.mark.parametrize("name", CASES)
def test_no_joint_positions_reach_further_and_some_nearly_as_far(name):
    urdf, tip = CASES[name]
    path = urdf_path(urdf)
    arm = Arm(*arm_of_urdf(path, read_urdf(path, path.parent, str(path))[1], None, tip), path)
    shoulder, wrist, longest = arm_reach(arm.robot)
    state = arm.at(np.random.default_rng(4).uniform(-np.pi, np.pi, (DRAWN, arm.com.shape[0])))
    distance = np.linalg.norm(state.p + state.R @ wrist - shoulder, axis=1)
    assert np.max(distance) <= longest + CLEARLY
    assert np.max(distance) > NEARLY[len(arm.com)] * longest


@pytest.mark.quick
def test_both_branches_reach_and_the_posture_chooses(planar_cell, lift):
    for index in range(2):
        first, second = branches_at_start(planar_cell, index, lift)
        assert np.sign(np.sin(first[1])) == -np.sign(np.sin(second[1]))
    up_up = mrts.follow_object(planar_cell, lift)
    assert (np.sign(up_up.q[:, 1]) == -1).all()
    assert (np.sign(up_up.q[:, 4]) == 1).all()
    down_up = mrts.follow_object(planar_cell.with_postures({"left": [0.5, 2.1, -2.6]}), lift)
    assert (np.sign(down_up.q[:, 1]) == 1).all()
    assert (np.sign(down_up.q[:, 4]) == 1).all()


@pytest.mark.quick
def test_random_starts_are_inside_limits_beyond_half_a_turn(planar_cell):
    robot = replace(planar_cell.robots[0], position_lower=np.full(3, 3.5), position_upper=np.full(3, 6.0))
    assert np.all(np.abs(random_starts(robot, 5)[1:] - 4.75) <= 1.25)


@pytest.mark.quick
@pytest.mark.parametrize(("xyz", "rpy"), [((1.25, 1.2, 0.1), (0, 0, 0)), ((1.25, 1.2, 0), (0.1, 0, 0))])
def test_a_path_out_of_the_plane_is_refused(planar_cell, xyz, rpy):
    with pytest.raises(mrts.MotionError, match="leaves the plane xy"):
        mrts.follow_object(planar_cell, motion(xyz, rpy, start=(1.25, 1.0, 0.0), duration=0.5))
