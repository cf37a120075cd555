"""What the viewer shows, without a browser: torques, what is red, speeds on offer, configurations."""

from dataclasses import replace

import numpy as np
import pytest
from cell_bank import random_planar_cell, random_spatial_cell
from given_ranges import ranges_of
from shipped_cells import still_motion

import mrts
from mrts.base.errors import html_text
from mrts.scaling.range import intersect
from mrts.viewer.panel import outcome_html, speed_html
from mrts.viewer.player_state import offered_speeds, play, widened_torques

NEAR_END = 1e-6
"""Relative distance from the end of a sample's range at which rounding decides."""


@pytest.mark.quick
def test_it_starts_at_the_fastest_admissible_speed(planar_cell, lift):
    state, result = play(planar_cell, lift), mrts.scale(planar_cell, lift)
    np.testing.assert_array_equal(state.trajectory.torque, result.trajectory.torque)
    assert state.trajectory.c2 == result.range.upper.c2
    assert state.speeds.upper == pytest.approx(1.2 * state.trajectory.c, rel=0.01)
    # the slider shows three digits, but its end is the exact one
    state = state.at_speed(round(state.trajectory.c, state.speeds.digits))
    assert state.trajectory.c2 == result.range.upper.c2


@pytest.mark.parametrize(
    ("make", "arms"),
    [(random_planar_cell, 1), (random_planar_cell, 4), (random_spatial_cell, 2), (random_spatial_cell, 3)],
)
def test_a_sample_is_red_exactly_outside_its_own_range(make, arms, tmp_path):
    """Any number of arms, planar and spatial, with sliding joints; the oracle is the range."""
    rng = np.random.default_rng([7, arms])
    case = make(rng, tmp_path, arms)
    state = play(case.cell, case.motion)
    samples = state.result.range.samples
    finite = samples.upper[np.isfinite(samples.upper) & (samples.upper > 0)]
    seen = set()
    for c in np.sqrt(np.quantile(finite, [0.0, 0.3, 0.9]) if finite.size else np.ones(1)) * 1.01:
        state = state.at_speed(float(c))
        c2 = state.trajectory.c2
        beyond = (c2 > samples.upper) | (c2 < samples.lower)
        clear = np.abs(c2 - samples.upper) > NEAR_END * c2
        clear &= np.abs(c2 - samples.lower) > NEAR_END * c2
        np.testing.assert_array_equal((state.excess > 0)[clear], beyond[clear])
        seen |= set(beyond[clear].tolist())
        # whatever the limits say, the torques carry the object
        checked = replace(state.result, trajectory=state.trajectory).residuals()
        size = 1 + max(np.max(np.abs(state.trajectory.torque)), np.max(np.abs(state.trajectory.wrench)))
        assert max(checked.arms, checked.object) < 1e-9 * size
    assert True in seen


def test_torques_pass_the_end_of_the_range_without_a_jump(dual_ur5, lift_and_turn):
    state = play(dual_ur5, lift_and_turn)
    end, rule = state.trajectory, state.result.options
    torque, wrench = widened_torques(dual_ur5, state.result.motion, rule, end.c2 * (1 + 1e-7))
    np.testing.assert_allclose(torque, end.torque, atol=0.01)
    np.testing.assert_allclose(wrench, end.wrench, atol=0.01)


def test_an_infeasible_motion_still_plays(planar_cell, lift):
    state = play(planar_cell.with_mass(60.0), lift)
    assert state.result.trajectory is None
    assert state.trajectory.c == 1
    assert not state.admissible
    worst = max(conflict.widening for conflict in state.result.range.samples.conflicts)
    assert np.max(state.excess) >= worst * (1 - 1e-6)
    assert "these limits conflict" in outcome_html(state)
    assert "Outside the admissible range" in speed_html(state)


def test_at_rest_any_speed_plays(planar_cell, lift):
    state = play(planar_cell, still_motion(lift.position[0]))
    assert (state.trajectory.c, state.speeds.upper) == (1, 3)
    state = state.at_speed(3.0)
    assert state.admissible


@pytest.mark.parametrize(
    ("lower", "upper", "start", "high"),
    [
        ([0, 0], [4, 9], 2, 2.4),
        ([0], [0], 1, 2),  # the cell can only hold still
        ([4, 0], [9, 1], 1, 2.4),  # empty: from 2 on, but 1 at most
        ([0], [np.inf], 1, 3),
        ([16], [np.inf], 4, 4.8),
    ],
)
def test_speeds_on_offer_pass_both_ends(lower, upper, start, high):
    speeds = offered_speeds(intersect(ranges_of(lower, upper)))
    assert speeds.start == pytest.approx(start)
    assert speeds.upper == pytest.approx(high, rel=0.01)
    assert 0 < speeds.lower < speeds.start <= speeds.upper
    assert all(speeds.lower < np.sqrt(c2) < speeds.upper for c2 in speeds.ends)
    assert (speeds.upper - speeds.lower) / 10.0**-speeds.digits >= 400
    for c2 in speeds.ends:
        assert speeds.c2(round(float(np.sqrt(c2)), speeds.digits)) == c2
    between = speeds.start - 3 * 10.0**-speeds.digits
    assert speeds.c2(between) == between**2


def test_limits_that_are_passed_are_named_the_worst_first(dual_ur5, lift_and_turn):
    state = play(dual_ur5, lift_and_turn)
    assert state.violations() == []
    state = state.at_speed(state.speeds.upper)
    named = state.violations()
    assert named[0].name.kind == "velocity"
    assert [use.share for use in named] == sorted((use.share for use in named), reverse=True)
    assert named[0].share - 1 == pytest.approx(state.excess.max(), rel=1e-12)
    assert f"{html_text(named[0].name.short)} by 20 % at {named[0].time:.3g} s" in speed_html(state)
