"""The reserve of a plan: what it means, that torques keep it, and what a kept reserve does to every question."""

from dataclasses import replace

import numpy as np
import pytest
from cell_bank import drawn_until, random_planar_cell, random_spatial_cell
from changed_robots import with_left
from gantries import along_x, gantries
from random_motors import drawn_motors

import mrts

BISECTION = 1e-6
ROUNDING = 1e-8  # of a limit: programs are solved to 1e-9
FORMULAS = 1e-9


def feasible(case, question):
    """The fastest plan of a random case that can be played at all."""
    cell, asked = asked_questions(question, case.cell)
    result = mrts.scale(cell, case.motion, **asked)
    moves = result.status.admits_motion and 0 < result.range.upper.c2 < np.inf and result.range.lower.c2 == 0
    return (cell, result.range.upper.c2, asked) if moves else None


def random_plan(seed, folder, question=0):
    """A cell, its motion, a c², and what else is asked."""
    rng = np.random.default_rng([16, seed])
    draw = random_planar_cell if seed % 3 else random_spatial_cell
    case, (cell, fastest, asked) = drawn_until(
        lambda case: feasible(case, question), lambda: draw(rng, folder, arms=2 + seed % 2)
    )
    return cell, case.motion, fastest * rng.uniform(0.2, 0.9), asked


def asked_questions(seed, cell):
    """The cell with a question: a free distribution, a fixed one, uncertain loads, the torque form, motors."""
    vary = cell.with_variation(mass=(0.9, 1.1), izz=(0.8, 1.2))
    return [
        (cell, {}),
        (cell, {"distribute": "reserve"}),
        (cell, {"sharing": mrts.LoadSharing()}),
        (vary, {}),
        (vary, {"sharing": mrts.LoadSharing()}),
        (cell, {"formulation": "torque"}),
        (drawn_motors(np.random.default_rng(seed), cell), {"distribute": "reserve"}),
    ][seed % 7]


@pytest.mark.parametrize("seed", range(7))
def test_the_reserve_is_the_largest_that_leaves_c2_in_the_range(seed, tmp_path):
    cell, motion, c2, asked = random_plan(seed, tmp_path, seed)
    asked = asked | {"between": None}  # samples that are added depend on the reserve
    reserve = mrts.scale(cell, motion, c2, **asked).reserve
    inside, outside = 0.0, 1 - BISECTION
    while outside - inside > BISECTION:
        middle = (inside + outside) / 2
        admitted = mrts.scale(cell, motion, reserve=middle, **asked).admitted(c2)
        inside, outside = (inside, middle) if admitted is None else (middle, outside)
    print(asked, "reserve", reserve, "bisection", inside)
    assert reserve.share == pytest.approx(inside, abs=BISECTION)
    assert reserve.rows
    assert 0 <= reserve.time <= motion.time[-1]


def test_closed_form_on_gantries(tmp_path):
    """Each of two gantries of 4 kg pushes half of 3 kg with 20 N: at c² times the fastest, 1 - c²/c²⁺ is left."""
    cell, motion = gantries(tmp_path, wrench=50.0), along_x()
    fastest = mrts.scale(cell, motion).range.upper.c2
    result = mrts.scale(cell, motion, 0.25 * fastest, distribute="reserve")
    assert result.reserve.share == pytest.approx(0.75, abs=FORMULAS)
    shrunk = mrts.scale(cell, motion, reserve=0.1)
    assert shrunk.range.upper.c2 == pytest.approx(0.9 * fastest, rel=FORMULAS)
    assert max(use.share for use in shrunk.trajectory.limit_uses) == pytest.approx(0.9, abs=ROUNDING)
    assert "with 10 % of every limit in reserve, c² ∈" in shrunk.sentence()
    quick = gantries(tmp_path, velocity=1.0)
    assert mrts.scale(quick, motion, reserve=0.1).range.upper.c2 == pytest.approx(
        0.81 * mrts.scale(quick, motion).range.upper.c2, rel=FORMULAS
    )
    assert mrts.scale(quick, motion, 0.01 / 9).reserve.share == pytest.approx(1 - 0.1, abs=FORMULAS)


def test_sides_that_cross_are_an_outcome_that_names_the_reserve(planar_cell, lift):
    cell = with_left(planar_cell, wrench_lower=np.array([0.9, -9, -9]), wrench_upper=np.array([1.0, 9, 9]))
    result = mrts.scale(cell, lift, reserve=0.1)
    assert result.status is mrts.ScalingStatus.INFEASIBLE
    assert "left/fx contact wrench (lower, 0.99 N)" in result.sentence()
    assert result.to_json()["explanation"].startswith("101 of 101 samples are infeasible")
    uncertain = cell.with_variation(mass=(0.5, 2.0))
    for asked in (
        {"load": "guaranteed"},
        {"load": "possible"},
        {"load": "grid:3"},
        {"sharing": mrts.LoadSharing()},
        {"formulation": "torque"},
    ):
        found = mrts.scale(uncertain, lift, reserve=0.1, **asked)
        assert "with 10 % of every limit in reserve, infeasible: 101 of 101 samples are" in found.sentence()
    timing = mrts.retime(cell, lift, reserve=0.1)
    assert timing.status is mrts.RetimingStatus.INFEASIBLE
    assert timing.sentence().startswith("with 10 % of every limit in reserve, infeasible")


@pytest.mark.parametrize("reserve", [-0.1, 1.0, 2, np.nan, np.inf, "0.1", True, [0.1]])
def test_a_share_is_from_0_to_below_1(planar_cell, lift, reserve):
    for ask in (
        lambda: planar_cell.with_reserve(reserve),
        lambda: mrts.scale(planar_cell, lift, reserve=reserve),
        lambda: mrts.retime(planar_cell, lift, reserve=reserve),
        lambda: replace(planar_cell, reserve=reserve),
    ):
        with pytest.raises(mrts.InputError, match=r"reserve = .*: must be"):
            ask()
