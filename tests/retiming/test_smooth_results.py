"""What a smooth result carries beside its timing, and how it says it."""

import numpy as np
import pytest

import mrts
from mrts.retiming.result import RetimingStatus
from mrts.retiming.retimed_motion import FastestPiece


@pytest.fixture(scope="module")
def smooth(planar_cell, lift):
    return mrts.retime(planar_cell, lift, rates=11.0)


def test_a_smooth_result_carries_the_fastest_timing_that_it_is_measured_against(smooth, planar_cell, lift):
    fastest = mrts.retime(planar_cell, lift)
    (own,), (bare,) = smooth.smooth.fastest, fastest.pieces
    assert isinstance(own, FastestPiece)
    np.testing.assert_array_equal(own.x, bare.x)
    assert np.sum(own.segment_times) == pytest.approx(smooth.smooth.bound, rel=1e-12)
    assert smooth.smooth.bound == fastest.duration < smooth.duration
    (piece,) = smooth.pieces
    np.testing.assert_allclose(piece.arc[[0, -1]], own.arc[[0, -1]], rtol=1e-9)
    assert np.max(piece.arc_speed) < np.max(own.arc_speed)


def test_the_retimed_motion_says_what_it_keeps_and_how_far(smooth):
    played = smooth.retimed
    assert played.rule.rates is smooth.smooth.rates
    assert played.excess.share == smooth.excess.share
    assert played.excess.row == smooth.excess.row
    assert played.sentence().startswith(
        f"smooth timing of a path that was given 0.5236 s: {smooth.duration:.4g} s. It is"
    )
    assert "; as it is now, rates apart, c² ∈ [0, " in played.sentence()  # its range is that of the other limits


def test_what_passes_between_nodes_is_told_at_the_time_that_it_is_played(planar_cell, lift):
    bare = mrts.retime(planar_cell, lift, rates=11.0, between=None)
    assert bare.status is RetimingStatus.LOCALLY_AT_SAMPLES
    given, own = bare.motion.object.time, bare.retimed.motion.object.time
    assert bare.retimed.excess.time == np.interp(bare.excess.time, given, own)
    assert bare.retimed.excess.time < bare.duration < given[-1]


def test_why_there_is_no_smooth_timing_has_its_limits_in_json(planar_cell, lift):
    found = mrts.retime(planar_cell, lift, rates=11.0, least_energy_in=0.1)
    assert not found.status.admits_motion
    said = found.to_json()
    assert said["smooth"]["goal"] == {"time": 0.0, "energy": 1.0, "longest": 0.1}
    assert said["kept_rates"]["torque"] == [1100, 880, 550] * 2
    assert "profile" not in said
