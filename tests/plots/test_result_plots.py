"""Plots of a result or an identification: they hold its numbers, both drawers draw them, nothing hides anything."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from gantries import along_x, gantries
from legible_figures import check_legible, lines_of
from motor_recordings import exact_recording, random_motors, recording
from random_motors import with_all_rates
from shown_results import KINDS, result_of

import mrts
from mrts.plots import (
    matplotlib_figure,
    motor_plot,
    phase_plane_plot,
    power_plot,
    range_plot,
    result_plots,
    trajectory_plot,
    write_plots,
)
from mrts.plots.plot import Axis, Band, Line, Panel, Plot, Points, level, rectangles
from mrts.plots.plotly_drawer import plotly_figure


def of_panel(panel, kind):
    """Items of a panel of one kind, by label."""
    return {item.label: item for item in panel.items if isinstance(item, kind)}


OFTEN = ("planar", "infeasible", "empty", "unbounded", "four arms", "awkward names")
"""Kinds of results that are drawn in `make test`: those with the most lines, the longest names, and nothing."""


@pytest.mark.parametrize(
    "kind", [kind if kind in OFTEN else pytest.param(kind, marks=pytest.mark.slow) for kind in KINDS]
)
def test_every_kind_of_result_has_legible_figures(kind, planar_cell, dual_ur5, lift, tmp_path):
    found = result_of(kind, planar_cell, dual_ur5, lift, tmp_path)
    write_plots(result_plots(found), tmp_path / "out")
    names = {path.stem for path in (tmp_path / "out").iterdir()}
    expected = set() if found.origin else {"c2_range"}
    if found.trajectory is not None:
        expected |= {"torques_and_wrenches", "limits", "power_and_energy"}
    assert names == expected
    for plot in result_plots(found):
        check_legible(matplotlib_figure(plot))


@pytest.mark.quick
def test_curves_are_the_numbers_of_the_result(lifted):
    done, (torques, forces, moments) = lifted.trajectory, trajectory_plot(lifted).rows
    powers, (energy,) = power_plot(lifted).rows
    torque, force, moment, power = (of_panel(row[1], Line) for row in (torques, forces, moments, powers))
    for index, joint in enumerate(("shoulder", "elbow", "wrist")):
        np.testing.assert_array_equal(torque[joint].x, done.time)
        np.testing.assert_array_equal(torque[joint].y, lifted.torque["right"][:, index])
        np.testing.assert_array_equal(power[joint].y, done.power[:, 3 + index])
    np.testing.assert_array_equal(force["fy"].y, lifted.wrench["right"][:, 1])
    np.testing.assert_array_equal(moment["nz"].y, lifted.wrench["right"][:, 2])
    assert [np.unique([line.lower, line.upper]).tolist() for line in torque.values()] == [
        [-100, 100],
        [-80, 80],
        [-50, 50],
    ]
    assert force["fy"].limits == []
    assert np.unique(force["fx"].limits).tolist() == [-2, 2]
    assert of_panel(energy, Line)[f"all: {done.energy:.4g} J"].y[-1] == pytest.approx(done.energy)
    assert [row[1].y.label for row in (torques, forces, moments, powers)] == [
        "joint torque [N m]", "contact force [N]", "contact moment [N m]", "power [W]"
    ]  # fmt: skip


def test_joints_that_slide_and_that_turn_have_an_axis_each(tmp_path):
    plot = trajectory_plot(mrts.scale(gantries(tmp_path), along_x(11)))
    drawn = {row[0].y.label: [*of_panel(row[0], Line)] for row in plot.rows}
    assert drawn == {
        "joint force [N]": ["slide_x", "slide_y"], "joint torque [N m]": ["turn"],
        "contact force [N]": ["fx", "fy"], "contact moment [N m]": ["nz"],
    }  # fmt: skip


@pytest.mark.quick
def test_both_drawers_draw_the_numbers_of_a_plot():
    x, y = np.array([0.0, 1.0, 2.0]), np.array([1.0, np.nan, 3.0])
    line = Line(
        x=x, y=y, label="a $ <b>", unit="N", lower=np.full(3, -5.0), upper=np.array([4.0, 5.0, 6.0]), steps=True
    )
    time = Axis(label="time", ends=(0.0, 2.0))
    items = [line, Band(x=x, lower=0 * x, upper=x, label="band"), level(2.0, time, label="rule"),
             rectangles([(0.5, 1.0)], -6.0, 2.0, label="span"),
             Points(x=x[:1], y=x[:1], texts=["here"], label="mark")]  # fmt: skip
    bars = rectangles([(0.0, 3.0), (-4.0, 0.0)], np.array([-0.3, 0.7]), np.array([0.3, 1.3]), label="bars")
    above = Axis(label="force", ends=(-6.0, 2.0))
    below = Axis(names=["one", "two"], colors=["#000", "#000"], strong=[True, False], ends=(1.6, -0.6))
    panels = [Panel(x=time, y=above, items=items), Panel(x=time, y=below, items=[bars])]
    plot = Plot(name="p", title="t", rows=[[panel] for panel in panels], shared=True, clock="played")
    above, below = matplotlib_figure(plot).axes
    drawn = lines_of(above)["a $ <b>".replace("$", r"\$")]
    np.testing.assert_array_equal(drawn.get_ydata(), y)
    assert drawn.get_drawstyle() == "steps-post"
    thin = [line for line in above.lines if line.get_linewidth() < 1]
    assert [sorted({*line.get_ydata()}) for line in thin] == [[-5.0], [4.0, 5.0, 6.0]]
    assert [path.get_extents().bounds for path in below.collections[0].get_paths()] == [
        pytest.approx((0.0, -0.3, 3.0, 0.6)), pytest.approx((-4.0, 0.7, 4.0, 0.6))
    ]  # fmt: skip
    assert [label.get_text() for label in below.get_yticklabels()] == ["one", "two"]
    page = plotly_figure(plot)
    traces = {trace["name"]: trace for trace in page["data"] if trace.get("name")}
    assert set(traces) == {"a &#36; &lt;b&gt;", "band", "rule", "span", "mark", "bars"}
    assert traces["a &#36; &lt;b&gt;"]["y"] == [1.0, None, 3.0]
    assert traces["bars"]["x"] == [0.0, 3.0, 3.0, 0.0, None, -4.0, 0.0, 0.0, -4.0]
    assert traces["bars"]["y"] == [-0.3, -0.3, 0.3, 0.3, None, 0.7, 0.7, 1.3, 1.3]
    assert traces["bars"]["yaxis"] == "y2"
    assert [re.sub("<.?span.*?>", "", name) for name in page["layout"]["yaxis2"]["ticktext"]] == ["<b>one</b>", "two"]
    assert page["clock"] == "played"
    json.dumps(page, allow_nan=False)


def test_the_range_is_drawn_with_the_point_that_sets_it(planar_cell, lift, lifted):
    (above,), (below,) = range_plot(lifted).rows
    np.testing.assert_array_equal(of_panel(above, Line)["c²⁺(t)"].y, lifted.range.samples.upper)
    end = lifted.range.upper
    (mark,) = (item for item in above.items if isinstance(item, Points))
    assert (mark.x.tolist(), mark.y.tolist(), mark.texts) == ([end.time], [end.c2], ["c²⁺ = 3.062"])
    assert above.y.ends[0] < 0 < end.c2 < above.y.ends[1]
    assert below.y.names[:2] == ["left/elbow ↑", "right/elbow ↓"]
    (bars,) = (item for item in below.items if isinstance(item, Band))
    start, end, _ = bars.x[np.abs((bars.lower + bars.upper) / 2 - 1) < 0.1][:3]  # right/elbow: from the start on
    assert start == 0
    assert end == pytest.approx(0.144, abs=0.003)
    torn = range_plot(mrts.scale(planar_cell.with_mass(24.0), lift)).rows[0][0]
    assert "no c² at all" in of_panel(torn, Band)
    assert "worst conflict" in of_panel(torn, Line)


def test_figures_are_written_in_the_format_that_is_asked_for(planar_cell, lift, tmp_path):
    """An infeasible timing has figures as well: those of the best constant factor."""
    infeasible = mrts.retime(planar_cell.with_mass(60.0), lift)
    for form, start in (("svg", b"<?xml"), ("pdf", b"%PDF")):
        for folder in ("once", "again"):
            write_plots(result_plots(infeasible), tmp_path / folder, form)
        texts = {(tmp_path / folder / f"c2_range.{form}").read_bytes() for folder in ("once", "again")}
        assert len(texts) == 1  # no date, no identifiers of chance
        assert texts.pop().startswith(start)
    assert {path.name for path in (tmp_path / "once").iterdir()} == {"c2_range.svg", "c2_range.pdf"}
    with pytest.raises(mrts.InputError, match="one of png, svg, pdf"):
        write_plots([], tmp_path / "once", "gif")


@pytest.fixture(scope="module")
def found(planar_cell):
    """A joint that stands still, and efforts with an offset."""
    joints, time, q, effort = exact_recording(planar_cell, random_motors(6), rate=200, still=(1,))
    return mrts.identify(planar_cell, recording(Path("recorded.csv"), joints, time, q, effort + 2.0))


@pytest.mark.quick
def test_friction_and_residual_are_those_of_the_result(found):
    arm = found.arms[0]
    rows = motor_plot(arm).rows
    assert [len(row) for row in rows] == [3, 3, 3]
    dots, line = rows[0][1].items
    coulomb, viscous = arm.value["coulomb"][0], arm.value["viscous"][0]
    np.testing.assert_allclose(line.y, np.array([-1, -1, 1, 1]) * coulomb + viscous * line.x)
    assert len(dots.x) == np.count_nonzero(arm.motion.used[:, 0])
    np.testing.assert_allclose(dots.y, coulomb * np.sign(dots.x) + viscous * dots.x, atol=0.01)
    (residual,) = rows[0][2].items
    np.testing.assert_allclose(np.sqrt(np.mean(residual.y**2)), arm.residual_rms[0])


SAME_ARC = 1e-9
"""Arc lengths are sums over other samples of one path."""

INNER = slice(5, -5)
STRAIGHT = 0.01
"""Speed is taken as a straight line along the path, which it is not near the ends at rest: there s ~ t³."""


def line_with(plot, beginning):
    """The curve whose label begins so."""
    (line,) = (line for label, line in of_panel(plot.rows[0][0], Line).items() if label.startswith(beginning))
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


def test_all_figures_of_smooth_timing_are_legible(smooth):
    found, plots = smooth, result_plots(smooth)
    assert [plot.name for plot in plots] == ["phase_plane", "torques_and_wrenches", "limits", "power_and_energy"]
    assert f"{found.duration:.4g} s (given" in plots[1].title
    rates = [panel for row in plots[2].rows for panel in row][-3:]
    assert [panel.title for panel in rates] == ["Rates of joint torques", "Rates of contact wrenches", "Joint jerks"]
    named = [item for panel in rates for item in panel.items if isinstance(item, Line) and item.label]
    assert all(line.steps and np.max(line.y) <= 100 * (1 + 1e-6) for line in named)
    for plot in plots:
        check_legible(matplotlib_figure(plot))
