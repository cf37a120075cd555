"""How much of its limits a motion uses and which rows bind where, against limits, ranges and torques themselves."""

import numpy as np
import pytest
from conftest import DATA, UR5

import mrts
from mrts.plots.plot import value_ends
from mrts.plots.range_plots import MOST_LANES, binding_lanes, spans
from mrts.plots.trajectory_plots import limit_shares

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
    most = np.max(found["velocity"].share, axis=0).tolist()
    assert most == sorted(most, reverse=True)
    assert most[0] == pytest.approx(1, abs=1e-6)


def test_the_directions_of_a_hands_friction_make_one_line():
    folder = DATA.parent / "squeeze"
    result = mrts.scale(mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(folder / "lift_and_turn.yaml"))
    (of,) = (of for of in limit_shares(result.trajectory) if of.kind == "contact")
    assert {*of.labels} >= {"left/pad normal force", "left/pad slips", "left/pad tips", "left/pad twists"}
    assert len(of.labels) == 4 * sum(len(robot.contacts) for robot in result.cell.robots)
    assert np.max(of.share) <= 1 + 1e-6


@pytest.mark.quick
def test_lanes_are_filled_exactly_where_their_rows_bind(dual_ur5, lift_and_turn):
    spatial = mrts.scale(dual_ur5.without_velocity_limits(), lift_and_turn)
    samples, lanes = spatial.range.samples, binding_lanes(spatial.range)
    assert len(lanes) == MOST_LANES  # 21 rows bind somewhere: the rest shares the last lane
    labels = [{row.label for row in spatial.range.binding(k, "upper")} for k in range(len(samples.time))]
    named = {lane.label for lane in lanes[:-1]}
    for lane in lanes[:-1]:
        assert lane.binds.tolist() == [lane.label in of_sample for of_sample in labels]
    assert lanes[-1].binds.tolist() == [bool(of_sample - named) for of_sample in labels]
    assert lanes[-1].label == f"{len(set.union(*labels) - named)} others"
    first = [row.label for row in spatial.range.upper.rows]
    assert [lane.label for lane in lanes if lane.sets] == first == [lane.label for lane in lanes[: len(first)]]


def test_conflicts_have_lanes_of_their_own(planar_cell, lift):
    found = mrts.scale(planar_cell.with_mass(24.0), lift).range
    lanes = [lane for lane in binding_lanes(found) if lane.kind == "conflict"]
    infeasible = {conflict.sample for conflict in found.samples.conflicts}
    assert set(np.flatnonzero(np.any([lane.binds for lane in lanes], axis=0)).tolist()) == infeasible
    assert {"left/elbow ↑", "right/elbow ↓"} <= {lane.label for lane in lanes}
    # c² ≥ 0 alone takes no lane
    assert {lane.kind for lane in binding_lanes(mrts.scale(planar_cell, lift).range)} == {"upper"}


def test_spans_reach_half_way_to_the_neighbours():
    time = np.array([0.0, 1.0, 2.0, 4.0])
    assert spans(time, np.array([True, False, True, True])) == [(0.0, 0.5), (1.5, 4.0)]
    assert spans(time, np.array([False, True, False, False])) == [(0.5, 1.5)]
    assert spans(time, np.zeros(4, dtype=bool)) == []


def test_axes_show_values_and_near_limits_but_not_far_ones():
    values = np.array([[-1.0], [2.0]])
    low, high = value_ends(values, np.array([[-4.0], [100.0]]))
    assert -5 < low < -4
    assert 2 < high < 3
    assert value_ends(np.zeros((2, 1)), np.array([[-3.0], [np.inf]]))[0] < -3
    assert value_ends(np.zeros((2, 1)), np.empty((2, 0))) == (-1.0, 1.0)
