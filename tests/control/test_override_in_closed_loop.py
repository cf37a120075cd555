"""A plan that its speed override plays in closed loop."""

import json

import numpy as np
import pytest
from command_line import mrts_command
from random_motors import equipped
from shipped_cells import DATA

import mrts
from mrts.control.simulate import kept_uses
from mrts.control.speed_override import commanded, random_wishes, read_wishes, wanted_at_ticks

SAME = 1e-6
"""Share of a limit by which the override at 1 differs from the plan where its ticks are the plan's samples."""

ROUNDED = 1e-12
"""Share by which ticks are longer than the time between samples, so that the last is not just before the end."""

NEAR = 6
"""Ticks about the reversal of a joint, whose way is that of the piece between two samples of the plan."""

TICK = 1e-3
"""Share of a limit that is passed at most at a tick, as by the plan between its samples."""


@pytest.fixture(scope="module")
def smooth(dual_ur5, lift_and_turn):
    return mrts.retime(dual_ur5, lift_and_turn, rates=10.0)


def test_the_planned_speed_is_the_plan(turned):
    plan = turned.trajectory
    controller = mrts.Controller(rate=(plan.motion.samples - 1) / plan.duration * (1 - ROUNDED))
    asked, found = (mrts.simulate(turned, controller, override=wishes) for wishes in (None, np.array([[0.0, 1.0]])))
    assert found.plan.duration == pytest.approx(plan.duration)
    until = found.played.time <= plan.duration  # then it holds with wrenches of its own
    robots = plan.cell.robots
    for name, limit in (("torque", "torque_upper"), ("wrench", "wrench_upper")):
        size = np.concatenate([getattr(robot, limit) for robot in robots])
        off = getattr(found.played, name)[until] - getattr(asked.played, name)[until]
        assert np.max(np.abs(off) / size) <= SAME


def test_random_wishes_keep_all_limits_until_the_end(smooth):
    found = mrts.simulate(smooth, override=random_wishes(1, smooth.duration))
    assert max(use.share for use in kept_uses(found.plan)) <= 1 + TICK
    np.testing.assert_array_equal(found.plan.q[-1], smooth.retimed.trajectory.q[-1])
    assert not np.any(found.plan.dq[-1])
    assert found.plan.duration > 1.2 * smooth.duration
    assert found.passed[0].share > 1.3  # torques that step are not had by motors that lag


@pytest.mark.parametrize("seed", [1, 2])
def test_with_rates_the_closed_loop_keeps_what_the_plan_keeps(smooth, seed):
    asked, wishes = mrts.simulate(smooth), random_wishes(seed, smooth.duration)
    found = mrts.simulate(smooth, override=wishes, rates=20.0)
    assert found.uses[0][1].share <= asked.uses[0][1].share
    assert found.kept
    assert found.saturated == 0


def test_a_stop_ends_where_it_stands(smooth):
    found = mrts.simulate(smooth, override=np.array([[0.0, 1.0], [0.1, 0.0]]))
    assert 0.1 < found.plan.duration < 0.14
    assert not np.any(found.plan.dq[-1])
    assert np.max(np.abs(found.joint_error)) < 0.03


def test_friction_is_that_of_the_way_on_even_where_it_stands(dual_ur5, lift_and_turn):
    """What a controller takes off its torques that feeds no friction forward."""
    override = mrts.SpeedOverride(mrts.scale(equipped(dual_ur5, coulomb=2.0, viscous=1.0), lift_and_turn))
    done = commanded(override, np.repeat([1.0, 0.0, 1.0], [150, 100, 1000]), 1e-3)
    moving = np.abs(done.dq) > 1e-6 * np.max(np.abs(done.dq))
    last = np.maximum.accumulate(np.where(moving, np.arange(len(moving))[:, None], 0), axis=0)
    way = np.take_along_axis(np.sign(done.dq), last, axis=0)
    turning = np.cumsum(np.abs(np.diff(way, axis=0, prepend=way[:1])) > 0, axis=0)
    near = turning[2 * NEAR :] != turning[: -2 * NEAR]
    off = (done.friction - done.dq - 2.0 * way)[NEAR:-NEAR]
    assert np.count_nonzero(~moving[NEAR:-NEAR] & ~near) > 1000
    assert np.max(np.abs(off[~near])) < 1e-9


@pytest.mark.quick
def test_wishes_are_read_and_refused_by_row_and_column(tmp_path):
    table = tmp_path / "wishes.csv"
    table.write_text("t,speed\n2,1\n2.5,0\n")
    np.testing.assert_array_equal(read_wishes(table), [[0.0, 1.0], [0.5, 0.0]])
    for text, key in (
        ("t,speed\n0,1\n0.1,fast\n", "row 2, column speed"),
        ("t,speed\n0,1\n0,0\n", "row 2, column t"),
        ("t,speed\n0,1\n0.1\n", "row 2"),
        ("t,pace\n0,1\n", ""),
        ("t\n0\n", ""),
        ("t,speed\n", ""),
    ):
        table.write_text(text)
        with pytest.raises(mrts.InputError) as refused:
            read_wishes(table)
        assert (refused.value.where, refused.value.key) == (str(table), key)


def test_wishes_that_lead_nowhere_are_refused(turned):
    for wishes in ([[0.1, 1.0]], [[0.0, 1.0], [1e4, 1.0]], [[0.0, np.nan]], [0.0, 1.0], []):
        with pytest.raises(mrts.InputError, match=r"^override"):
            wanted_at_ticks(wishes, turned.duration, 1e-3)
    with pytest.raises(mrts.InputError, match=r"^rates"):
        mrts.simulate(turned, rates=20.0)
    for plan, wishes in ((turned, [[0.0, 0.0]]), (turned.trajectory, [[0.0, 1.0]])):
        with pytest.raises(mrts.InputError, match=r"^override"):
            mrts.simulate(plan, override=wishes)


def test_the_command_plays_files_and_seeds(turned, tmp_path):
    cell, plan, table = DATA / "dual_ur5" / "cell.yaml", tmp_path / "plan.npz", tmp_path / "wishes.csv"
    mrts.save_result(turned, plan)
    table.write_text("t,speed\n0,0.5\n")
    done = mrts_command("simulate", cell, plan, "--override", table, "-q", "--json", "-")
    found = json.loads(done.stdout)
    assert found["duration"] == pytest.approx(2 * turned.duration, abs=2e-3)
    assert mrts_command("simulate", cell, plan, "--override", "random:x").returncode == 2
