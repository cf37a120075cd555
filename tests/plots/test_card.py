"""The answer in one line with the nearest limits: the numbers of the result."""

from dataclasses import replace

import numpy as np
import pytest

import mrts
from mrts.plots.card import MOST_BARS, answer_card
from mrts.plots.limit_shares import all_shares
from mrts.scaling.limit_use import rate_uses

pytestmark = pytest.mark.quick


def test_the_card_has_speed_durations_and_the_limit_that_decides(turned):
    found = turned
    card, end = answer_card(found), found.range.upper
    ratio, durations, limit = card.outcome.split(" · ")
    assert float(ratio.split()[0]) == pytest.approx(np.sqrt(end.c2), rel=5e-3)  # three digits
    assert durations == f"{found.duration:.4g} s (given 0.8 s)"
    assert limit.startswith("limited by right/wrist_2_turn velocity, 3.142 rad/s, at ")
    assert float(limit.split()[-2]) == pytest.approx(end.time / np.sqrt(end.c2), rel=1e-3)
    names, shares = all_shares(found)
    largest = np.sort(np.max(shares, axis=0))[::-1][:MOST_BARS]
    assert [bar.share for bar in card.bars] == pytest.approx(largest.tolist())
    assert [bar.nearness for bar in card.bars] == ["reached", "near", "near", "free", "free"]
    for bar in card.bars:
        row = [str(name) for name in names].index(bar.label)
        share = shares[np.flatnonzero(found.trajectory.time == bar.time)[0], row]
        assert share == pytest.approx(bar.share, abs=5e-4)


def test_a_slower_speed_says_what_would_be_possible_and_an_infeasible_one_why_not(planar_cell, lift):
    slower = answer_card(mrts.scale(planar_cell, lift, 1.0)).outcome
    assert slower.startswith(
        "1 × as fast · 0.5236 s (given 0.5236 s) · up to 1.75 × as fast, limited by left/elbow torque ↑"
    )
    heavy = answer_card(mrts.scale(planar_cell.with_mass(24.0), lift))
    assert heavy.bars == ()
    assert heavy.outcome.startswith("no speed keeps all limits · worst conflict at t = 0 s: left/elbow ↑")
    assert answer_card(mrts.retime(planar_cell.with_mass(24.0), lift)).outcome.startswith("no timing: ")


def test_of_rates_that_pass_their_limits_the_worst_is_told_with_its_moment(dual_ur5, lift_and_turn):
    rate = np.array([100.0, 100.0, 100.0, 3.0, 20.0, 10.0])
    robots = [replace(robot, motors=replace(robot.motors, torque_rate=rate)) for robot in dual_ur5.robots]
    found = mrts.scale(replace(dual_ur5, robots=tuple(robots)), lift_and_turn)
    worst, *_ = rate_uses(found)
    told = [bar for bar in answer_card(found).bars if bar.label.endswith("torque rate")]
    assert worst.share > 1.1
    assert [told[0].label, told[0].share, told[0].time] == [str(worst.name), pytest.approx(worst.share), worst.time]
