"""A range of c² in several intervals: chosen, refused, told, saved, for every load."""

import re
from dataclasses import replace

import numpy as np
import pytest
from gantries import gantries
from slowing_gantries import Slowing

import mrts
from mrts.samples.range_status import RangeStatus
from mrts.scaling.range import intersect

SAME = 1e-9
"""Ends of c² in closed form, relative."""

SHARINGS = (None, mrts.LoadSharing())


def ends(found):
    return [(low.c2, high.c2) for low, high in found.range.intervals]


@pytest.fixture
def slowing(tmp_path):
    return Slowing().cell(tmp_path)


@pytest.mark.quick
@pytest.mark.parametrize("sharing", SHARINGS)
@pytest.mark.parametrize("solver", ["kernel", "qpsol:qpoases", "scipy:highs"])
@pytest.mark.parametrize("formulation", ["wrench", "torque"])
def test_the_range_has_two_intervals_where_rotor_inertia_helps(slowing, sharing, solver, formulation):
    result = mrts.scale(slowing, Slowing().motion(), sharing=sharing, solver=solver, formulation=formulation)
    np.testing.assert_allclose(ends(result), Slowing().intervals(), rtol=SAME)
    assert (result.range.lower, result.range.upper) == result.range.intervals[-1]
    assert result.trajectory.c2 == result.range.upper.c2
    assert max(result.residuals().limits, result.residuals().arms) < 2e-9
    (_, slow), (fast, fastest) = result.range.intervals
    assert [end.sample for end in (slow, fast, fastest)] == [0, 0, 10]
    assert {row.name.element for end in (slow, fast, fastest) for row in end.rows} == {"slide_x"}
    assert {row.side for row in (*slow.rows, *fast.rows)} == {"upper"}
    assert {row.side for row in fastest.rows} == {"lower"}


def test_each_c2_of_an_interval_can_be_chosen_and_none_of_a_gap(slowing):
    motion = Slowing().motion()
    for low, high in Slowing().intervals():
        for c2 in (low + (high - low) / 2, high):
            assert mrts.scale(slowing, motion, c2).trajectory.c2 == pytest.approx(c2, rel=SAME)
    with pytest.raises(
        mrts.SelectionError, match=r"lies in a gap of the admissible range \[0, 0\.0411\d+\] or \[0\.87"
    ) as told:
        mrts.scale(slowing, motion, 0.4)
    assert "near/slide_x torque (upper, 20 N)" in str(told.value)
    assert told.value.result.range.status is RangeStatus.FEASIBLE
    with pytest.raises(mrts.SelectionError, match="outside the admissible range") as told:
        mrts.scale(slowing, motion, 2.0)
    assert "upper end" in str(told.value)
    assert "torque (lower, -20 N)" in str(told.value)


def test_the_summary_and_json_say_all_intervals(slowing):
    result = mrts.scale(slowing, Slowing().motion())
    assert "c² ∈ [0, 0.04114] or [0.87" in result.sentence()
    assert "up to 0.203 or 0.93" in result.sentence()
    assert "c² ∈ [0, 0.04114] or [" in repr(result.range)
    said = result.to_json()
    assert said["intervals"] == [list(pair) for pair in ends(result)]
    assert said["c2"] == {"lower": said["intervals"][1][0], "upper": said["intervals"][1][1]}
    gaps = said["samples"]["gaps"]
    assert [gap["sample"] for gap in gaps] == list(range(11))
    assert gaps[0]["c2"] == [said["intervals"][0][1], said["intervals"][1][0]]


def test_a_gap_of_torque_speed_curves_is_not_blamed_on_friction(tmp_path):
    cell = gantries(tmp_path, gravity=(-4, 0, 0))
    curve, rotor = (np.array([[0, 30.0], [1.6, 2.0]]), None, None), np.array([3.0, 0, 0])
    motors = replace(cell.robots[0].motors, armature=rotor, torque_speed=curve)
    falling = replace(cell, robots=tuple(replace(robot, motors=motors) for robot in cell.robots))
    result = mrts.scale(falling, Slowing().motion())
    assert len(result.range.intervals) == 2
    with pytest.raises(mrts.SelectionError, match="lies in a gap") as told:
        mrts.scale(falling, Slowing().motion(), 1.0)
    for text in (result.sentence(), str(told.value)):
        assert "what motors lose with the speed (viscous friction, torque-speed curves)" in text
        assert "against friction" not in text


def test_what_is_possible_says_that_single_loads_have_gaps(tmp_path):
    case = Slowing()
    varied = mrts.scale(case.cell(tmp_path, variation={"mass": [0.9, 1.1]}), case.motion(), load="possible")
    assert all(len(found.intervals) == 2 for found in varied.load.ranges)
    assert "loads have gaps, and whether another fills them was not asked" in varied.sentence()
    steady = replace(case, friction=0.0)
    plain = mrts.scale(steady.cell(tmp_path, variation={"mass": [0.9, 1.1]}), case.motion(), load="possible")
    assert "gaps" not in plain.sentence()


def test_a_saved_result_keeps_its_gaps(slowing, tmp_path):
    result = mrts.scale(slowing, Slowing().motion())
    mrts.save_result(result, tmp_path / "result.npz")
    kept = mrts.load_result(tmp_path / "result.npz", slowing)
    assert kept.range.intervals == result.range.intervals
    assert kept.sentence() == result.sentence()
    assert kept.to_json()["samples"] == result.to_json()["samples"]
    first, again = result.range.samples.gaps[3], kept.range.samples.gaps[3]
    assert (tuple(first.lower_rows), tuple(first.upper_rows)) == (again.lower_rows, again.upper_rows)


def test_gaps_of_different_samples_may_leave_nothing(tmp_path):
    case = Slowing(first=1.0, last=0.3, inertia=15.0, friction=120.0)
    result = mrts.scale(case.cell(tmp_path), case.motion(41))
    assert ends(result)[0][0] == 0  # standing still always does
    samples = result.range.samples
    moving = replace(samples, lower=np.maximum(samples.lower, 0.2), upper=np.minimum(samples.upper, 0.5))
    found = intersect(moving)
    assert found.status is RangeStatus.EMPTY
    assert found.intervals == ()
    assert found.lower.c2 > found.upper.c2
    assert re.search(r"of c² ∈ \[0\.2, 0\.5\] single samples leave nothing: none from .* at t = ", found.explain())


@pytest.mark.parametrize("sharing", SHARINGS)
def test_what_is_guaranteed_is_what_all_corners_leave(tmp_path, sharing):
    case = Slowing()
    cell = case.cell(tmp_path, variation={"mass": [0.5, 8.0]})
    found = mrts.scale(cell, case.motion(), load="guaranteed", sharing=sharing)
    corners = [case.intervals(factor * 3) for factor in (0.5, 8.0)]
    expected = [(max(one[0], other[0]), min(one[1], other[1])) for one, other in zip(*corners, strict=True)]
    np.testing.assert_allclose(ends(found), expected, rtol=SAME)
    _, (fast, fastest) = found.range.intervals
    assert (fast.load.parameters["mass"], fastest.load.parameters["mass"]) == (0.5, 8.0)
    for factor in np.random.default_rng(0).uniform(0.5, 8.0, 5):
        known = mrts.torques_for_load(found, cell.load_box.load_at({"mass": float(factor)}))
        assert known.trajectory.c2 == found.trajectory.c2
    possible = mrts.scale(cell, case.motion(), load="possible", sharing=sharing)
    assert ends(possible)[0] == (0.0, pytest.approx(max(one[1][1] for one in corners), rel=1e-6))


def test_a_known_load_is_refused_at_a_c2_in_its_gap(tmp_path):
    case = Slowing()
    cell = case.cell(tmp_path, variation={"mass": [0.5, 8.0]})
    heavy = mrts.scale(cell.with_load(cell.load_box.load_at({"mass": 8.0})), case.motion(), 0.82, load="nominal")
    with pytest.raises(mrts.SelectionError, match="does not suit this load"):
        mrts.torques_for_load(heavy, cell.load_box.load_at({"mass": 0.5}))
