"""Which rows bind where, and how far limits are used: against the ranges and the torques themselves."""

import numpy as np
import pytest
from conftest import UR5

import mrts
from mrts.plots.range_plots import MOST_LANES, binding_lanes, spans
from mrts.scaling.scaled_trajectory import accumulated_energy


@pytest.fixture(scope="module")
def spatial(dual_ur5):
    return mrts.scale(dual_ur5.without_velocity_limits(), mrts.load_motion(UR5 / "lift_and_turn.yaml"))


@pytest.mark.quick
def test_lanes_are_filled_exactly_where_their_rows_bind(spatial):
    samples, lanes = spatial.range.samples, binding_lanes(spatial.range)
    assert len(lanes) == MOST_LANES  # 21 rows bind somewhere: the rest shares the last lane
    labels = [{row.label for row in spatial.range.binding(k, "upper")} for k in range(len(samples.time))]
    named = {lane.label for lane in lanes[:-1]}
    for lane in lanes[:-1]:
        assert lane.binds.tolist() == [lane.label in of_sample for of_sample in labels]
    assert lanes[-1].binds.tolist() == [bool(of_sample - named) for of_sample in labels]
    assert lanes[-1].label == f"{len(set.union(*labels) - named)} others"
    first = [row.label for row in spatial.range.upper.rows]
    assert [lane.label for lane in lanes if lane.sets] == first == [lane.label for lane in lanes[: len(first)]]


def test_conflicts_have_lanes_of_their_own(planar_cell, lift):
    found = mrts.scale(planar_cell.with_mass(24.0), lift).range
    lanes = [lane for lane in binding_lanes(found) if lane.kind == "conflict"]
    infeasible = {conflict.sample for conflict in found.samples.conflicts}
    assert set(np.flatnonzero(np.any([lane.binds for lane in lanes], axis=0)).tolist()) == infeasible
    assert {"left/elbow ↑", "right/elbow ↓"} <= {lane.label for lane in lanes}
    # c² ≥ 0 alone takes no lane
    assert {lane.kind for lane in binding_lanes(mrts.scale(planar_cell, lift).range)} == {"upper"}


def test_spans_reach_half_way_to_the_neighbours():
    time = np.array([0.0, 1.0, 2.0, 4.0])
    assert spans(time, np.array([True, False, True, True])) == [(0.0, 0.5), (1.5, 4.0)]
    assert spans(time, np.array([False, True, False, False])) == [(0.5, 1.5)]
    assert spans(time, np.zeros(4, dtype=bool)) == []


def test_accumulated_energy_ends_at_the_energy(spatial):
    done = spatial.trajectory
    whole = accumulated_energy(done.time, done.power)
    assert whole[0] == 0
    assert whole[-1] == pytest.approx(done.energy, rel=1e-12)
    parts = [accumulated_energy(done.time, done.power[:, part]) for part in spatial.cell.joint_slices.values()]
    np.testing.assert_allclose(np.sum(parts, axis=0), whole, atol=1e-12)
