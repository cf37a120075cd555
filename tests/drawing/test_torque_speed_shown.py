"""Torque-speed curves where limits are shown: as what the motor gives at the plan's speed."""

from dataclasses import replace

import numpy as np
import pytest

import mrts
from mrts.figures import trajectory_figure
from mrts.limits.rows import TORQUE_SPEED
from mrts.output.summary_lines import scaling_lines
from mrts.report.plots import torque_plots
from mrts.report.tables import margins_table
from mrts.scaling.limit_use import limit_uses, limited_quantities
from mrts.viewer.panel import bars_html
from mrts.viewer.player_state import PlayerState

pytestmark = pytest.mark.quick

CURVE = np.array([[0, 120.0], [1, 110], [6, 10]])
"""Of the left shoulder and elbow, whose torque limits are 100 and 80 N m: its lines cross them within the lift."""


@pytest.fixture(scope="module")
def cell(planar_cell):
    left, right = planar_cell.robots
    motors = replace(left.motors, torque_speed=(CURVE, CURVE, None))
    return replace(planar_cell, robots=(replace(left, motors=motors), right))


@pytest.fixture(scope="module")
def result(cell, lift):
    return mrts.scale(cell, lift)


def largest(speed):
    """What the curve gives at a speed, by interpolation between its corners [N m]."""
    return np.interp(np.abs(speed), *CURVE.T)


def test_limits_of_the_torque_are_what_the_curve_gives_where_the_motor_drives(result):
    done = result.trajectory
    torques = limited_quantities(result, "torque", "left")
    for j, plain in enumerate(result.cell.robots[0].torque_upper[:2]):
        dq = done.dq[:, j]
        forward = np.minimum(plain, np.where(dq > 0, largest(dq), plain))
        backward = -np.minimum(plain, np.where(dq < 0, largest(dq), plain))
        np.testing.assert_allclose(torques.upper[:, j], forward, rtol=1e-12)
        np.testing.assert_allclose(torques.lower[:, j], backward, rtol=1e-12)
    assert np.ptp(torques.upper[:, 0]) + np.ptp(torques.lower[:, 0]) > 1
    assert np.ptp(torques.upper[:, 2]) == 0  # the wrist has no curve
    assert np.all(torques.values <= torques.upper + 1e-6)
    assert np.all(torques.values >= torques.lower - 1e-6)


def test_a_use_of_a_curve_tells_torque_and_limit_at_its_moment(result):
    done = result.trajectory
    uses = [use for use in limit_uses(result) if use.name.kind == TORQUE_SPEED]
    assert {use.name.element for use in uses} == {"shoulder", "elbow"}
    for use in uses:
        j = ["shoulder", "elbow"].index(use.name.element)
        sample = int(np.argmin(np.abs(done.time - use.time)))
        assert use.least == pytest.approx(np.min(done.torque[:, j]))
        assert use.largest == pytest.approx(np.max(done.torque[:, j]))
        lines = [(120.0, 10.0), (130.0, 20.0)]
        sides = [(-a - m * done.dq[sample, j], a - m * done.dq[sample, j]) for a, m in lines]
        assert any((use.lower, use.upper) == pytest.approx(side) for side in sides)


def test_moving_limits_are_drawn_as_lines_over_time(result):
    axes = trajectory_figure(result, "lift").axes[0]
    moving = [line for line in axes.lines if line.get_linewidth() < 1 and np.ptp(line.get_ydata()) > 0]
    assert moving
    straight = [line for line in axes.lines if line.get_linewidth() < 1 and np.ptp(line.get_ydata()) == 0]
    assert len(moving) + len(straight) == 6
    (plot, other) = torque_plots(result)
    limits = [trace for trace in plot.data if trace["line"].get("width") == 0.8]
    assert len(limits) == 6
    assert sum(len(trace["x"]) > 2 for trace in limits) == len(moving)
    assert all(len(trace["x"]) == 2 for trace in other.data if trace["line"].get("width") == 0.8)


def test_tables_and_lines_name_the_curve_once(result):
    assert "left/shoulder torque-speed" in margins_table(result)
    assert "left/elbow motor speed" in margins_table(result)
    lines = list(scaling_lines(result))
    said = [line for line in lines if line.startswith("torque-speed curves: at most")]
    worst = max(use.share for use in limit_uses(result) if use.name.kind == TORQUE_SPEED)
    assert len(said) == 1
    assert f"{100 * worst:.3g} %" in said[0]
    assert not [line for line in lines if "torque-speed " in line and "[" in line]


def test_a_player_has_bars_of_the_torque_at_its_speed(cell, lift):
    state = PlayerState(cell, lift)
    state.sample = 30
    done = state.trajectory
    bars = state.further_bars()
    assert set(bars) == {TORQUE_SPEED, "motor speed"}
    for bar in bars[TORQUE_SPEED]["left"]:
        j = ["shoulder", "elbow"].index(bar.name)
        assert bar.value == pytest.approx(done.torque[30, j])
        assert not bar.over
    driving = [bar for bar in bars[TORQUE_SPEED]["left"] if bar.value * done.dq[30, int(bar.name == "elbow")] > 0]
    for bar in driving:
        assert abs(bar.limit) >= largest(done.dq[30, int(bar.name == "elbow")]) - 1e-9
    assert driving
    assert "left/shoulder" in bars_html(TORQUE_SPEED, bars[TORQUE_SPEED])
    state.choose_speed(state.speeds.upper)  # beyond: some bar is over its limit, and all is still drawn
    assert not state.admissible
    assert bars_html(TORQUE_SPEED, state.further_bars()[TORQUE_SPEED])
