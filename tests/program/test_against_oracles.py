"""Smooth timing against the same mathematics by cvxpy, and against closed forms of gantries along a line."""

import numpy as np
import pytest
from changed_robots import with_robots
from conftest import DATA
from gantries import UPHILL, along_x, gantries, uphill_gantries
from random_motors import equipped
from shipped_cells import shipped_motion
from smooth_program import Rates, quintic_path, smooth_timing, with_third

import mrts

RATE = 11.0
"""[1/s]; of the torque limits, as Franka publishes them."""

SAME = 1e-3
"""Share of the duration: both stop where a step wins less than 1e-4 or 1e-5 of it."""


def shipped(name):
    """A shipped cell, its motion, and the torque rates that are asked for."""
    cell = mrts.load_cell(DATA.parent / name / "cell.yaml")
    limits = np.concatenate([robot.torque_upper for robot in cell.robots])
    return cell, shipped_motion(name), RATE * limits


@pytest.mark.parametrize("name", ["planar_dual_arm", pytest.param("dual_ur5", marks=pytest.mark.slow)])
def test_torque_rates_on_the_shipped_cells(name):
    cell, keys, rates = shipped(name)
    ours = mrts.retime(cell, mrts.load_motion(keys), rates=RATE, between=None, distribute="least-torque")
    theirs = smooth_timing(cell, quintic_path(cell, keys, keys["samples"]), Rates(torque=rates))
    assert ours.duration == pytest.approx(theirs.duration, rel=SAME)


def test_jerk_and_wrench_rates_together():
    cell, keys, rates = shipped("planar_dual_arm")
    jerk, wrench = np.full(6, 3e3), np.tile([60.0, 60.0, 30.0], 2)
    limited = with_robots(equipped(cell, jerk=3e3), contact_rate=wrench[:3])
    ours = mrts.retime(limited, mrts.load_motion(keys), rates=RATE, between=None, distribute="least-torque")
    path = with_third(ours.pieces[0].piece.path)
    theirs = smooth_timing(cell, path, Rates(torque=rates, jerk=jerk, wrench=wrench))
    assert ours.duration == pytest.approx(theirs.duration, rel=SAME)
    alone = smooth_timing(cell, path, Rates(torque=rates))
    assert theirs.duration > (1 + 2 * SAME) * alone.duration  # they do limit it


def test_every_load_of_a_box_is_carried():
    """One timing for all corners of the box, each with torques of its own."""
    cell, keys, rates = shipped("planar_dual_arm")
    cell = cell.with_variation(mass=(0.5, 2.0), izz=(0.5, 3.0))
    ours = mrts.retime(cell, mrts.load_motion(keys), rates=RATE, between=None, distribute="least-torque")
    loads = [cell.load_box.load_at({"mass": k, "izz": 1.0}) for k in (0.5, 2.0)]  # the bar does not turn
    theirs = smooth_timing(cell, with_third(ours.pieces[0].piece.path), Rates(torque=rates), loads=loads)
    alone = smooth_timing(cell, with_third(ours.pieces[0].piece.path), Rates(torque=rates))
    assert ours.duration == pytest.approx(theirs.duration, rel=SAME)
    assert theirs.duration > (1 + 2 * SAME) * alone.duration


def test_friction_presses_and_helps(tmp_path):
    cell = uphill_gantries(tmp_path, viscous=12.0, coulomb=np.array([1.0, 0.0, 0.0]))
    rates = np.concatenate([3.0 * robot.torque_upper for robot in cell.robots])
    ours = mrts.retime(cell, along_x(81, profile="quintic"), rates=3.0, between=None, distribute="least-torque")
    path = with_third(ours.pieces[0].piece.path)
    theirs = smooth_timing(cell, path, Rates(torque=rates))
    ideal = smooth_timing(gantries(tmp_path, gravity=(-UPHILL, 0, 0)), path, Rates(torque=rates))
    assert ours.duration == pytest.approx(theirs.duration, rel=SAME)
    assert abs(theirs.duration / ideal.duration - 1) > 2 * SAME


WAY = 2.0  # m
MOVED = 11.0  # kg
STRONG = 1e6  # N
NODES = 201
LONGER = 1.5e-3
"""Share of the duration: jerk keeps its limit at both ends of a segment, so on it it lies below by a step of it."""

SHORTER = 2e-4
"""Likewise: the corners of the jerk lie between nodes."""

AT_ENDS = 0.01
"""Of a constant jerk inside the segments at rest, where no row at a node sees x fall: it would be 4 times as large."""


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
    found = mrts.retime(cell, along_x(NODES), rates=True, between=None, distribute="least-torque")
    assert -SHORTER < found.duration / s_curve(jerk, acceleration, speed) - 1 < LONGER
    done = found.retimed.trajectory
    for time, way in ((done.time, done.q[:, 0]), (done.duration - done.time[::-1], done.q[::-1, 0])):
        assert 6 * abs(way[1] - way[0]) / time[1] ** 3 == pytest.approx(jerk, rel=AT_ENDS)


@pytest.mark.parametrize("force", [STRONG, 20.0])
def test_force_rates_are_a_jerk_of_what_is_moved(tmp_path, force):
    """Both arms push with all their rate: 2 R / 11 kg, however the object's share is split."""
    rate = 60.0  # N/s
    cell = gantry_cell(tmp_path, rate=rate, force=force)
    found = mrts.retime(cell, along_x(NODES), rates=True, between=None, distribute="least-torque")
    assert -SHORTER < found.duration / s_curve(2 * rate / MOVED, 2 * force / MOVED) - 1 < LONGER
