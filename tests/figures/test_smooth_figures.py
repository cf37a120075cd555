"""Figures of smooth timing: the three profiles side by side, torques over their rates with the limits of both."""

import numpy as np
import pytest
from conftest import DATA
from legible_figures import check_legible, lines_of
from matplotlib.figure import Figure
from shown_results import with_all_rates

import mrts
from mrts.figures import (
    draw_force_rates,
    draw_jerks,
    draw_moment_rates,
    draw_phase_plane,
    draw_torque_rates,
    phase_plane_figure,
    rates_figure,
    write_result_figures,
)

SAME_ARC = 1e-9
"""Arc lengths are sums over other samples of one path."""

INNER = slice(5, -5)
STRAIGHT = 0.01
"""Speed is taken as a straight line along the path, which it is not near the ends at rest: there s ~ t³."""


@pytest.fixture(scope="module")
def smooth(planar_cell, lift):
    return mrts.retime(with_all_rates(planar_cell), lift, rates=11.0)


@pytest.fixture(scope="module")
def spatial(dual_ur5):
    motion = mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml")
    return mrts.retime(dual_ur5, motion, rates=11.0, between=None)


def label_with(axes, beginning):
    """The curve whose label begins so."""
    (line,) = (line for label, line in lines_of(axes).items() if label.startswith(beginning))
    return line


def test_the_phase_plane_has_all_three_profiles_with_their_durations(smooth, planar_cell, lift):
    fastest = mrts.retime(planar_cell, lift)
    axes = Figure().subplots()
    draw_phase_plane(axes, smooth)
    bare = label_with(axes, f"fastest without limits of rates, {fastest.duration:.4g} s")
    played = label_with(axes, f"smooth timing, {smooth.duration:.4g} s")
    kept = mrts.scale(with_all_rates(planar_cell), lift, rates=11.0)
    constant = label_with(axes, f"best constant c, {kept.trajectory.duration:.4g} s")
    np.testing.assert_array_equal(bare.get_ydata(), np.sqrt(fastest.pieces[0].x))
    ends = [line.get_xdata()[-1] for line in (bare, played, constant)]
    np.testing.assert_allclose(ends, ends[0], rtol=SAME_ARC)
    s, speed = played.get_xydata().T
    times = 2 * np.diff(s) / (speed[1:] + speed[:-1])
    np.testing.assert_allclose(times[INNER], np.diff(smooth.retimed.trajectory.time)[INNER], rtol=STRAIGHT)
    way, limit = bare.get_xydata().T
    inside = np.sqrt(np.interp(s, way, limit**2))  # exact: its s̈ is constant from sample to sample
    assert np.all(speed <= inside * 1.01 + 1e-9), "no timing is faster anywhere than the fastest"
    own = Figure().subplots()
    draw_phase_plane(own, fastest)
    assert any(label.startswith("best constant c, ") for label in lines_of(own))


def test_torque_rates_are_those_of_straight_lines_between_nodes(smooth):
    result, done = smooth.retimed, smooth.retimed.trajectory
    axes = Figure().subplots()
    draw_torque_rates(axes, result, "right")
    for index, joint in enumerate(("shoulder", "elbow", "wrist")):
        line = lines_of(axes)[joint]
        assert line.get_drawstyle() == "steps-post"
        rates = np.diff(result.torque["right"][:, index]) / np.diff(done.time)
        np.testing.assert_array_equal(line.get_ydata()[:-1], rates)
    levels = sorted({line.get_ydata()[0] for line in axes.lines if len(line.get_ydata()) == 2})
    assert levels == [-1100, -880, -550, 550, 880, 1100]
    assert "[N m/s]" in axes.get_ylabel()


def test_wrench_rates_and_jerks_have_their_limits(smooth):
    force, moment, jerk = drawn = Figure().subplots(3)
    for axes, draw in zip(drawn, (draw_force_rates, draw_moment_rates, draw_jerks), strict=True):
        draw(axes, smooth.retimed, "left")
    assert [list(lines_of(axes)) for axes in drawn] == [["fx", "fy"], ["nz"], ["shoulder", "elbow", "wrist"]]
    assert [axes.get_ylabel().split("[")[1] for axes in drawn] == ["N/s]", "N m/s]", "rad/s³]"]
    for axes, limit in ((force, 20), (moment, 20), (jerk, 2000)):
        assert {line.get_ydata()[0] for line in axes.lines if len(line.get_ydata()) == 2} == {-limit, limit}
        values = np.concatenate([line.get_ydata() for line in lines_of(axes).values()])
        assert np.max(np.abs(values)) <= limit * (1 + 1e-6)


def test_all_figures_of_smooth_timing_are_legible(smooth, spatial, tmp_path):
    for number, found in enumerate((smooth, spatial)):
        write_result_figures(found, tmp_path / str(number))
        assert (tmp_path / str(number) / "rates.png").exists()
        title = f"{found.cell.name}: {found.retimed.origin.split('. ')[0]}"
        assert "smooth timing of a path that was given" in title
        check_legible(phase_plane_figure(found))
        check_legible(rates_figure(found.retimed, title))


def test_a_cell_without_limited_rates_has_no_figure_of_them(lifted, tmp_path):
    write_result_figures(lifted, tmp_path)
    assert not (tmp_path / "rates.png").exists()


@pytest.mark.quick
def test_rates_of_nothing_cannot_be_drawn(planar_cell, lift):
    infeasible, axes = mrts.scale(planar_cell.with_mass(60.0), lift), Figure().subplots()
    for draw in (draw_torque_rates, draw_force_rates, draw_moment_rates, draw_jerks):
        with pytest.raises(ValueError, match="no trajectory"):
            draw(axes, infeasible, "left")
