"""How much of its limits a motion uses and which rows bind where, against limits, ranges and torques themselves."""

from dataclasses import replace

import numpy as np
import pytest
from changed_robots import with_left
from conftest import DATA
from random_motors import equipped

import mrts
from mrts.limits.rows import TORQUE_SPEED
from mrts.plots import result_plots, write_plots
from mrts.plots.card import MOST_BARS, answer_card, answer_lines
from mrts.plots.plot import value_ends
from mrts.plots.range_plots import MOST_LANES, binding_lanes, spans
from mrts.plots.trajectory_plots import limit_shares

pytestmark = pytest.mark.quick

CURVE = np.array([[0, 120.0], [1, 110], [6, 10]])
"""Of the left shoulder and elbow, whose torque limits are 100 and 80 N m: its lines cross them within the lift."""


def largest(speed):
    """What the curve gives at a speed, by interpolation between its corners [N m]."""
    return np.interp(np.abs(speed), *CURVE.T)


def test_limits_of_the_torque_are_what_the_curve_gives_where_the_motor_drives(planar_cell, lift):
    motors = replace(planar_cell.robots[0].motors, torque_speed=(CURVE, CURVE, None))
    result = mrts.scale(with_left(planar_cell, motors=motors), lift)
    done = result.trajectory
    torques = done.quantities.of("torque", "left")
    for j, plain in enumerate(result.cell.robots[0].torque_upper[:2]):
        dq = done.dq[:, j]
        forward = np.minimum(plain, np.where(dq > 0, largest(dq), plain))
        backward = -np.minimum(plain, np.where(dq < 0, largest(dq), plain))
        np.testing.assert_allclose(torques.upper[:, j], forward, rtol=1e-12)
        np.testing.assert_allclose(torques.lower[:, j], backward, rtol=1e-12)
    assert np.ptp(torques.upper[:, 0]) + np.ptp(torques.lower[:, 0]) > 1
    assert np.ptp(torques.upper[:, 2]) == 0  # the wrist has no curve
    assert np.all(torques.values <= torques.upper + 1e-6)
    assert np.all(torques.values >= torques.lower - 1e-6)


def test_hands_and_motors_of_all_kinds_are_drawn_together(tmp_path):
    """Rows of every kind that a cell file has, in figures, report, table, saved result and words."""
    shipped = DATA.parent / "squeeze"
    cell = mrts.load_cell(shipped / "cell.yaml")
    real = equipped(cell, armature=0.1, coulomb=1.0, viscous=0.5, torque_speed=[[0, 200.0], [4, 20]], rated=30.0)
    result = mrts.scale(real, mrts.load_motion(shipped / "lift_and_turn.yaml"))
    kinds = {use.name.kind for use in result.uses}
    assert kinds >= {"torque", "velocity", "contact", TORQUE_SPEED, "motor speed"}
    write_plots(result_plots(result), tmp_path / "plots")
    mrts.write_report(result, tmp_path / "report.html")
    mrts.save_result(result, tmp_path / "result.npz")
    again = mrts.load_result(tmp_path / "result.npz")
    assert list(answer_lines(again, answer_card(again))) == list(answer_lines(result, answer_card(result)))
    np.testing.assert_array_equal(again.trajectory.friction, result.trajectory.friction)
    assert {row[0] for row in result.limits_table().rows} == {use.label for use in result.uses}


def test_the_card_has_speed_durations_and_the_limit_that_decides(turned):
    card, end = answer_card(turned), turned.range.upper
    ratio, durations, limit = card.outcome.split(" · ")
    assert float(ratio.split()[0]) == pytest.approx(np.sqrt(end.c2), rel=5e-3)  # three digits
    assert durations == f"{turned.duration:.4g} s (given 0.8 s)"
    assert limit.startswith("limited by right/wrist_2_turn velocity (3.14159 rad/s), at ")
    assert float(limit.split()[-2]) == pytest.approx(end.time / np.sqrt(end.c2), rel=1e-3)
    used = turned.trajectory.quantities.limited
    largest = np.sort(np.max(used.share, axis=0))[::-1][:MOST_BARS]
    assert [bar.share for bar in card.bars] == pytest.approx(largest.tolist())
    assert [bar.nearness for bar in card.bars] == ["reached", "near", "near", "free", "free"]
    for bar in card.bars:
        share = used.share[bar.sample, used.rows.index(bar.name)]
        assert turned.trajectory.time[bar.sample] == bar.time
        assert share == pytest.approx(bar.share, abs=5e-4)


def test_a_slower_speed_says_what_would_be_possible_and_an_infeasible_one_why_not(planar_cell, lift):
    slower = answer_card(mrts.scale(planar_cell, lift, 1.0)).outcome
    assert slower.startswith(
        "1 × as fast · 0.5236 s (given 0.5236 s) · up to 1.75 × as fast, limited by left/elbow torque (upper, 80 N m)"
    )
    heavy = answer_card(mrts.scale(planar_cell.with_mass(24.0), lift))
    assert heavy.bars == ()
    assert heavy.outcome.startswith("no speed keeps all limits · at 51 of 101 samples; at t = 0 s left/elbow ↑")
    assert answer_card(mrts.retime(planar_cell.with_mass(24.0), lift)).outcome.startswith("no timing: ")


def test_of_rates_that_pass_their_limits_the_worst_is_told_with_its_moment(dual_ur5, lift_and_turn):
    rate = np.array([100.0, 100.0, 100.0, 3.0, 20.0, 10.0])
    robots = [replace(robot, motors=replace(robot.motors, torque_rate=rate)) for robot in dual_ur5.robots]
    found = mrts.scale(replace(dual_ur5, robots=tuple(robots)), lift_and_turn)
    worst, *_ = found.rate_uses
    told = [bar for bar in answer_card(found).bars if bar.label.endswith("torque rate")]
    assert worst.share > 1.1
    assert [told[0].label, told[0].share, told[0].time] == [str(worst.name), pytest.approx(worst.share), worst.time]


ROUNDING = 1e-9
"""Rows and their limits are the same numbers, divided in another order."""


def test_shares_are_values_by_limits(dual_ur5, turned):
    done = turned.trajectory
    found = {of.kind: of for of in limit_shares(done)}
    assert list(found) == ["torque", "wrench", "velocity"]
    for robot in dual_ur5.robots:
        joints, part = dual_ur5.joint_slices[robot.name], dual_ur5.wrench_slices[robot.name]
        for joint, torque, velocity, name in zip(
            range(len(robot.joints)), done.torque[:, joints].T, done.dq[:, joints].T, robot.joints, strict=True
        ):
            label = f"{robot.name}/{name}"
            limit = np.where(torque > 0, robot.torque_upper[joint], -robot.torque_lower[joint])
            for kind, expected in (("torque", torque / limit), ("velocity", velocity / robot.velocity_limit[joint])):
                own = found[kind].share[:, found[kind].labels.index(label)]
                np.testing.assert_allclose(own, np.abs(expected), atol=ROUNDING)
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
