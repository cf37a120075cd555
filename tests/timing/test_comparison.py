"""What a timing is only compared with: found when it is first read, the same as `mrts.scale` finds."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import mrts


def test_a_timing_leaves_the_factor_until_it_is_read(planar_cell, lift):
    found = mrts.retime(planar_cell, lift)
    copied = pickle.loads(pickle.dumps(found))  # noqa: S301 (our own)
    assert "factor" not in vars(found.compared)
    assert "range" not in vars(found.retimed)
    assert copied.summary() == found.summary()
    best = mrts.scale(planar_cell, lift)
    assert found.factor.c2 == best.trajectory.c2
    assert found.constant.range.to_json() == best.range.to_json()
    assert found.factor is replace(found, explanation="").factor is found.compared.factor


def test_noise_that_sets_the_range_is_told_with_the_timing(planar_cell, lift):
    """Rates of the object are as rough as the hands allow."""
    of, rough = lift, lift.acceleration.copy()
    rough[:, 1] += 0.3 * np.max(np.abs(rough[:, 1])) * np.random.default_rng(5).standard_normal(len(rough))
    noisy = mrts.ObjectMotion(of.time, of.position, of.rotation, of.twist, rough, smooth=False)
    motion = mrts.follow_object(planar_cell, noisy)
    assert "noise" in {remark.code for remark in mrts.retime(planar_cell, motion).warnings}


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
