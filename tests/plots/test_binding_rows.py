"""Which rows bind where, and how far limits are used: against the ranges and the torques themselves."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from shown_results import still_motion

import mrts
from mrts.limits.rows import STANDSTILL
from mrts.plots.labels import row_label
from mrts.plots.plot import value_ends
from mrts.plots.range_plots import MOST_LANES, binding_lanes, c2_ends, spans
from mrts.scaling.limit_use import limit_uses
from mrts.scaling.scaled_trajectory import accumulated_energy

TOO_HARD = np.array([2.5, 0, 0, -2.5, 0, 0])
"""A squeeze above the limit of 2 N."""


@pytest.fixture(scope="module")
def spatial(dual_ur5):
    return mrts.scale(
        dual_ur5.without_velocity_limits(), mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml")
    )


@pytest.mark.quick
def test_lanes_are_filled_exactly_where_their_rows_bind(spatial):
    samples, lanes = spatial.range.samples, binding_lanes(spatial.range)
    assert len(lanes) == MOST_LANES  # 21 rows bind somewhere: the rest shares the last lane
    labels = [{row_label(row) for row in spatial.range.binding(k, "upper")} for k in range(len(samples.time))]
    named = {lane.label for lane in lanes[:-1]}
    for lane in lanes[:-1]:
        assert lane.binds.tolist() == [lane.label in of_sample for of_sample in labels]
    assert lanes[-1].binds.tolist() == [bool(of_sample - named) for of_sample in labels]
    assert lanes[-1].label == f"{len(set.union(*labels) - named)} others"


def test_rows_that_set_the_range_come_first(spatial):
    first = [row_label(row) for row in spatial.range.upper.rows]
    lanes = binding_lanes(spatial.range)
    assert [lane.label for lane in lanes[: len(first)]] == first
    assert [lane.sets for lane in lanes] == [True] * len(first) + [False] * (len(lanes) - len(first))


def test_conflicts_have_lanes_of_their_own(planar_cell, lift):
    found = mrts.scale(planar_cell.with_mass(24.0), lift).range
    lanes = [lane for lane in binding_lanes(found) if lane.kind == "conflict"]
    infeasible = {conflict.sample for conflict in found.samples.conflicts}
    assert set(np.flatnonzero(np.any([lane.binds for lane in lanes], axis=0)).tolist()) == infeasible
    assert {"left/elbow ↑", "right/elbow ↓"} <= {lane.label for lane in lanes}


def test_standing_still_alone_takes_no_lane(planar_cell, lift):
    assert {lane.kind for lane in binding_lanes(mrts.scale(planar_cell, lift).range)} == {"upper"}


def test_nothing_binds_where_nothing_limits_the_speed(spatial, planar_cell, lift):
    """With velocity limits and without any: at rest there is nothing that they bound."""
    assert spatial.range.samples.status[0] is mrts.SampleStatus.UNBOUNDED
    assert spatial.range.samples.binding(0, "upper") == ()
    still = mrts.scale(planar_cell, still_motion(lift))
    assert [still.range.samples.binding(sample, "upper") for sample in range(11)] == [()] * 11
    assert binding_lanes(still.range) == []


def test_rows_are_named_in_a_few_letters():
    assert row_label(mrts.ActiveRow(mrts.RowName("wrench", "left", "fx", "N"), "lower", -2.0)) == "left/fx ↓"
    assert row_label(mrts.ActiveRow(mrts.RowName("speed", "left", "elbow"), "upper", 1.0)) == "left/elbow speed ↑"
    assert row_label(mrts.ActiveRow(STANDSTILL, "lower", 0.0)) == "c² ≥ 0"


def test_spans_reach_half_way_to_the_neighbours():
    time = np.array([0.0, 1.0, 2.0, 4.0])
    assert spans(time, np.array([True, False, True, True])) == [(0.0, 0.5), (1.5, 4.0)]
    assert spans(time, np.array([False, True, False, False])) == [(0.5, 1.5)]
    assert spans(time, np.zeros(4, dtype=bool)) == []


def test_each_side_of_unequal_limits_counts_by_itself(planar_cell, lift):
    """Limits of a wrench component at 0 and at infinity: a share of zero has the size of the other limits."""
    result = mrts.scale(planar_cell.without_wrench_limits(), lift)
    left, right = planar_cell.robots
    unlimited = np.full(3, np.inf)
    one_sided = replace(left, wrench_lower=np.array([-np.inf, -40.0, -np.inf]), wrench_upper=unlimited)
    zero = replace(right, wrench_lower=np.array([-np.inf, 0.0, -np.inf]), wrench_upper=unlimited)
    done = replace(result.trajectory, cell=replace(result.cell, robots=(one_sided, zero)))
    changed = replace(result, cell=done.cell, trajectory=done)
    uses = {use.name.robot: use for use in limit_uses(changed) if use.name.kind == "wrench"}
    fy = {name: wrench[:, 1] for name, wrench in result.wrench.items()}
    assert uses["left"].share == pytest.approx(max(0, np.max(-fy["left"]) / 40), rel=1e-12)
    assert uses["right"].share == pytest.approx(1 - np.min(fy["right"]) / 40, rel=1e-12)


def test_velocities_count_whether_they_are_enforced_or_not(dual_ur5, spatial):
    """Without enforcement the motion is too fast; with it, the fastest joint is at its limit."""
    for result in (spatial, mrts.scale(dual_ur5, spatial.motion)):
        uses = {(use.name.robot, use.name.element): use for use in limit_uses(result) if use.name.kind == "velocity"}
        share = np.max(np.abs(result.trajectory.dq), axis=0) / np.concatenate(
            [robot.velocity_limit for robot in dual_ur5.robots]
        )
        names = [(robot.name, joint) for robot in dual_ur5.robots for joint in robot.joints]
        assert [uses[name].share for name in names] == pytest.approx(share.tolist(), rel=1e-12)
        assert max(use.share for use in uses.values()) == pytest.approx(
            1 if result.cell.enforces_velocity_limits else 2.335, rel=1e-3
        )


def test_an_infeasible_result_uses_no_limits(planar_cell, lift):
    assert limit_uses(mrts.scale(planar_cell.with_mass(60.0), lift)) == []


def test_accumulated_energy_ends_at_the_energy(spatial):
    done = spatial.trajectory
    whole = accumulated_energy(done.time, done.power)
    assert whole[0] == 0
    assert whole[-1] == pytest.approx(done.energy, rel=1e-12)
    parts = [accumulated_energy(done.time, done.power[:, part]) for part in spatial.cell.joint_slices.values()]
    np.testing.assert_allclose(np.sum(parts, axis=0), whole, atol=1e-12)


def test_axes_show_values_and_near_limits_but_not_far_ones():
    values = np.array([[-1.0], [2.0]])
    low, high = value_ends(values, np.array([[-4.0], [100.0]]))
    assert -5 < low < -4
    assert 2 < high < 3
    assert value_ends(np.zeros((2, 1)), np.array([[-3.0], [np.inf]]))[0] < -3
    assert value_ends(np.zeros((2, 1)), np.empty((2, 0))) == (-1.0, 1.0)


def test_the_axis_of_c2_follows_the_range_and_not_what_happens_near_rest(spatial, planar_cell, lift):
    low, high = c2_ends(spatial.range)
    assert low < 0
    assert spatial.range.upper.c2 < high < 5 * spatial.range.upper.c2 < np.nanmax(spatial.range.samples.upper[1:-1])
    nothing = mrts.scale(planar_cell, lift, sharing=mrts.LoadSharing(internal_wrench=TOO_HARD)).range
    assert all(status is mrts.SampleStatus.INFEASIBLE for status in nothing.samples.status)
    assert c2_ends(nothing)[1] > 0
