"""The fastest timing of paths of any length and any number of samples, and of arms that are alike but for rounding."""

from dataclasses import replace

import numpy as np
import pytest
from scaled_paths import FILES, scaled_path

import mrts
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.timing.fastest_profile import SpeedProfile, fastest_profile
from mrts.timing.path_pieces import path_pieces
from mrts.timing.speed_regions import speed_regions

PROFILES = ("sinusoid", "trapezoid", "cubic", "quintic")
SHORT = 1e-6
SHORT_DURATION = {"planar_dual_arm": 0.334327, "dual_ur5": 0.313638}
"""T / √length of the two cells where their configuration hardly changes [s/√m]."""
FEW, MANY = 31, 10_001
DISCRETISATION = {31: 1e-3, 101: 3e-4, 1001: 2e-5, 10_001: 2e-5}
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
@pytest.mark.parametrize("name", FILES)
def test_a_short_path_takes_as_long_as_its_root_says(name, profile, planar_cell, dual_ur5):
    """The configuration hardly changes: a constant acceleration, t ∝ √length."""
    cell = {"planar_dual_arm": planar_cell, "dual_ur5": dual_ur5}[name]
    for samples in (FEW, 1001) if profile in {"cubic", "trapezoid"} else (101,):
        for length in (SHORT, 1e-4):
            duration = checked(cell, scaled_path(name, length, samples, profile))
            expected = SHORT_DURATION[name] * np.sqrt(length)
            assert duration == pytest.approx(expected, rel=DISCRETISATION[samples]), (length, samples)


def test_the_finest_sampling_of_the_shortest_path(planar_cell):
    duration = checked(planar_cell, scaled_path("planar_dual_arm", SHORT, MANY, "quintic"))
    assert duration == pytest.approx(SHORT_DURATION["planar_dual_arm"] * np.sqrt(SHORT), rel=2e-6)


def test_the_lift_of_a_millimetre(planar_cell):
    """A user's: 1001 samples, from 1 m to 1.001 m."""
    durations = [checked(planar_cell, scaled_path("planar_dual_arm", 1e-3, 1001, profile)) for profile in PROFILES]
    np.testing.assert_allclose(durations, 0.01057153, rtol=1e-6)


def test_any_length_sampling_and_profile_agree(planar_cell, dual_ur5):
    """Of a path of some length the duration is one, however it was given."""
    rng = np.random.default_rng(5)
    for name, cell, longest in (("planar_dual_arm", planar_cell, 0.6), ("dual_ur5", dual_ur5, 0.25)):
        for length in np.exp(rng.uniform(np.log(SHORT), np.log(longest), 3)):
            given = [(int(np.exp(rng.uniform(np.log(FEW), np.log(700)))), rng.choice(PROFILES)) for _ in range(2)]
            fine, *durations = (checked(cell, scaled_path(name, length, *of)) for of in [(1001, "cubic"), *given])
            np.testing.assert_allclose(durations, fine, rtol=6e-3, err_msg=f"{name} {length} {given}")


@pytest.mark.parametrize("difference", [1e-9, 3e-9, 1e-8, 1e-7, 1e-6])
def test_arms_that_are_alike_but_for_the_last_digits(difference, planar_cell):
    """Limits that nearly meet in one corner, as where a pose is typed with eight digits."""
    motion = mrts.follow_object(planar_cell, scaled_path("planar_dual_arm", 0.5, 301, "sinusoid"))
    (piece,) = path_pieces(motion)
    problem, length = (
        build_sample_problem(motion_rows(planar_cell, piece.path), varying=True),
        float(np.sum(piece.step)),
    )
    noise = np.random.default_rng(0).uniform(-difference, difference, problem.A.shape)
    durations = []
    for A in (problem.A, problem.A * (1 + noise)):
        regions = speed_regions(replace(problem, A=A), length)
        assert regions.undecided == ()
        found = fastest_profile(piece.step, regions, (0.0, 0.0))
        assert isinstance(found, SpeedProfile)
        speed = np.sqrt(found.x)
        durations.append(float(np.sum(2 * piece.step / (speed[1:] + speed[:-1]))))
    assert durations[1] == pytest.approx(durations[0], rel=10 * difference)


def test_a_trapezoid_has_any_number_of_samples():
    """Its corner may be a sample."""
    for samples in range(31, 800, 3):
        scaled_path("planar_dual_arm", 0.1, samples, "trapezoid")


def test_a_fast_start_on_a_short_path(planar_cell):
    """It rolls over a micrometre so fast that its accelerations hardly count."""
    time = np.linspace(0, 1e-6, 101)
    column = np.zeros((101, 6))
    column[:, 1] = 1.0
    position = np.tile([1.25, 1.0, 0.0], (101, 1))
    position[:, 1] += time
    eye = np.broadcast_to(np.eye(3), (101, 3, 3))
    motion = mrts.ObjectMotion(time, position, eye, column, np.zeros((101, 6)))
    found = mrts.retime(planar_cell, motion, start_speed=0.5, end_speed=0.5)
    assert found.status.admits_motion, found.summary()
    assert found.duration == pytest.approx(2e-6, rel=1e-3)
