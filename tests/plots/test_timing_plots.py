"""Figures of smooth timing: the three profiles side by side, rates as per cents of their limits."""

import numpy as np
import pytest
from legible_figures import check_legible
from shown_results import with_all_rates

import mrts
from mrts.plots import limits_plot, matplotlib_figure, phase_plane_plot
from mrts.plots.figure_files import result_plots
from mrts.plots.plot import Line

SAME_ARC = 1e-9
"""Arc lengths are sums over other samples of one path."""

INNER = slice(5, -5)
STRAIGHT = 0.01
"""Speed is taken as a straight line along the path, which it is not near the ends at rest: there s ~ t³."""


@pytest.fixture(scope="module")
def smooth(planar_cell, lift):
    return mrts.retime(with_all_rates(planar_cell), lift, rates=11.0)


def lines_of(plot, title=""):
    """Curves with a label of a plot, or of its panel with a title."""
    panels = [panel for row in plot.rows for panel in row if title in panel.title]
    return {item.label: item for panel in panels for item in panel.items if isinstance(item, Line) and item.label}


def line_with(plot, beginning, title=""):
    """The curve whose label begins so."""
    (line,) = (line for label, line in lines_of(plot, title).items() if label.startswith(beginning))
    return line


def test_the_phase_plane_has_all_three_profiles_with_their_durations(smooth, planar_cell, lift):
    fastest = mrts.retime(planar_cell, lift)
    plane = phase_plane_plot(smooth)
    bare = line_with(plane, f"fastest without limits of rates, {fastest.duration:.4g} s")
    played = line_with(plane, f"smooth timing, {smooth.duration:.4g} s")
    kept = mrts.scale(with_all_rates(planar_cell), lift, rates=11.0)
    constant = line_with(plane, f"best constant c, {kept.trajectory.duration:.4g} s")
    np.testing.assert_array_equal(bare.y, np.sqrt(fastest.pieces[0].x))
    ends = [line.x[-1] for line in (bare, played, constant)]
    np.testing.assert_allclose(ends, ends[0], rtol=SAME_ARC)
    s, speed = (played.x, played.y)
    times = 2 * np.diff(s) / (speed[1:] + speed[:-1])
    np.testing.assert_allclose(times[INNER], np.diff(smooth.retimed.trajectory.time)[INNER], rtol=STRAIGHT)
    way, limit = (bare.x, bare.y)
    inside = np.sqrt(np.interp(s, way, limit**2))  # exact: its s̈ is constant from sample to sample
    assert np.all(speed <= inside * 1.01 + 1e-9), "no timing is faster anywhere than the fastest"
    assert line_with(phase_plane_plot(fastest), "best constant c, ").y.size


def test_rates_are_those_of_straight_lines_between_nodes_as_shares_of_their_limits(smooth):
    result, done = smooth.retimed, smooth.retimed.trajectory
    plot = limits_plot(result, "")
    titles = [panel.title for row in plot.rows for panel in row]
    assert titles[-3:] == ["Rates of joint torques", "Rates of contact wrenches", "Joint jerks"]
    for joint, limit in (("shoulder", 1100), ("elbow", 880), ("wrist", 550)):
        index = [robot.joints for robot in result.cell.robots][1].index(joint)
        for line in (
            line for label, line in lines_of(plot, "Rates of joint").items() if label.startswith(f"right/{joint}")
        ):
            assert line.steps
            rates = np.abs(np.diff(result.torque["right"][:, index]) / np.diff(done.time))
            np.testing.assert_allclose(line.y[:-1], 100 * rates / limit)
    for title in titles[-3:]:
        assert max(np.max(line.y) for line in lines_of(plot, title).values()) <= 100 * (1 + 1e-6)


def test_all_figures_of_smooth_timing_are_legible(smooth):
    found, plots = smooth, result_plots(smooth)
    assert [plot.name for plot in plots] == ["phase-plane", "torques_and_wrenches", "limits", "power_and_energy"]
    assert f"{found.duration:.4g} s (given" in plots[1].title
    for plot in plots:
        check_legible(matplotlib_figure(plot))
