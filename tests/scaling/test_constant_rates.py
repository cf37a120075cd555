"""`mrts.scale(rates=…)`: the factor within limits of rates, against closed forms and an independent program."""

from dataclasses import replace

import numpy as np
import pytest
from cell_bank import drawn_until, random_planar_cell, random_spatial_cell
from changed_robots import with_robots
from conftest import DATA
from draws import seeds
from gantries import along_x, gantries, straight
from random_motors import equipped
from rated_factor import RatedFactor, spacing
from shipped_cells import still_motion

import mrts
from mrts.cell.robot import JointMotors
from mrts.limits import limit_rows
from mrts.program.motion_rows import motion_rows
from mrts.program.path_solver import SHARE_MARGIN
from mrts.program.rate_limits import rate_limits
from mrts.program.torque_distribution import torque_weights
from mrts.scaling.constant_rates import RatedFactors
from mrts.scaling.range import RangeEnd

FREE = np.inf, np.inf
"""Of the joints that do not slide along x."""

THIRD = 24.0
"""Size of x''' along the cubic profile of `along_x` [m/s³]."""

MOVED, CARRIED = 11.0, 3.0
"""Of both gantries with the object, and of the object [kg]."""

ROUNDED = 4e-6
"""Share of c that a margin of 3e-6 of rates changes, and rounding."""

BISECTED = 1e-5
"""Share of c between bisection of Clarabel's answers, which are good to 1e-8, and the linear programs' cuts."""

GAP = 1e-7
"""Share of the least effort by which an interior point may miss it, which torques miss by its root."""

SHARES = 1e-4
"""Share of ∫ s² dt, s the largest share of any limit, by which Clarabel and a margin of 1e-5 of each s differ."""

EFFORT = 1e-5
"""Share of the least effort by which Clarabel may miss it in a set as thin as the least shares leave."""

KEPT = 1e-12
"""Share of a rate by which torques may pass it: rounding."""


def with_contact_rate(cell, *rates):
    return with_robots(cell, contact_rate=np.array(rates))


@pytest.fixture
def pushed(tmp_path):
    return gantries(tmp_path)


def shares(result):
    return {use.name.kind: use.share for use in reversed(result.rate_uses)}


CLOSED = {
    "torque rate": (lambda cell: equipped(cell, torque_rate=[10.0, *FREE]), 2 * 10 / MOVED, "lower, -10 N/s"),
    "wrench rate": (lambda cell: with_contact_rate(cell, 4.0, 4.0, np.inf), 2 * 4 / CARRIED, "lower, -4 N/s"),
    "jerk": (lambda cell: equipped(cell, jerk=[3.0, *FREE]), 3.0, "lower, -3 m/s³"),
    "torque rate of all": (
        lambda cell: with_contact_rate(equipped(cell, torque_rate=[10.0, *FREE], jerk=[8.0, *FREE]), 4.0, *FREE),
        2 * 10 / MOVED,
        "lower, -10 N/s",
    ),
}
"""Limits of rates of both gantries, the third derivative that they admit, and where it binds, by what does."""


@pytest.mark.quick
@pytest.mark.parametrize("kind", CLOSED)
def test_two_gantries_share_the_change_of_what_accelerates_all(pushed, kind):
    rated, third, named = CLOSED[kind]
    cell, rate = rated(pushed), kind.removesuffix(" of all")
    result, free = mrts.scale(cell, along_x(), rates=True), mrts.scale(cell, along_x())
    assert result.trajectory.c**3 == pytest.approx(third / THIRD, rel=3 * ROUNDED)
    assert {row.name.kind for row in result.range.upper.rows} == {rate}
    assert all(f"({named})" in str(row) for row in result.range.upper.rows)
    assert shares(result)[rate] == pytest.approx(1, abs=ROUNDED)
    assert free.trajectory.c2 > 1.2 * result.trajectory.c2
    assert shares(free)[rate] > 1
    with_both = result.torque["near"][:, 0] + result.torque["far"][:, 0]
    np.testing.assert_allclose(with_both, MOVED * result.trajectory.ddq[:, 0], atol=1e-7)
    kept = mrts.scale(cell, along_x(), rates=True, reserve=0.2)
    assert kept.trajectory.c**3 == pytest.approx(0.8 * third / THIRD, rel=3 * ROUNDED)


@pytest.mark.quick
def test_only_what_binds_within_rates_is_named(planar_cell, lift):
    rows = mrts.scale(planar_cell, lift, rates=5.0).range.upper.rows
    assert {(row.name.robot, row.name.element, row.name.kind) for row in rows} == {
        ("left", "shoulder", "torque rate"),
        ("right", "shoulder", "torque rate"),
    }


def test_rates_that_do_not_bind_change_nothing(planar_cell, lift, lifted):
    loose = mrts.scale(planar_cell, lift, rates=1000.0)
    assert loose.trajectory.c2 == lifted.trajectory.c2
    assert loose.range.upper == lifted.range.upper
    assert loose.sentence() == f"within the rates, {lifted.sentence()}"
    weights = torque_weights(None, planar_cell)
    efforts = [np.sum((one.trajectory.torque @ weights) * one.trajectory.torque) for one in (loose, lifted)]
    assert efforts[0] == pytest.approx(efforts[1], rel=GAP)
    most = np.max(np.abs(lifted.trajectory.torque))
    np.testing.assert_allclose(loose.trajectory.torque, lifted.trajectory.torque, atol=np.sqrt(GAP) * most)


def speeding(samples=41):
    """An object that accelerates ever more: x'' = 1 + t."""
    t = np.linspace(0, 1, samples)
    return straight(t, t**2 / 2 + t**3 / 6, t + t**2 / 2, 1 + t)


def pressed(cell, least):
    return with_robots(cell, wrench_lower=np.array([least, -np.inf, -np.inf]), wrench_upper=np.full(3, np.inf))


@pytest.mark.quick
def test_a_least_speed_may_change_torques_too_fast(pushed):
    cell = pressed(equipped(pushed, torque_rate=[5.0, *FREE]), 2.0)  # 2 · 2 N = 3 kg · 1 m/s² · c²
    assert mrts.scale(cell, speeding()).range.lower.c2 == pytest.approx(4 / 3, rel=1e-6)
    result = mrts.scale(cell, speeding(), rates=True)
    assert result.status.value == "empty"
    assert result.trajectory is None
    assert "a rate is too small: c² must be at least 1.33333 at t = 0 s by" in result.sentence()
    assert (2 * 5 / MOVED) ** (2 / 3) <= result.range.upper.c2 < 4 / 3
    assert "torque rate (upper, 5 N/s)" in result.sentence()
    slower = mrts.scale(pressed(cell, 1.0), speeding(), rates=True)
    assert slower.trajectory.c**3 == pytest.approx(2 * 5 / MOVED, rel=3 * ROUNDED)
    assert slower.range.lower.c2 == pytest.approx(2 / 3, rel=1e-6)


@pytest.mark.quick
def test_a_load_that_varies_is_carried_at_its_worst(tmp_path):
    cell = equipped(gantries(tmp_path, variation={"mass": [0.5, 4]}), torque_rate=[10.0, *FREE])
    result = mrts.scale(cell, along_x(), rates=True)
    assert result.trajectory.c**3 == pytest.approx(2 * 10 / ((8 + 4 * CARRIED) * THIRD), rel=3 * ROUNDED)
    assert result.range.upper.load.parameters == {"mass": 4}
    heavy = mrts.torques_for_load(result, cell.load_box.load_at({"mass": 4}))
    assert shares(heavy)["torque rate"] == pytest.approx(1, abs=ROUNDED)
    nominal = mrts.scale(cell, along_x(), rates=True, load="nominal")
    assert nominal.trajectory.c**3 == pytest.approx(2 * 10 / (MOVED * THIRD), rel=3 * ROUNDED)


def test_a_motion_that_stands_still_is_limited_by_no_rate(dual_ur5):
    found = mrts.scale(dual_ur5, still_motion([0, 0.1, 0.35]), rates=0.01).range
    assert (found.status.value, found.upper.rows) == ("unbounded", ())


def easing(samples=21):
    """An object whose acceleration falls from 2 to 1.9 m/s²: friction rises, inertia gives way."""
    t = np.linspace(0, 0.1, samples)
    return straight(t, t**2 - t**3 / 6, 2 * t - t**2 / 2, 2 - t)


@pytest.mark.quick
def test_rates_may_leave_a_gap_where_friction_is_made_up_for_by_inertia(pushed):
    """The torque of both changes by 12 x'' c² - 11 c³ a second: small at low and at high speed."""
    strong = with_robots(pushed, torque_lower=np.full(3, -1e3), torque_upper=np.full(3, 1e3))
    cell = equipped(strong, viscous=[6.0, 0, 0], torque_rate=[7.5, *FREE])
    result = mrts.scale(cell, easing(), rates=True, between=None)
    motion = result.motion.object
    steps, change = np.diff(motion.time), np.diff(motion.acceleration[:, 0])

    def share(c):
        return np.max(np.abs(MOVED * change * c**2 + 12 * np.diff(motion.twist[:, 0]) * c) * c / steps) / 15

    c = result.trajectory.c
    assert share(c) == pytest.approx(1, rel=ROUNDED)
    assert c > 2
    factors = RatedFactors(motion_rows(cell, result.motion), [None], rate_limits(cell, rates=True))
    asked = np.linspace(0.2, 2.5, 24)
    admitted = [factors.refused(one**2) is None for one in asked]
    assert admitted == [share(one) <= 1 for one in asked]
    assert np.count_nonzero(np.diff(admitted)) == 3  # slow enough, too fast, fast enough, too fast
    with pytest.raises(mrts.SelectionError, match=r"c² = 2\.1 lies in a gap that rates leave .*slide_x torque rate"):
        mrts.scale(cell, easing(), 2.1, rates=True, between=None)
    low = factors.slowest(RangeEnd(2.1, None, None), 6.0)
    assert share(np.sqrt(low.c2)) == pytest.approx(1, rel=ROUNDED)
    assert 2.1 < low.c2 < c**2


def rated(case, rng, tight):
    """A random cell with friction, armature and rates that bind, and its motion as it is without them."""
    cell = case.cell
    free = mrts.scale(cell, case.motion, between=None)
    if free.trajectory is None:
        return None
    robots = []
    for robot, duty in zip(cell.robots, free.trajectory.duty.values(), strict=True):
        n, torque = len(robot.joints), np.minimum(-robot.torque_lower, robot.torque_upper)
        motors = replace(
            JointMotors.unknown(n),
            coulomb=rng.uniform(0, 0.02, n) * torque,
            viscous=rng.uniform(0, 0.02, n) * torque,
            armature=rng.uniform(0, 0.02, n),
            torque_rate=tight * rng.uniform(0.5, 2, n) * np.maximum(duty.torque_rate, 0.1 * np.max(duty.torque_rate)),
        )
        fast = np.max(np.abs(np.diff(free.wrench[robot.name], axis=0)), axis=0) / np.diff(free.trajectory.time)[0]
        contact_rate = tight * rng.uniform(1, 3) * np.maximum(fast, 0.1 * np.max(fast))
        robots.append(replace(robot, motors=motors, contact_rate=contact_rate))
    return replace(cell, robots=tuple(robots))


@pytest.mark.parametrize("seed", seeds(2, 3))
def test_random_cells_against_an_independent_program(seed, tmp_path):
    rng = np.random.default_rng([16, seed])
    while True:
        arms = int(rng.integers(1, 4))
        draw = random_planar_cell if seed % 2 == 0 else random_spatial_cell
        case = draw(rng, tmp_path, min(arms, 2) if seed % 2 else arms)
        cell = rated(case, rng, tight=float(rng.uniform(0.2, 0.7)))
        free = None if cell is None else mrts.scale(cell, case.motion, between=None)
        if free is not None and free.trajectory is not None:
            break
    result = mrts.scale(cell, case.motion, rates=True, between=None)
    oracle = RatedFactor(cell, result.motion, rate_limits(cell, rates=True))
    assert result.trajectory is not None
    c = result.trajectory.c
    assert c < free.trajectory.c
    assert oracle.excess(c * (1 - BISECTED)) < 0 < oracle.excess(c * (1 + BISECTED))
    assert all(use.share <= 1 + KEPT for use in result.rate_uses)
    assert result.range.upper.rows
    residuals = result.residuals()
    assert max(residuals.arms, residuals.object) < 1e-7 * np.max(np.abs(result.trajectory.torque))


@pytest.mark.parametrize("seed", seeds(2, 4))
def test_least_shares_within_rates_against_an_independent_program(seed, tmp_path):
    rng = np.random.default_rng([32, seed])
    draw = random_planar_cell if seed % 2 == 0 else random_spatial_cell

    def moving(case):
        cell = rated(case, rng, tight=float(rng.uniform(0.3, 0.7)))
        found = None if cell is None else mrts.scale(cell, case.motion, rates=True, between=None)
        return found if found is not None and found.trajectory is not None else None

    case, fastest = drawn_until(moving, lambda: draw(rng, tmp_path, 2 + seed % 2 * (seed % 4 == 0)))
    cell, c = fastest.cell, 0.95 * fastest.trajectory.c
    asked = {"between": None, "distribute": "reserve"}
    kept, by_sample = (mrts.scale(cell, case.motion, c * c, **asked, **rates) for rates in ({"rates": True}, {}))
    oracle = RatedFactor(cell, kept.motion, rate_limits(cell, rates=True))
    weights, wide = torque_weights(None, cell), spacing(kept.trajectory.time)
    least, used = oracle.shares(c), largest_shares(kept)
    assert wide @ used**2 == pytest.approx(wide @ least**2, rel=SHARES)
    assert np.all(used >= largest_shares(by_sample) - ROUNDED)
    torque = kept.trajectory.torque
    assert wide @ np.sum((torque @ weights) * torque, axis=1) == pytest.approx(
        oracle.effort(c, used, weights), rel=EFFORT
    )
    assert all(use.share <= 1 + KEPT for use in kept.rate_uses)
    print("∫ s² dt", wide @ used**2, "without rates", wide @ largest_shares(by_sample) ** 2)


def largest_shares(result):
    """Of the limits of torques and wrenches as they are given at each sample, Shape (N,)."""
    rows = limit_rows(result.cell.with_reserve(0.0), result.motion)
    value = rows.value(result.trajectory.torque, result.trajectory.wrench, 0.0, result.trajectory.c)
    return np.max(rows.share(value)[:, ~rows.limits.is_of_speed], axis=1)


@pytest.mark.parametrize("motors", [{}, {"viscous": 0.05, "coulomb": 0.02, "armature": 0.01}])
def test_where_rates_do_not_bind_the_least_shares_are_those_of_each_sample(planar_cell, lift, motors):
    cell = equipped(planar_cell, **{name: value * planar_cell.robots[0].torque_upper for name, value in motors.items()})
    for of, load in ((cell, "nominal"), (cell.with_variation(mass=(0.8, 1.2)), "guaranteed")):
        asked = {"load": load, "distribute": "reserve", "between": None}
        by_sample, whole = (mrts.scale(of, lift, 0.5, **asked, **rates) for rates in ({}, {"rates": 1e4}))
        np.testing.assert_allclose(largest_shares(whole), largest_shares(by_sample), atol=SHARE_MARGIN * (1 + ROUNDED))
        off = (whole.trajectory.torque - by_sample.trajectory.torque) / of.robots[0].torque_upper.max()
        assert np.max(np.abs(off)) < 100 * SHARE_MARGIN


def test_a_limit_of_zero_counts_alike_whatever_reserve_is_kept():
    """A pad's cone has limits of 0, which a reserve moves: its size stays that of the pad's force."""
    folder = DATA.parent / "squeeze"
    cell, motion = mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(folder / "lift_and_turn.yaml")
    asked = {"distribute": "reserve", "between": None}
    by_sample = largest_shares(mrts.scale(cell, motion, 0.5, **asked))
    for reserve in (0.0, 1e-6, 0.1):
        whole = mrts.scale(cell, motion, 0.5, reserve=reserve, rates=1e3, **asked)
        np.testing.assert_allclose(largest_shares(whole), by_sample, atol=SHARE_MARGIN * (1 + ROUNDED))
