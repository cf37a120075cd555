"""Paths that have no fastest timing; stops and end speeds of those that have one, and what they are compared with."""

import json
from collections import Counter

import numpy as np
import pytest
from cell_bank import random_planar_cell
from changed_robots import with_left, with_robots
from gantries import gantries, straight, there_and_back

import mrts
from mrts.base.rigid_transform import RigidTransform
from mrts.motion.object_motion import ObjectMotion


@pytest.mark.quick
def test_limits_that_conflict_are_named(planar_cell, lift):
    """100 kg may only fall."""
    found = mrts.retime(planar_cell.with_mass(100.0), lift)
    assert found.status.value == "start speed not admissible"
    assert found.retimed is None
    assert found.pieces == ()
    assert "cannot start from rest at t = 0 s (sample 0); these conflict: left/elbow" in found.explanation
    assert found.conflict.widening > 0


def retimed(seed, folder):
    case = random_planar_cell(np.random.default_rng([32, seed]), folder, 1 + seed % 3, samples=41)
    return mrts.retime(case.cell, case.motion)


def test_random_cells_have_every_outcome_and_each_is_explained(tmp_path):
    seen = Counter()
    for seed in range(40):
        found = retimed(seed, tmp_path)
        seen[found.status.value] += 1
        assert found.status.admits_motion == (found.explanation == "") == (found.retimed is not None), seed
        if found.conflict is not None:
            assert "conflict" in found.explanation, seed
        assert json.loads(found.json_text())["status"] == found.status.value
    assert seen["optimal"] > 10
    assert seen["infeasible"] > 2
    assert seen["start speed not admissible"] + seen["end speed not admissible"] > 0


@pytest.mark.quick
def test_a_stop_on_the_way_splits_the_path(tmp_path):
    cell = gantries(tmp_path)
    found = mrts.retime(cell, there_and_back(0.5))
    np.testing.assert_allclose(found.stops, [0.5])
    assert found.duration == pytest.approx(2 * 2 * np.sqrt(11 / 40), rel=1e-6)
    assert "stops at t = 0.5 s" in found.summary()
    assert len(found.pieces) == 2
    np.testing.assert_allclose(found.retimed.trajectory.motion.object.twist[50], 0, atol=1e-12)


def test_a_turn_between_samples_and_a_wait_are_named(tmp_path):
    cell = gantries(tmp_path)
    found = mrts.retime(cell, there_and_back(0.505))
    assert found.status.value == "stationary"
    assert "turns back on itself from t = 0.5 to 0.51 s" in found.explanation
    found = mrts.retime(cell, there_and_back(0.5, wait=3))
    assert found.status.value == "stationary"
    assert "a wait is no part of a path" in found.explanation


def test_end_speeds_count_where_the_motion_does_not_rest(tmp_path):
    cell = gantries(tmp_path)
    time = np.linspace(0, 1, 101)
    motion = straight(time, 2 * time, 2.0, 0.0)
    acceleration = 40 / 11
    still = mrts.retime(cell, motion)
    assert still.duration == pytest.approx(2 * np.sqrt(2 / acceleration), rel=1e-6)
    assert still.saving is None  # at constant speed the motion starts and ends moving
    rolling = mrts.retime(cell, motion, start_speed=0.4)  # 0.8 m/s
    peak = np.sqrt((2 * acceleration * 2 + 0.8**2) / 2)
    assert rolling.duration == pytest.approx((2 * peak - 0.8) / acceleration, rel=1e-3)
    fast = mrts.retime(cell, motion, start_speed=2.5)  # 5 m/s; braking takes 3.4 m
    assert fast.status.value == "start speed not admissible"
    top = np.sqrt(2 * acceleration * 2) / 2
    assert f"[0, {top:.6g}]" in fast.explanation
    assert "2.5 is asked for" in fast.explanation
    slow = mrts.retime(gantries(tmp_path, object_velocity={"linear": 1.0}), motion, end_speed=0.7)
    assert slow.status.value == "end speed not admissible"
    assert "[0, 0.5]" in slow.explanation


@pytest.mark.parametrize("sharing", [None, mrts.LoadSharing()])
def test_a_cell_without_a_single_limit_is_an_outcome(sharing, planar_cell, lift):
    none = np.full(3, np.inf)
    limits = {"torque_lower": -none, "torque_upper": none, "wrench_lower": -none, "wrench_upper": none}
    free = with_robots(planar_cell, **limits, velocity_limit=none)
    result = mrts.scale(free, lift, sharing=sharing)
    assert (result.status.value, result.range.lower.c2, result.trajectory.c2) == ("unbounded", 0.0, 1.0)
    assert mrts.retime(free, lift, sharing=sharing).status.value == "unbounded"


@pytest.mark.parametrize("stride", [5, 1])
def test_arms_that_cannot_hold_the_object_between_samples_are_told_at_once(stride, planar_cell, lift):
    """Between few samples, and on a course that a user wrote between any number of them."""
    few = lift.time[::stride]
    position, rotation, twist, acceleration = lift.course(few)
    step = few[1]

    def away(time):
        p, *others = lift.course(time)
        return (p + np.outer(5 * np.sin(np.pi * time / step) ** 2, [1, 0, 0]), *others)

    given = ObjectMotion(few, position, rotation, twist, acceleration, course=away, checked=False)
    with pytest.raises(mrts.MotionError, match="between the samples"):
        mrts.retime(planar_cell, given)
    assert mrts.retime(planar_cell, given, between=None).status.admits_motion


SAME_TIMING = 1e-7  # regions of speeds are projections, right to 1e-9


def test_each_change_is_what_timing_the_changed_cell_gives(planar_cell, lift):
    cell = planar_cell.with_variation(mass=(0.5, 2.0))
    asked = {"load": "guaranteed", "between": None}
    result = mrts.retime(cell, lift, **asked)
    found = {str(one.change): one for one in result.what_if().changes}
    base, grasp = cell.robots[0].T_world_base, cell.robots[0].T_object_tip
    elbow = cell.robots[0].torque_upper * [1, 1.1, 1]
    changed = {
        "left/elbow +10 %": with_left(cell, torque_lower=-elbow, torque_upper=elbow),
        "mass -10 %": cell.with_mass(0.9 * cell.mass),
        "left base y -10 mm": with_left(cell, T_world_base=RigidTransform(base.R, base.p - [0, 0.01, 0])),
        "left grasp x +10 mm": with_left(cell, T_object_tip=RigidTransform(grasp.R, grasp.p - [-0.01, 0, 0])),
    }
    for text, other in changed.items():
        again = mrts.retime(other, lift, **asked)
        assert found[text].after.duration == pytest.approx(again.duration, rel=SAME_TIMING), text
        assert found[text].before.duration == pytest.approx(result.duration, rel=SAME_TIMING)
        assert found[text].after.c2 is None
        assert found[text].after.limits
