"""Norms and cones of the motion in smooth timing: circles, whose polygons linear programs have."""

from dataclasses import replace

import numpy as np
import pytest

import mrts
from mrts.cell.points import CarriedThing, PointLimit
from mrts.limits import limit_rows, motion_limits
from mrts.limits.motion_limits import norm_rows, object_point
from mrts.limits.rows import RowName

CORNER, MOST = np.array([0.3, 0.4, 0.5]), 3.0
"""A point of the object, whose way is bent, and the largest size of its acceleration [m/s²]."""

ROUNDING = 1e-12


def sides_alone(cell, motion):
    """A row for each side of the polygon of its acceleration."""
    name = RowName("acceleration", "object", "corner", "m/s²")
    rows = norm_rows(cell, name, *object_point(motion, CORNER), MOST)
    return replace(rows, names=(name,) * len(rows.names))


def test_smooth_timing_keeps_norms_themselves(dual_ur5, lift_and_turn, monkeypatch):
    """Polygons with more and more sides come near it, at the rate of their distance from the circle."""
    point = PointLimit(name="corner", point=tuple(CORNER), acceleration=MOST)
    best = mrts.retime(replace(dual_ur5, object_points=(point,)), lift_and_turn, rates=11.5, between=None)
    slower = []
    for sides in (224, 448, 896):
        monkeypatch.setattr(motion_limits, "NORM_SIDES", sides)
        inside = mrts.retime(dual_ur5, lift_and_turn, rates=11.5, limits=[sides_alone], between=None)
        slower.append(inside.duration / best.duration - 1)
    assert slower[0] > 1e-5
    assert slower[2] - (slower[1] - slower[2]) / 3 == pytest.approx(0, abs=1e-6)
    played = best.retimed.motion
    size = np.linalg.norm(object_point(played, CORNER)[1], axis=1)
    assert MOST * (1 - 2e-5) < np.max(size) <= MOST
    use = next(use for use in best.retimed.limit_uses if use.name.element == "corner")
    assert use.largest == pytest.approx(np.max(size), rel=ROUNDING)
    assert use.share == pytest.approx(np.max(size) / MOST, rel=ROUNDING)


def test_a_cup_takes_all_of_its_friction(dual_ur5, lift_and_turn):
    cup = CarriedThing(name="cup", at=[0.1, 0.05, 0.05], normal=[0, 0.02, 1], friction=0.5)
    cell = replace(dual_ur5, carried=(cup,))
    timed = mrts.retime(cell, lift_and_turn, rates=11.5).retimed
    played = timed.motion
    turn = cup.axes @ played.object.rotation.transpose(0, 2, 1)
    a, b, n = np.einsum("nkj,nj->kn", turn, object_point(played, cup.centre)[1] - cell.gravity)
    beyond = (np.hypot(a, b) - cup.friction * n) / (cup.friction * 9.81)
    assert -1e-4 < np.max(beyond) <= 1e-9
    rows = limit_rows(cell, played)
    excess = rows.excess(rows.value(timed.trajectory.torque, timed.trajectory.wrench, 0.0, 1.0))
    cups = np.array([name.element == "cup friction" for name in rows.names])
    assert excess[:, cups] == pytest.approx(np.tile(beyond[:, None], (1, cups.sum())), rel=2e-4, abs=ROUNDING)
