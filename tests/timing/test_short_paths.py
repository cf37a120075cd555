"""The fastest timing of short paths, and of arms that are alike but for rounding."""

from dataclasses import replace

import numpy as np
import pytest
from scaled_paths import scaled_path

import mrts
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.timing.fastest_profile import SpeedProfile, fastest_profile
from mrts.timing.path_pieces import path_pieces
from mrts.timing.speed_regions import speed_regions

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
