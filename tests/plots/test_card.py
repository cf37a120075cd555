"""The answer in one line with the nearest limits, and torque-speed curves where limits are shown."""

from dataclasses import replace

import numpy as np
import pytest
from changed_robots import with_left
from conftest import DATA
from random_motors import equipped

import mrts
from mrts.limits.rows import TORQUE_SPEED
from mrts.output.summary_lines import answer_lines
from mrts.plots import result_plots, write_plots
from mrts.plots.card import MOST_BARS, answer_card
from mrts.scaling.limit_use import limited_quantities, limited_rows, rate_uses

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
    torques = limited_quantities(result, "torque", "left")
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
    found = turned
    card, end = answer_card(found), found.range.upper
    ratio, durations, limit = card.outcome.split(" · ")
    assert float(ratio.split()[0]) == pytest.approx(np.sqrt(end.c2), rel=5e-3)  # three digits
    assert durations == f"{found.duration:.4g} s (given 0.8 s)"
    assert limit.startswith("limited by right/wrist_2_turn velocity (3.14159 rad/s), at ")
    assert float(limit.split()[-2]) == pytest.approx(end.time / np.sqrt(end.c2), rel=1e-3)
    used = limited_rows(found.trajectory)
    largest = np.sort(np.max(used.share, axis=0))[::-1][:MOST_BARS]
    assert [bar.share for bar in card.bars] == pytest.approx(largest.tolist())
    assert [bar.nearness for bar in card.bars] == ["reached", "near", "near", "free", "free"]
    for bar in card.bars:
        share = used.share[bar.sample, used.rows.index(bar.name)]
        assert found.trajectory.time[bar.sample] == bar.time
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
    worst, *_ = rate_uses(found)
    told = [bar for bar in answer_card(found).bars if bar.label.endswith("torque rate")]
    assert worst.share > 1.1
    assert [told[0].label, told[0].share, told[0].time] == [str(worst.name), pytest.approx(worst.share), worst.time]
