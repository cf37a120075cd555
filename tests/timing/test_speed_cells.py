"""The first profile with terms in the speed where slow ones are none, and why there is none at all."""

import numpy as np
import pytest
from changed_robots import with_robots
from gantries import along_x, gantries
from one_arm import duration
from random_motors import equipped

import mrts
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.timing import successive_profiles as successive
from mrts.timing.path_pieces import path_pieces

SAME = 2e-6
"""Durations of two searches that each stop at 1e-6."""


def on_an_arc(folder, **motors):
    """Two gantries on an arc of radius 2 that may only push towards its centre, by 1 to 5 N each: 3 kg need speed."""
    cell = equipped(gantries(folder), **motors)
    push = {"wrench_lower": np.array([-np.inf, 1.0, -np.inf]), "wrench_upper": np.array([np.inf, 5.0, np.inf])}
    cell = with_robots(cell, **push)
    time = np.linspace(-0.35, 0.35, 61)
    zero, s, c = np.zeros(61), np.sin(time), np.cos(time)
    position, velocity = np.column_stack([2 * s, -2 * c, zero]), np.column_stack([2 * c, 2 * s, zero])
    turn = np.zeros((61, 3))
    motion = mrts.ObjectMotion(
        time + 0.35,
        position,
        np.tile(np.eye(3), (61, 1, 1)),
        np.concatenate([velocity, turn], axis=1),
        np.concatenate([-position, turn], axis=1),
    )
    return cell, motion


def rows(cell, motion):
    (piece,) = path_pieces(cell, mrts.follow_object(cell, motion))
    return build_sample_problem(motion_rows(cell, piece.path), varying=True), piece


@pytest.mark.quick
def test_a_path_that_needs_speed_everywhere_is_timed(tmp_path):
    cell, motion = on_an_arc(tmp_path, viscous=1.0, coulomb=1.0)
    found = mrts.retime(cell, motion, start_speed=1.0, end_speed=1.0)
    assert found.status.admits_motion, found.summary()
    x = found.pieces[0].profile.x / found.pieces[0].piece.speed ** 2
    assert np.min(x) > 1 / 3  # 2 N at least
    assert np.max(x) <= 5 / 3 / np.cos(0.35) + 1e-9  # 10 N at most
    assert found.retimed.residuals().limits <= 1e-8
    slow = mrts.retime(cell, motion, start_speed=0.3, end_speed=1.0)
    assert slow.status.value == "start speed not admissible"
    assert "these conflict" in slow.explanation, slow.explanation


def test_the_search_through_all_speeds_ends_at_the_same_profile(tmp_path, monkeypatch, planar_cell, lift):
    shipped = equipped(planar_cell, viscous=8.0, coulomb=5.0), lift
    bent = on_an_arc(tmp_path, viscous=1.0, coulomb=1.0)
    for (cell, motion), ends in ((shipped, (0.0, 0.0)), (bent, (2.0, 2.0))):
        problem, piece = rows(cell, motion)
        known = successive.successive_profiles([problem], piece.step, ends)
        monkeypatch.setattr(successive, "STARTS", ())
        searched = successive.successive_profiles([problem], piece.step, ends)
        monkeypatch.undo()
        assert isinstance(known, list)
        assert isinstance(searched, list)
        times = [duration(piece.step, steps[-1].x) for steps in (known, searched)]
        assert times[0] == pytest.approx(times[1], rel=SAME)
        assert duration(piece.step, searched[0].x) > times[1]


@pytest.mark.quick
def test_what_cannot_be_timed_says_which_limits_conflict(planar_cell, lift, tmp_path):
    load = np.array([50.0, 0, 0, 0, 1, 1, 1, 0, 0, 0])
    heavy, ideal = (mrts.retime(equipped(planar_cell.with_load(load), viscous=b), lift) for b in (8.0, 0.0))
    assert heavy.status is ideal.status
    assert heavy.conflict is not None
    limits = [row for row in ideal.conflict.rows if row.name.kind != "speed"]
    assert heavy.conflict.rows == tuple(limits)  # at rest viscous friction has no effect
    one_way = with_robots(gantries(tmp_path, wrench=3.0), wrench_upper=np.array([-1.0, np.inf, np.inf]))
    one_way = equipped(one_way, viscous=1.0)
    found = mrts.retime(one_way, along_x())
    assert found.status.value == "start speed not admissible", found.summary()
    assert "cannot start from rest" in found.explanation
    assert "fx contact wrench" in found.explanation
