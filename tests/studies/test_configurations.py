"""All inverse-kinematics branches, followed and ranked."""

import numpy as np
import pytest
from eaik.IK_HP import HPRobot

import mrts


def six_joint_branches(robot, motion):
    """Joint positions that hold the grasp at t = 0, Shape (count, 6); some may be least-squares only."""
    corners = np.concatenate([np.zeros((1, 3)), robot.points, robot.T_base_tip.p[None]])
    solver = HPRobot(robot.axes, np.diff(corners, axis=0))
    assert solver.hasKnownDecomposition()
    base, pose = robot.T_world_base, np.eye(4)
    # the package counts rotations from the tip's own at joint positions zero
    pose[:3, :3] = base.R.T @ motion.rotation[0] @ robot.T_object_tip.R @ robot.T_base_tip.R.T
    pose[:3, 3] = base.R.T @ (motion.position[0] + motion.rotation[0] @ robot.T_object_tip.p - base.p)
    return np.asarray(solver.IK(pose).Q, dtype=np.float64).reshape(-1, 6)


@pytest.fixture(scope="module")
def unhurried(dual_ur5):
    """Velocity limits would make many configurations equal."""
    return dual_ur5.without_velocity_limits()


@pytest.fixture(scope="module")
def study(unhurried, lift_and_turn):
    return mrts.rank_configurations(unhurried, lift_and_turn)


def test_two_ur5_class_arms_have_eight_times_eight_configurations(study):
    assert {name: len(branches) for name, branches in study.branches.items()} == {"left": 8, "right": 8}
    assert len(study.ranked) == 64
    assert len({tuple(b.number for b in c.branches) for c in study.ranked}) == 64
    values = [(float(f"{one.c2_upper:.8e}"), one.joint_margin) for one in study.ranked]
    assert values == sorted(values, reverse=True)
    assert values[0][0] > 1.5 * values[-1][0]  # the configuration matters


def test_random_starts_find_what_an_analytic_inverse_finds(study, unhurried, lift_and_turn):
    for robot in unhurried.robots:
        ours = np.array([branch.start for branch in study.branches[robot.name]])
        theirs = six_joint_branches(robot, lift_and_turn)
        apart = (ours[:, None] - theirs + np.pi) % (2 * np.pi) - np.pi
        assert np.max(np.min(np.max(np.abs(apart), axis=2), axis=0)) < 1e-9
        assert len(theirs) == len(ours) == 8


def test_a_configuration_is_what_scale_finds_from_its_posture(study, unhurried, lift_and_turn):
    for configuration in (study.ranked[0], study.ranked[31], study.ranked[-1]):
        cell = unhurried.with_postures(configuration.postures())
        scaled = mrts.scale(cell, lift_and_turn)
        assert scaled.range.upper.c2 == pytest.approx(configuration.c2_upper, rel=1e-9)
        most = np.concatenate([robot.position_upper for robot in cell.robots])  # of either sign
        margin = np.min(most - np.abs(scaled.motion.q))
        assert margin == pytest.approx(configuration.joint_margin, abs=1e-6)


@pytest.mark.quick
def test_the_papers_configurations(planar_cell, lift):
    """Section 6.3: up-up before the two mixed ones before down-down; flipped arms agree with `mrts demo`."""
    study = mrts.rank_configurations(planar_cell, lift)
    assert [configuration.c2_upper for configuration in study.ranked] == pytest.approx(
        [3.0618125, 2.4287932, 2.4287932, 2.4234572], rel=1e-4
    )
    even = mrts.rank_configurations(planar_cell, lift, sharing=mrts.LoadSharing())
    assert even.ranked[0].c2_upper == pytest.approx(2.9598285, rel=1e-6)
