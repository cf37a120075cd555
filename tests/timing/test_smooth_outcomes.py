"""Smooth timings: limits put to the test by other code, what is least, every outcome by its name, what is told."""

import json
from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from gantries import along_x, gantries, there_and_back, uphill_gantries
from random_motors import equipped
from shipped_cells import shipped_motion

import mrts
from mrts.limits import limit_rows
from mrts.program.motion_rows import motion_rows
from mrts.program.path_solver import CONVERGED
from mrts.program.sample_problem import build_sample_problem
from mrts.timing import smooth_timing
from mrts.timing.retime import ROOM

RATES = 11.5
KEPT = 1e-6
"""Share of a limit: the solver's own tolerance is less, differences of a table add rounding."""

SAME_TIMING = 1e-5
"""Share of the duration: what steps may gain less than, and nodes that are added elsewhere."""

NEAR_FASTEST = 5e-3
"""Share of the duration by which nodes in σ and samples by arc length differ: the fastest timing has its own."""


def rates_of(found):
    """Changes of torque per second between the rows of a plan, Shape (n - 1, m)."""
    done = found.retimed.trajectory
    return np.diff(done.torque, axis=0) / np.diff(done.time)[:, None]


def energy_of(found):
    """∫ τᵀτ dt by the trapezoidal rule over the rows of a plan."""
    done = found.retimed.trajectory
    squares = np.sum(done.torque**2, axis=1)
    return float(np.sum(np.diff(done.time) * (squares[1:] + squares[:-1]) / 2))


@pytest.fixture(scope="module")
def smooth(planar_cell, lift):
    return mrts.retime(planar_cell, lift, rates=RATES)


@pytest.mark.quick
def test_a_plan_keeps_all_limits_and_starts_and_ends_holding_still(planar_cell, smooth):
    done = smooth.retimed.trajectory
    limit = RATES * np.concatenate([robot.torque_upper for robot in planar_cell.robots])
    np.testing.assert_allclose(smooth.options.rates.torque, limit)
    share = np.max(np.abs(rates_of(smooth)) / limit)
    assert 1 - 1e-3 < share <= 1 + KEPT  # the rate binds: less of it would be slower
    for robot in planar_cell.robots:
        assert np.all(smooth.retimed.torque[robot.name] <= robot.torque_upper * (1 + KEPT))
        assert np.all(smooth.retimed.torque[robot.name] >= robot.torque_lower * (1 + KEPT))
    residuals = smooth.retimed.residuals()
    assert residuals.limits < KEPT
    assert max(residuals.arms, residuals.object) < 1e-6  # N m, N
    np.testing.assert_allclose(done.dq[[0, -1]], 0, atol=1e-9)
    np.testing.assert_allclose(done.ddq[[0, -1]], 0, atol=1e-6)


def test_more_rate_is_faster_down_to_the_fastest_timing(planar_cell, lift, smooth):
    fastest = mrts.retime(planar_cell, lift).duration
    assert smooth.smooth.bound == pytest.approx(fastest)
    asked = {"distribute": "least-torque"}
    durations = [mrts.retime(planar_cell, lift, rates=rates, **asked).duration for rates in (1e-3, RATES, 1e6)]
    assert durations == sorted(durations, reverse=True)
    assert durations[-1] == pytest.approx(fastest, rel=NEAR_FASTEST)
    assert durations[0] > 60  # s, of 5 cm: a minute, not an error


def test_least_energy_falls_as_the_motion_may_take_longer(planar_cell, lift, smooth):
    longest = (smooth.duration * 1.001, 0.5)
    found = [mrts.retime(planar_cell, lift, rates=RATES, weights=1, least_energy_in=seconds) for seconds in longest]
    energies = [energy_of(one) for one in (smooth, *found)]
    assert energies == sorted(energies, reverse=True)
    for seconds, one in zip(longest, found, strict=True):
        assert one.duration == pytest.approx(seconds, rel=1e-6)  # here less time would take more energy
        assert f"of least energy within {seconds:g} s" in one.summary()


@pytest.mark.quick
def test_too_short_a_duration_is_an_outcome_with_the_least(planar_cell, lift, smooth):
    found = mrts.retime(planar_cell, lift, rates=RATES, least_energy_in=0.1)
    assert found.status.value == "duration too short"
    assert (found.retimed, found.pieces, found.duration) == (None, (), None)
    assert f"takes {smooth.duration / (1 + smooth.smooth.room):.4g}"[:-1] in found.explanation
    assert json.loads(found.json_text())["status"] == "duration too short"
    assert any(warning.code == "step-at-ends" for warning in found.constant.warnings)
    assert found.warnings == ()  # it is no step of a timing that there is not


def test_a_motion_stops_on_its_way_with_torques_that_hold_still(tmp_path):
    cell = gantries(tmp_path)
    found = mrts.retime(cell, there_and_back(0.5), rates=RATES)
    assert len(found.pieces) == 2
    assert "It stops at t = 0.5 s" in found.summary()
    halves = [np.sum(piece.segment_times) for piece in found.pieces]
    assert halves[0] == pytest.approx(halves[1], rel=1e-3)
    assert sum(halves) == pytest.approx(found.duration, rel=1e-9)
    assert np.max(np.abs(rates_of(found))) <= RATES * 20 * (1 + KEPT)  # across the stop too
    place = int(np.argmin(np.abs(found.retimed.trajectory.time - halves[0])))
    np.testing.assert_allclose(found.retimed.trajectory.torque[place], 0, atol=1e-4)  # no gravity: nothing to hold


def test_a_fixed_sharing_is_kept_at_every_node(planar_cell, lift, smooth):
    found = mrts.retime(planar_cell, lift, rates=RATES, sharing=mrts.LoadSharing())
    assert found.duration > smooth.duration
    left, right = (found.retimed.wrench[name][:, :2] for name in ("left", "right"))  # forces, in the world's axes
    np.testing.assert_allclose(left, right, atol=2e-6)
    assert (found.options.distribute, found.smooth.room) == ("least-torque", 0.0)  # nothing is left to distribute


def test_a_motion_that_moves_at_its_ends_is_timed_from_and_to_any_speed(planar_cell, lift):
    part = slice(20, 81)
    columns = (lift.position, lift.rotation, lift.twist, lift.acceleration)
    moving = mrts.ObjectMotion(lift.time[part] - lift.time[20], *(column[part] for column in columns))
    resting = mrts.retime(planar_cell, moving, rates=RATES)
    assert resting.saving is None  # the constant factor starts and ends moving
    np.testing.assert_allclose(resting.retimed.trajectory.dq[[0, -1]], 0, atol=1e-9)
    np.testing.assert_allclose(resting.retimed.trajectory.ddq[[0, -1]], 0, atol=1e-6)
    rolling = mrts.retime(planar_cell, moving, rates=RATES, start_speed=1.0, end_speed=0.5)
    given = mrts.scale(planar_cell, moving, 1.0).trajectory.dq
    np.testing.assert_allclose(rolling.retimed.trajectory.dq[0], given[0], rtol=1e-6)
    np.testing.assert_allclose(rolling.retimed.trajectory.dq[-1], given[-1] / 2, rtol=1e-6)
    assert rolling.duration < resting.duration
    braking = mrts.retime(planar_cell, moving, rates=1e-4, start_speed=0.5)  # torques cannot follow it to rest
    assert braking.status.value == "rates too small"
    assert "passes them by" in braking.explanation


WRONG = (
    ({"rates": 0}, "rates = 0: must be True, or a number > 0 and at most 1e+12. Give a robot of the cell file"),
    ({"rates": float("nan")}, "rates = nan: must be True, or a number > 0"),
    ({"rates": True}, "rates = True: the cell 'planar_dual_arm' limits no rate. Give a robot of the cell file"),
    ({"least_energy_in": 1.0}, "least_energy_in = 1.0: needs limits of rates: give rates too."),
    ({"rates": 1, "least_energy_in": 0}, "least_energy_in = 0: must be a duration > 0 [s]."),
    ({"rates": 1, "start_speed": 1.0}, "start_speed = 1.0: the given motion is at rest there"),
)


@pytest.mark.parametrize(("arguments", "message"), WRONG)
def test_wrong_arguments_are_refused_by_name(arguments, message, planar_cell, lift):
    with pytest.raises(mrts.InputError, check=lambda error: str(error).startswith(message)):
        mrts.retime(planar_cell, lift, **arguments)


def test_dry_friction_that_turns_round_slows_nothing_down(tmp_path):
    """It steps at any speed: were it counted from node to node, more nodes would allow less speed."""
    cell = uphill_gantries(tmp_path, viscous=0.0, coulomb=np.array([0.5, 0, 0]))
    coarse, fine = (mrts.scale(cell, along_x(n, profile="quintic"), rates=3.0, between=None) for n in (101, 801))
    assert fine.trajectory.c == pytest.approx(coarse.trajectory.c, rel=1e-2)
    there = mrts.retime(cell, there_and_back(0.5), rates=3.0)
    done, stop = there.retimed.trajectory, there.pieces[1].piece.first
    np.testing.assert_allclose(done.torque[stop, [0, 3]], 18.0, rtol=1e-6)  # what holds still
    friction = 0.5 * np.sign(done.dq)
    friction[[0, -1]] = friction[[1, -2]]
    change = np.diff(done.torque - friction, axis=0)[:, [0, 3]] / np.diff(done.time)[:, None]
    assert np.max(np.abs(change)) <= 3.0 * 20 * (1 + KEPT)


def test_the_plan_keeps_limits_between_its_rows_where_it_is_linear(smooth, planar_cell):
    (part,) = smooth.pieces
    inside, segment, share, x, u = part.between()
    problem = build_sample_problem(motion_rows(planar_cell, part.piece.fine.at(inside)), varying=True)
    plan = part.plan[segment] * (1 - share[:, None]) + part.plan[segment + 1] * share[:, None]
    values = np.einsum("nrk,nk->nr", problem.A, np.column_stack([plan, u, x]))
    excess = np.max(np.maximum(values - problem.upper, problem.lower - values))
    assert smooth.excess.share == pytest.approx(max(excess, 0.0), abs=1e-12)
    assert excess < 1e-4  # 4 % at a quarter of the nodes, where other wrenches than the plan's keep this


def test_the_timing_with_the_least_excess_is_kept_and_said():
    """Of samples that are too close for their rounding once limits of jerk ask for more nodes."""
    cell = equipped(mrts.load_cell(DATA.parent / "squeeze" / "cell.yaml"), jerk=950.0)
    motion = mrts.load_motion(shipped_motion("squeeze", samples=58, duration=2.4))
    rounded = mrts.retime(cell, motion, rates=11.5, between=1e-5, distribute="least-torque")
    assert rounded.status is mrts.RetimingStatus.LOCALLY_AT_SAMPLES
    assert rounded.smooth.steps <= 40
    assert rounded.motion.samples <= 600
    assert 1e-5 < rounded.excess.share < 1e-4
    assert "between the samples limits are overstepped by up to" in rounded.sentence()


def largest_shares(found):
    """Of the limits of torques and wrenches at each row of a plan, Shape (N,)."""
    done = found.retimed.trajectory
    rows = limit_rows(found.cell, done.motion)
    return np.max(rows.share(rows.value(done.torque, done.wrench, 0.0, 1.0))[:, ~rows.limits.is_of_speed], axis=1)


def mean_square(found):
    """(1/T) ∫ s² dt, s the largest share of any limit."""
    return np.trapezoid(largest_shares(found) ** 2, found.retimed.trajectory.time) / found.duration


@pytest.mark.parametrize("variation", [None, {"mass": (0.9, 1.1)}])
def test_with_rates_a_hundredth_of_the_duration_leaves_most_of_the_limits(dual_ur5, variation):
    cell = dual_ur5 if variation is None else dual_ur5.with_variation(**variation)
    motion = mrts.load_motion(shipped_motion("dual_ur5"))
    least, kept = (mrts.retime(cell, motion, rates=10.0, **asked) for asked in ({"distribute": "least-torque"}, {}))
    assert (least.smooth.room, kept.options.distribute) == (0.0, "reserve")
    assert kept.smooth.room == pytest.approx(ROOM, rel=1e-6)
    assert kept.duration <= least.duration * (1 + ROOM) * (1 + CONVERGED)
    assert mean_square(kept) < 0.25 * mean_square(least)
    assert np.max(largest_shares(kept)) < 0.8
    assert np.max(largest_shares(least)) > 1 - KEPT
    assert np.max(np.abs(rates_of(kept)) / kept.options.rates.torque) <= 1 + KEPT
    assert not kept.excess.passes
    # what sets the speed is told, though the plan stays away from it
    assert {name for name, _ in least.limits[:5]} == {name for name, _ in kept.limits[:5]}


@pytest.mark.parametrize("sharing", [None, mrts.LoadSharing(shares=[0.5, 0.5])], ids=["free", "shared"])
def test_corners_of_a_box_that_do_not_bind_are_kept_without_their_limits(monkeypatch, sharing, planar_cell, lift):
    """The timing of the corners that were passed is that of all, and admits wrenches for each of them."""
    cell = planar_cell.with_variation(mass=(0.5, 1.5), mx=(-0.05, 0.05))
    asked, stood = [], smooth_timing.successive_steps

    def counted(program, *rest):
        asked.append(len(program.change))
        return stood(program, *rest)

    monkeypatch.setattr(smooth_timing, "successive_steps", counted)
    some = mrts.retime(cell, lift, rates=RATES, sharing=sharing)
    most = max(asked)
    first = smooth_timing.timing_at_nodes

    def with_all(question, *rest):
        return first(replace(question, corners=[*range(len(question.bare.loads))]), *rest)

    monkeypatch.setattr(smooth_timing, "timing_at_nodes", with_all)
    asked.clear()
    every = mrts.retime(cell, lift, rates=RATES, sharing=sharing)
    assert len(some.loads) == len(every.loads) == 4
    assert most < 0.8 * max(asked)
    assert some.duration == pytest.approx(every.duration, rel=SAME_TIMING)
    assert not some.excess.passes  # of any corner, with its wrenches, between the nodes too
