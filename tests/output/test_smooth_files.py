"""Files of smooth timing: what a table, a bag and a saved result carry keeps its rates, and is the same again."""

import numpy as np
import pytest
from conftest import UR5
from shown_results import with_all_rates

import mrts
from mrts.output.trajectory_table import played_rows

ROUNDING = 1e-6
"""Share by which a difference of two rows may pass a rate: rounding and what programs are solved to."""

EXACT = 1e-9
"""Largest residual of the dynamics [N m, N], as of every result."""


NO_FASTER = 1e-4
"""By how much the largest c² within the rates may be off 1: the linear programs of the constant factor ask what torques
there are, the timing was found for by an interior point that comes near its limits, not to them."""


@pytest.fixture(scope="module")
def spatial(dual_ur5):
    motion = mrts.load_motion(UR5 / "lift_and_turn.yaml")
    return mrts.retime(dual_ur5, motion, rates=11.0, between=None, distribute="least-torque")  # rates set its speed


@pytest.fixture(scope="module")
def smooth(planar_cell, lift):
    return mrts.retime(with_all_rates(planar_cell), lift, rates=11.0)


def check_rates(result, kept):
    """That differences of neighbouring rows keep what was asked for, by no code of the programs."""
    rows = played_rows(result.trajectory)
    steps = np.diff(rows["t"])[:, None]
    for values, limits in ((rows["tau"], kept.torque), (rows["F"], kept.wrench)):
        assert np.max(np.abs(np.diff(values, axis=0)) / steps / limits) <= 1 + ROUNDING


@pytest.mark.parametrize("cell", ["planar", "spatial"])
def test_a_table_read_back_can_be_played_as_fast_and_no_faster_within_its_rates(cell, smooth, spatial, tmp_path):
    found = smooth if cell == "planar" else spatial
    mrts.write_trajectory_csv(found.retimed, tmp_path / "trajectory.csv")
    again = mrts.scale(found.cell, mrts.load_motion(tmp_path / "trajectory.csv"), rates=11.0, between=None)
    assert again.range.upper.c2 == pytest.approx(1, abs=NO_FASTER)
    assert {row.name.kind for row in again.range.upper.rows} & {"torque rate", "wrench rate"}
    assert not any(warning.code == "step-at-ends" for warning in again.warnings)


def test_torques_for_another_load_keep_the_rates_or_are_refused(planar_cell, lift):
    cell = with_all_rates(planar_cell.with_variation(mass=(0.2, 3.0)))
    found = mrts.retime(cell, lift, rates=11.0)
    assert len(found.loads) == 2
    for mass in (0.2, 1.7, 3.0):
        carried = mrts.torques_for_load(found.retimed, cell.load_box.load_at({"mass": mass}))
        check_rates(carried, found.smooth.rates)
        assert carried.cell.mass == pytest.approx(mass * cell.mass)
        residuals = carried.residuals()
        assert max(residuals.arms, residuals.object) < EXACT
    too_much = cell.load_box.load_at({"mass": 3.0}) * 1.5
    with pytest.raises(mrts.SelectionError, match="does not suit this load where rates are kept") as caught:
        mrts.torques_for_load(found.retimed, too_much)
    assert caught.value.result.trajectory is None
    alone = cell.load_box.load_at({"mass": 1.7})
    bare = mrts.torques_for_load(mrts.retime(planar_cell.with_load(alone), lift).retimed, alone)
    with pytest.raises(AssertionError):
        check_rates(bare, found.smooth.rates)  # a bang-bang timing does not keep them
