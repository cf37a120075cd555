"""The range of c² where samples admit several intervals: the highest, and slower speeds that are asked for."""

import numpy as np
import pytest
from gantries import gantries, straight
from given_ranges import ranges_of
from random_motors import equipped

import mrts
from mrts.scaling.range import common_range

FORCE, INERTIA, FRICTION = 20.0, 100.0, 120.0
"""Of a gantry [N, kg, N s/m]: its motor's rotor inertia helps against friction where the object slows down."""

FIRST, LAST = 1.0, 0.9
"""Speeds of a motion along x that slows down by 1 m/s²."""


def slowing_cell(folder, **changes):
    return equipped(gantries(folder, **changes), armature=[INERTIA, 0, 0], viscous=[FRICTION, 0, 0])


def slowing_motion(samples=11):
    t = np.linspace(0, FIRST - LAST, samples)
    return straight(t, FIRST * t - t**2 / 2, FIRST - t, -1.0)


def intervals(mass=3.0):
    """Of c²: -FORCE <= b v c - M c² <= FORCE at the first and the last speed; an arm of 4 kg moves half the object."""
    M = 4.0 + mass / 2 + INERTIA

    def roots(speed, force):
        half = FRICTION * speed / 2
        return (half - np.sqrt(half**2 - force * M)) / M, (half + np.sqrt(half**2 - force * M)) / M

    (slow, fast), (_, fastest) = roots(FIRST, FORCE), roots(LAST, -FORCE)
    return [(0.0, slow**2), (fast**2, fastest**2)]


SAME = 1e-9
"""Ends of c² in closed form, relative."""

SHARINGS = (None, mrts.LoadSharing())


def ends(found):
    return found.lower.c2, found.upper.c2


@pytest.fixture
def slowing(tmp_path):
    return slowing_cell(tmp_path)


@pytest.mark.quick
@pytest.mark.parametrize("sharing", SHARINGS)
@pytest.mark.parametrize("solver", ["kernel", "qpsol:qpoases"])
@pytest.mark.parametrize("formulation", ["wrench", "torque"])
def test_the_range_is_the_highest_interval_where_rotor_inertia_helps(slowing, sharing, solver, formulation):
    result = mrts.scale(slowing, slowing_motion(), sharing=sharing, solver=solver, formulation=formulation)
    _, highest = intervals()
    np.testing.assert_allclose(ends(result.range), highest, rtol=SAME)
    assert result.range.samples.several
    assert result.trajectory.c2 == result.range.upper.c2
    assert max(result.residuals().limits, result.residuals().arms) < 2e-9
    for end, sample, side in ((result.range.lower, 0, "upper"), (result.range.upper, 10, "lower")):
        assert end.sample == sample
        assert {(row.name.element, row.side) for row in end.rows} == {("slide_x", side)}


@pytest.mark.parametrize("sharing", SHARINGS)
def test_a_slower_c2_is_admitted_exactly_where_all_limits_hold(slowing, sharing):
    motion = slowing_motion()
    (_, slow), (fast, fastest) = intervals()
    for c2 in (0.5 * slow, slow * (1 - SAME), fast, (fast + fastest) / 2):
        result = mrts.scale(slowing, motion, c2, sharing=sharing)
        assert result.trajectory.c2 == pytest.approx(c2, rel=SAME)
        assert result.residuals().limits < 2e-9
    for c2 in (slow * (1 + 1e-6), 0.4, fast * (1 - 1e-6)):
        with pytest.raises(mrts.SelectionError, match=r"no slower one admits it: at t = 0 s .*slide_x torque") as told:
            mrts.scale(slowing, motion, c2, sharing=sharing)
        assert told.value.result.range.status is mrts.ScalingStatus.FEASIBLE
    with pytest.raises(mrts.SelectionError, match=r"The upper end is set .*torque \(lower, -20 N\)"):
        mrts.scale(slowing, motion, 2.0, sharing=sharing)


def test_a_slower_c2_must_carry_every_corner_of_a_box(tmp_path):
    cell = slowing_cell(tmp_path, variation={"mass": [0.5, 8.0]})
    slow = [intervals(factor * 3)[0][1] for factor in (0.5, 8.0)]
    assert mrts.scale(cell, slowing_motion(), min(slow) * (1 - SAME)).trajectory.c2 == pytest.approx(min(slow))
    with pytest.raises(mrts.SelectionError, match=r"no slower one admits it: .* with mass"):
        mrts.scale(cell, slowing_motion(), sum(slow) / 2)


INTERVALS = {
    "both at their highest": ([[(0, 1), (3, 5)], [(0, 2), (4, 6)]], "feasible", (4, 5)),
    "one goes down": ([[(0, 1), (3, 5)], [(0, 2)]], "feasible", (0, 1)),
    "down step by step": ([[(0, 1), (3, 5)], [(2, 2.5), (0.2, 0.9)]], "feasible", (0.2, 0.9)),
    "past two at once": ([[(0, 1), (3, 4), (5, 6)], [(0.5, 2)]], "feasible", (0.5, 1)),
    "nothing in common": ([[(0, 1), (3, 5)], [(2, 2.5)]], "empty", (3, 2.5)),
    "all of them unbounded": ([[(0, 1), (3, np.inf)], [(2, np.inf)]], "unbounded", (3, np.inf)),
}


@pytest.mark.parametrize(("unions", "status", "expected"), INTERVALS.values(), ids=INTERVALS)
def test_samples_go_down_until_they_have_an_interval_in_common(unions, status, expected):
    def find(high):
        found = [max((one for one in union if one[0] <= high), default=max(union)) for union in unions]
        return ranges_of(*np.transpose(found), several=True)

    found = common_range(find)
    assert (found.status.value, ends(found)) == (status, expected)


@pytest.mark.parametrize("sharing", SHARINGS)
def test_what_is_guaranteed_is_what_all_corners_leave(tmp_path, sharing):
    cell = slowing_cell(tmp_path, variation={"mass": [0.5, 8.0]})
    found = mrts.scale(cell, slowing_motion(), load="guaranteed", sharing=sharing)
    one, other = [intervals(factor * 3)[1] for factor in (0.5, 8.0)]
    np.testing.assert_allclose(ends(found.range), (max(one[0], other[0]), min(one[1], other[1])), rtol=SAME)
    loads = [end.load.parameters["mass"] for end in (found.range.lower, found.range.upper)]
    assert loads == [0.5, 8.0]
    for factor in np.random.default_rng(0).uniform(0.5, 8.0, 5):
        known = mrts.torques_for_load(found, cell.load_box.load_at({"mass": float(factor)}))
        assert known.trajectory.c2 == found.trajectory.c2
    possible = mrts.scale(cell, slowing_motion(), load="possible", sharing=sharing)
    assert ends(possible.range) == pytest.approx((min(one[0], other[0]), max(one[1], other[1])), rel=1e-6)
