"""The fastest timing, against toppra, a direct transcription, closed forms and its own constraints."""

from dataclasses import replace

import numpy as np
import pytest
from cell_bank import random_planar_cell
from changed_robots import with_robots
from draws import seeds
from gantries import along_x, gantries
from one_arm import by_toppra, duration, one_arm
from random_motors import equipped
from scipy.optimize import linprog
from shipped_cells import scaled_path, shipped_motion
from transcription import transcribed

import mrts
from mrts.following.coordinated_motion import carried_by_first
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import motion_ranges
from mrts.timing.fastest_profile import Obstacle, SpeedProfile, fastest_profile, speed_regions
from mrts.timing.path_pieces import path_pieces

TOPPRA_TOLERANCE = 1e-4  # seidel keeps limits to 1e-6 of their size; a thin region turns that into more of x
DURATION_TOLERANCE = 1e-3
TRANSCRIPTION_TOLERANCE = 1e-3
EXCESS_GOAL = 1e-3
PATHS = 15


@pytest.mark.parametrize("seed", seeds(7, PATHS))
def test_one_arm_equals_toppra_pointwise(seed, tmp_path):
    """On the same parameter, grid and scheme; every third arm has motors with inertia and dry friction."""
    grid = np.linspace(0, 1, 101)
    cell, model, path = one_arm(seed, tmp_path)
    if seed % 3 == 2:
        rng, most = np.random.default_rng([151, seed]), cell.robots[0].torque_upper
        cell = equipped(cell, armature=rng.uniform(0, 2, 6), coulomb=rng.uniform(0, 0.2, 6) * most)
    theirs = by_toppra(cell, model, path, grid)
    motion = carried_by_first(cell, grid, path(grid), path(grid, 1), path(grid, 2))
    problem = build_sample_problem(motion_rows(cell, motion), varying=True)
    assert problem.speed is None
    ours = fastest_profile(np.diff(grid), speed_regions(problem, 1.0), (0.0, 0.0))
    assert (theirs is None) == isinstance(ours, Obstacle)
    if theirs is not None:
        assert isinstance(ours, SpeedProfile)
        np.testing.assert_allclose(ours.x, theirs, atol=TOPPRA_TOLERANCE * np.max(theirs))
        assert duration(np.diff(grid), ours.x) == pytest.approx(duration(np.diff(grid), theirs), rel=1e-5)


@pytest.mark.parametrize("seed", seeds(1, 1))
@pytest.mark.parametrize("fast", [False, True])
def test_one_arm_equals_toppra_as_a_user_calls_it(seed, fast, tmp_path):
    """On the arc length instead of the spline's parameter: both converge to the same duration."""
    grid = np.linspace(0, 1, 2001)
    cell, model, path = one_arm(seed, tmp_path)
    strong = cell if fast else cell.without_velocity_limits()
    speed = cell.robots[0].velocity_limit if fast else np.full(6, 1e6)
    limited = with_robots(cell, velocity_limit=speed)
    theirs = by_toppra(limited, model, path, grid)
    motion = carried_by_first(cell, grid, path(grid), path(grid, 1), path(grid, 2))
    found = mrts.retime(strong, motion)
    assert (theirs is not None) == found.status.admits_motion
    if theirs is not None:
        assert found.duration == pytest.approx(duration(np.diff(grid), theirs), rel=DURATION_TOLERANCE)
        assert found.excess.share < EXCESS_GOAL


@pytest.mark.parametrize("name", ["planar_dual_arm", "dual_ur5"])
def test_two_arms_equal_a_direct_transcription(name, planar_cell, dual_ur5):
    cell = {"planar_dual_arm": planar_cell, "dual_ur5": dual_ur5}[name].without_velocity_limits()
    motion = mrts.follow_object(cell, mrts.load_motion(shipped_motion(name, samples=41)))
    (piece,) = path_pieces(cell, motion)
    found, x = transcribed(cell, motion)()
    assert found
    assert mrts.retime(cell, motion).duration == pytest.approx(duration(piece.step, x), rel=TRANSCRIPTION_TOLERANCE)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("limits", "acceleration", "velocity", "profile"),
    [
        ({}, 40 / 11, np.inf, "trapezoid"),  # both motors push 2 * 4 + 3 kg
        ({}, 40 / 11, np.inf, "quintic"),
        ({"wrench": 3.0}, 2 * 3.0 / 3, np.inf, "cubic"),  # each contact may push 3 N on 3 kg
        ({"velocity": 1.5}, 40 / 11, 1.5, "sinusoid"),
        ({"object_velocity": {"linear": 1.2}}, 40 / 11, 1.2, "quintic"),
        ({"variation": {"mass": [0.5, 3.0]}}, 40 / 17, np.inf, "cubic"),  # 9 kg at most
    ],
)
def test_bang_bang_in_closed_form(limits, acceleration, velocity, profile, tmp_path):
    """t = 2 √(L / a), or with a velocity limit L / v + v / a, however the motion was given."""
    cell = gantries(tmp_path, **limits)
    found = mrts.retime(cell, along_x(profile=profile))
    reached = min(velocity, np.sqrt(acceleration * 2))
    # with a velocity limit the corner of the speed falls between two samples
    tolerance = 1e-8 if np.isinf(velocity) else 1e-3
    assert found.duration == pytest.approx(2 / reached + reached / acceleration, rel=tolerance), found.summary()
    assert found.excess.share < EXCESS_GOAL
    done = found.retimed.trajectory
    speed = np.sqrt(np.sum(done.motion.object.twist[:, :3] ** 2, axis=1))
    assert np.max(speed) == pytest.approx(reached, rel=1e-2)


@pytest.mark.parametrize(("motors", "kept"), [({}, 1e-9), ({"viscous": 8.0, "coulomb": 3.0}, 1e-8)])
def test_every_load_of_a_box_follows_the_guaranteed_profile(motors, kept, planar_cell, lift):
    box = {"mass": (0.5, 1.5), "izz": (0.5, 2.0), "mx": (-0.05, 0.05)}
    cell = equipped(planar_cell.with_variation(**box), **motors)
    found = mrts.retime(cell, lift)
    assert len(found.loads) == 4  # nothing turns, so izz has no effect
    assert found.duration > mrts.retime(cell, lift, load="nominal").duration
    for point in cell.load_box.draw(np.random.default_rng(8), 100):
        samples = motion_ranges(motion_rows(cell, found.retimed.motion), point.load)
        assert np.max(samples.lower) <= 1 + kept
        assert np.min(samples.upper) >= 1 - kept


@pytest.mark.quick
@pytest.mark.parametrize("motors", [{}, {"viscous": 8.0, "coulomb": 3.0}])
def test_a_fixed_distribution_is_slower_than_a_free_one(motors, planar_cell, lift):
    cell = equipped(planar_cell, **motors)
    free, even = mrts.retime(cell, lift), mrts.retime(cell, lift, sharing=mrts.LoadSharing())
    assert even.duration > free.duration
    assert even.excess.share < EXCESS_GOAL
    assert even.retimed.residuals().limits <= 1e-8
    halves = [even.retimed.wrench[name][:, 1] for name in ("left", "right")]
    np.testing.assert_allclose(halves[0], halves[1], atol=1e-9)


@pytest.mark.parametrize("seed", seeds(1, 3))
def test_regions_reach_as_far_as_highs_finds(seed, tmp_path):
    """In every direction, for arms some of whose wrench components have no limits."""
    case = random_planar_cell(np.random.default_rng([99, seed]), tmp_path, 3, samples=11)
    cell = case.cell.without_velocity_limits()
    (piece,) = path_pieces(cell, mrts.follow_object(cell, case.motion))
    problem = build_sample_problem(motion_rows(cell, piece.path), varying=True)
    regions = speed_regions(problem, float(np.sum(piece.step)))
    unit, compared = 1 / np.max(np.abs(problem.A), axis=1)[:, -2:], 0
    for sample in set(range(0, 11, 2)) - set(np.flatnonzero(regions.undecided)):
        bounds = [(None, None)] * (problem.unknowns - 1) + [(0, None)]
        rows = np.concatenate([problem.A[sample], -problem.A[sample]])
        limits = np.concatenate([problem.upper[sample], -problem.lower[sample]])
        kept = np.isfinite(limits)
        planes = regions.planes[regions.start[sample] : regions.start[sample + 1]]
        for angle in np.linspace(0, 2 * np.pi, 12, endpoint=False):
            cost = np.zeros(problem.unknowns)
            cost[-2:] = -np.array([np.cos(angle), np.sin(angle)]) / unit[sample]
            theirs = linprog(cost, rows[kept], limits[kept], bounds=bounds)
            ours = linprog(
                cost[-2:],
                planes[:, :2],
                planes[:, 2],
                bounds=[(None, None), (regions.lower[sample], regions.upper[sample])],
            )
            assert (ours.status, theirs.status) in {(0, 0), (3, 3)}, (sample, angle)
            if ours.status == 0:
                assert ours.fun == pytest.approx(theirs.fun, rel=1e-5, abs=1e-5), (sample, angle)
                compared += 1
    assert compared > 20


PROFILES = ("sinusoid", "trapezoid", "cubic", "quintic")
SHORT_DURATION = {"planar_dual_arm": 0.334327, "dual_ur5": 0.313638}
"""T / √length of the two cells where their configuration hardly changes [s/√m]."""
DISCRETISATION = {31: 1e-3, 101: 3e-4, 1001: 2e-5}
"""Relative error of the duration by the number of samples."""


def checked(cell, motion):
    """The timing, with what must be true of any."""
    found = mrts.retime(cell, motion)
    assert found.status.admits_motion, found.summary()
    assert found.saving > 0.1
    assert found.excess.share < 1.5e-3
    assert found.retimed.residuals().limits <= 1e-8
    return found.duration


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("name", SHORT_DURATION)
def test_a_short_path_takes_as_long_as_its_root_says(name, profile, planar_cell, dual_ur5):
    """The configuration hardly changes: a constant acceleration, t ∝ √length."""
    cell = {"planar_dual_arm": planar_cell, "dual_ur5": dual_ur5}[name]
    samples = {"cubic": 31, "trapezoid": 1001}.get(profile, 101)
    for length in (1e-6, 1e-4):
        duration = checked(cell, scaled_path(name, length, samples, profile))
        assert duration == pytest.approx(SHORT_DURATION[name] * np.sqrt(length), rel=DISCRETISATION[samples]), length


@pytest.mark.parametrize("difference", [1e-9, 1e-7])
def test_arms_that_are_alike_but_for_the_last_digits(difference, planar_cell):
    """Limits that nearly meet in one corner, as where a pose is typed with eight digits."""
    motion = mrts.follow_object(planar_cell, scaled_path("planar_dual_arm", 0.5, 301, "sinusoid"))
    (piece,) = path_pieces(planar_cell, motion)
    problem, length = (
        build_sample_problem(motion_rows(planar_cell, piece.path), varying=True),
        float(np.sum(piece.step)),
    )
    noise = np.random.default_rng(0).uniform(-difference, difference, problem.A.shape)
    durations = []
    for A in (problem.A, problem.A * (1 + noise)):
        regions = speed_regions(replace(problem, A=A), length)
        assert not regions.undecided.any()
        found = fastest_profile(piece.step, regions, (0.0, 0.0))
        assert isinstance(found, SpeedProfile)
        speed = np.sqrt(found.x)
        durations.append(float(np.sum(2 * piece.step / (speed[1:] + speed[:-1]))))
    assert durations[1] == pytest.approx(durations[0], rel=10 * difference)
