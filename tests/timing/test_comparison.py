"""What a timing is only compared with: found when it is first read, the same as `mrts.scale` finds."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import mrts
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_ranges import motion_ranges
from mrts.scaling.motion_remarks import REMARKED, interpolated_timing
from mrts.scaling.range import intersect

BETWEEN_SHARE = 1e-3  # samples that a comparison adds move a duration by what the segments between samples cost


@pytest.fixture(scope="module")
def timed(planar_cell, lift):
    return mrts.retime(planar_cell, lift)


def test_a_timing_leaves_the_factor_until_it_is_read(planar_cell, lift):
    found = mrts.retime(planar_cell, lift)
    assert "factor" not in vars(found.compared)
    assert "range" not in vars(found.retimed)
    best = mrts.scale(planar_cell, lift)
    assert found.factor.c2 == best.trajectory.c2
    assert found.constant.range.to_json() == best.range.to_json()
    assert found.factor is replace(found, explanation="").factor is found.compared.factor


def test_what_was_not_read_can_be_read_of_a_copy(timed, planar_cell, lift):
    copied = pickle.loads(pickle.dumps(mrts.retime(planar_cell, lift)))  # noqa: S301 (our own)
    assert "factor" not in vars(copied.compared)
    assert copied.summary() == timed.summary()
    assert copied.retimed.range.to_json() == timed.retimed.range.to_json()
    np.testing.assert_array_equal(copied.retimed.trajectory.torque, timed.retimed.trajectory.torque)


def test_the_range_of_the_plan_is_that_of_its_motion(timed, planar_cell):
    own = intersect(motion_ranges(motion_rows(planar_cell, timed.retimed.motion), "kernel"))
    assert timed.retimed.range.to_json() == own.to_json()
    assert timed.retimed.range is timed.retimed.range
    assert timed.retimed.status is own.status
    assert timed.retimed.range.upper.c2 == pytest.approx(1, abs=BETWEEN_SHARE)


def test_what_is_read_later_is_of_the_numbers_that_were_given(planar_cell, lift):
    weights, inner = np.array([1.0, 2, 3, 3, 2, 1]), np.zeros(6)
    found = mrts.retime(planar_cell, lift, weights=weights, sharing=mrts.LoadSharing(None, inner))
    effort = found.effort
    best = mrts.scale(planar_cell, lift, weights=weights, sharing=mrts.LoadSharing(None, inner))
    weights[:], inner[:] = 7, 5
    assert found.effort == effort
    np.testing.assert_array_equal(found.constant.trajectory.torque, best.trajectory.torque)


def test_samples_that_the_factor_takes_are_none_of_the_timing(planar_cell, lift):
    """Its range is looked at between the samples in its own way; the timing looks between its own."""
    motion = mrts.follow_object(planar_cell, lift)
    found = mrts.retime(planar_cell, motion)
    own = mrts.retime(planar_cell, found.constant.motion)
    assert set(found.motion.object.time) >= set(motion.object.time)
    assert found.duration == pytest.approx(own.duration, rel=BETWEEN_SHARE)


def test_noise_that_sets_the_range_is_told_with_the_timing(one_noisy):
    cell, motion = one_noisy
    found, best = mrts.retime(cell, motion), mrts.scale(cell, motion)
    noise = [remark for remark in best.warnings if remark.code == "noise"]
    assert noise
    assert noise[0] in found.warnings


@pytest.fixture
def one_noisy(planar_cell, lift):
    """A motion whose rates are those of rounded positions, as far as the hands allow."""
    motion = mrts.follow_object(planar_cell, lift)
    rng = np.random.default_rng(5)
    rough = motion.object.acceleration.copy()
    rough[:, 1] += 0.3 * np.max(np.abs(rough[:, 1])) * rng.standard_normal(len(rough))
    of = motion.object
    noisy = mrts.ObjectMotion(of.time, of.position, of.rotation, of.twist, rough, smooth=False)
    return planar_cell, mrts.follow_object(planar_cell, noisy)


@pytest.mark.parametrize("stride", [5, 1])
def test_arms_that_cannot_hold_the_object_between_samples_are_told_at_once(stride, planar_cell, lift):
    """Between few samples, and on a course that a user wrote between any number of them."""
    few = lift.time[::stride]
    position, rotation, twist, acceleration = lift.course(few)
    step = few[1]

    def away(time):
        p, *others = lift.course(time)
        return (p + np.outer(5 * np.sin(np.pi * time / step) ** 2, [1, 0, 0]), *others)

    given = mrts.ObjectMotion(few, position, rotation, twist, acceleration, smooth=False, course=away)
    with pytest.raises(mrts.MotionError, match="between the samples"):
        mrts.retime(planar_cell, given)
    assert mrts.retime(planar_cell, given, between=None).status.admits_motion


def test_what_a_spline_between_few_rows_costs_is_told(planar_cell, lift):
    rows = mrts.ObjectMotion(lift.time, *lift.course(lift.time), smooth=False)
    table, known = mrts.follow_object(planar_cell, rows), mrts.follow_object(planar_cell, lift)
    (remark,) = interpolated_timing(table, 0.5, 0.51)
    assert (remark.code, "2 % longer than 0.5 s" in remark.text) == ("between-samples", True)
    assert not interpolated_timing(table, 0.5, 0.5 * (1 + REMARKED / 2))
    assert not interpolated_timing(known, 0.5, 0.51)


def test_a_question_that_the_cell_does_not_answer_is_refused_at_once(planar_cell, lift):
    with pytest.raises(mrts.InputError, match="says nothing of how its load varies"):
        mrts.retime(planar_cell, lift, load="guaranteed")
