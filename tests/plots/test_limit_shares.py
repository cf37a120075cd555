"""How much of its limits a motion uses, against the limits as the cell gives them."""

import numpy as np
import pytest
from conftest import DATA, UR5

import mrts
from mrts.plots.limit_shares import limit_shares

ROUNDING = 1e-9
"""Rows and their limits are the same numbers, divided in another order."""


def test_shares_are_values_by_limits(dual_ur5):
    result = mrts.scale(dual_ur5, mrts.load_motion(UR5 / "lift_and_turn.yaml"))
    done = result.trajectory
    found = {of.kind: of for of in limit_shares(done)}
    assert list(found) == ["torque", "wrench", "velocity"]
    for robot in dual_ur5.robots:
        joints, part = dual_ur5.joint_slices[robot.name], dual_ur5.wrench_slices[robot.name]
        for joint, torque, velocity, name in zip(
            range(len(robot.joints)), done.torque[:, joints].T, done.dq[:, joints].T, robot.joints, strict=True
        ):
            label = f"{robot.name}/{name}"
            expected = np.abs(torque) / np.where(torque > 0, robot.torque_upper[joint], -robot.torque_lower[joint])
            of = found["torque"]
            np.testing.assert_allclose(of.share[:, of.labels.index(label)], expected, atol=ROUNDING)
            of = found["velocity"]
            expected = np.abs(velocity) / robot.velocity_limit[joint]
            np.testing.assert_allclose(of.share[:, of.labels.index(label)], expected, atol=ROUNDING)
        fx = np.abs(done.wrench[:, part][:, 0]) / robot.wrench_upper[0]
        of = found["wrench"]
        np.testing.assert_allclose(of.share[:, of.labels.index(f"{robot.name}/fx")], fx, atol=ROUNDING)
        assert f"{robot.name}/fz" not in of.labels  # which has no limit
    most = [np.max(found["velocity"].share[:, line]) for line in found["velocity"].ranked]
    assert most == sorted(most, reverse=True)
    assert most[0] == pytest.approx(np.max(found["velocity"].largest)) == pytest.approx(1, abs=1e-6)


def test_the_directions_of_a_hands_friction_make_one_line():
    folder = DATA.parent / "squeeze"
    result = mrts.scale(mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(folder / "lift_and_turn.yaml"))
    (of,) = (of for of in limit_shares(result.trajectory) if of.kind == "contact")
    assert of.labels[:4] == ("left/pad normal force", "left/pad slips", "left/pad tips", "left/pad twists")
    assert len(of.labels) == 4 * sum(len(robot.contacts) for robot in result.cell.robots)
    assert np.max(of.share) <= 1 + 1e-6
