"""Norms and cones of the motion in smooth timing: circles, whose polygons linear programs have."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mrts
from mrts.base.errors import InputError
from mrts.cell.points import CarriedThing
from mrts.limits import limit_rows, motion_limits
from mrts.limits.motion_limits import norm_rows, object_point
from mrts.limits.rows import RowName

CORNER, MOST = np.array([0.3, 0.4, 0.5]), 3.0
"""A point of the object, whose way is bent, and the largest size of its acceleration [m/s²]."""

ROUNDING = 1e-12


@pytest.fixture(scope="module")
def lift_and_turn():
    return mrts.load_motion(Path(mrts.__file__).parent / "data/dual_ur5/lift_and_turn.yaml")


def corner_limit(cell, motion):
    return norm_rows(cell, RowName("acceleration", "object", "corner", "m/s²"), *object_point(motion, CORNER), MOST)


def sides_alone(cell, motion):
    """The same, a row for each side."""
    rows = corner_limit(cell, motion)
    return replace(rows, names=tuple(replace(name, sides=0) for name in rows.names))


def test_smooth_timing_keeps_norms_themselves(dual_ur5, lift_and_turn, monkeypatch):
    """Polygons with more and more sides come near it, at the rate of their distance from the circle."""
    best = mrts.retime(dual_ur5, lift_and_turn, rates=11.5, limits=[corner_limit], between=None)
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


@pytest.mark.parametrize("wrong", ["order", "speed", "force"])
def test_a_polygon_of_another_plane_is_refused(wrong, dual_ur5, lift_and_turn):
    """As a circle of r̈ and ṙ² it would be none: torques overstepped limits twofold."""
    shuffled = np.random.default_rng(3).permutation(112)

    def mixed(cell, motion):
        rows = corner_limit(cell, motion)
        if wrong == "order":
            return replace(rows, rate=rows.rate[:, shuffled], square=rows.square[:, shuffled])
        if wrong == "speed":
            return replace(rows, speed=np.abs(rows.rate))
        return replace(rows, wrench_matrix=rows.wrench_matrix + 1)

    with pytest.raises(InputError) as refused:
        mrts.retime(dual_ur5, lift_and_turn, limits=[mixed], rates=11.5)
    assert refused.value.key == "names"


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
