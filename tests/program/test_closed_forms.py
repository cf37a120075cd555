"""Smooth timing of gantries along a line, whose fastest timings are known in closed form."""

import numpy as np
import pytest
from changed_robots import with_robots
from gantries import along_x, gantries
from random_motors import equipped

import mrts

WAY = 2.0  # m
MOVED = 11.0  # kg
STRONG = 1e6  # N
NODES = 201
LONGER = 1.5e-3
"""Share of the duration: jerk keeps its limit at both ends of a segment, so on it it lies below by a step of it."""

SHORTER = 2e-4
"""Likewise: the corners of the jerk lie between nodes."""


def gantry_cell(folder, jerk=np.inf, rate=np.inf, force=STRONG, speed=np.inf):
    """Two gantries with one limit for all joints of each kind."""
    cell = equipped(gantries(folder), jerk=jerk, torque_rate=rate)
    limits = {"torque_lower": -force, "torque_upper": force, "velocity_limit": speed}
    return with_robots(cell, **{name: np.full(3, limit) for name, limit in limits.items()})


def s_curve(jerk, acceleration=np.inf, speed=np.inf):
    """Least time from rest to rest of three to seven segments of constant jerk (the double S of textbooks)."""
    ramp = (WAY / (2 * jerk)) ** (1 / 3)
    if jerk * ramp <= acceleration and jerk * ramp**2 <= speed:
        return 4 * ramp
    ramp = min(acceleration / jerk, np.sqrt(speed / jerk))
    reached = ramp * jerk
    top = -reached * ramp / 2 + np.sqrt((reached * ramp) ** 2 / 4 + WAY * reached)
    if top <= speed:
        return 2 * (ramp + top / reached)
    return WAY / speed + speed / reached + ramp


def test_the_s_curve_of_this_page_is_right():
    """Jerk alone: (32 L / j)^(1/3); no jerk limit: 2 √(L/a) and L/v + v/a."""
    assert s_curve(5.0) == pytest.approx((32 * WAY / 5.0) ** (1 / 3))
    assert s_curve(1e9, 3.0) == pytest.approx(2 * np.sqrt(WAY / 3.0), rel=1e-6)
    assert s_curve(1e9, 3.0, 1.0) == pytest.approx(WAY / 1.0 + 1.0 / 3.0, rel=1e-6)


@pytest.mark.parametrize(
    ("jerk", "acceleration", "speed"),
    [(5.0, np.inf, np.inf), (50.0, 40 / MOVED, np.inf), (50.0, np.inf, 1.5), (50.0, 40 / MOVED, 1.0)],
)
def test_jerk_with_force_and_speed_limits(tmp_path, jerk, acceleration, speed):
    force = STRONG if np.isinf(acceleration) else acceleration * MOVED / 2
    cell = gantry_cell(tmp_path, jerk=jerk, force=force, speed=speed)
    found = mrts.retime(cell, along_x(NODES), rates=True, between=None)
    assert -SHORTER < found.duration / s_curve(jerk, acceleration, speed) - 1 < LONGER


@pytest.mark.parametrize("force", [STRONG, 20.0])
def test_force_rates_are_a_jerk_of_what_is_moved(tmp_path, force):
    """Both arms push with all their rate: 2 R / 11 kg, however the object's share is split."""
    rate = 60.0  # N/s
    cell = gantry_cell(tmp_path, rate=rate, force=force)
    found = mrts.retime(cell, along_x(NODES), rates=True, between=None)
    assert -SHORTER < found.duration / s_curve(2 * rate / MOVED, 2 * force / MOVED) - 1 < LONGER
