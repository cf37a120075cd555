"""The plots along time, read back from their SVG, and the viewer of saved results without a browser."""

from dataclasses import replace

import lxml.html
import numpy as np
import pytest

import mrts
from mrts.plots.limit_shares import LimitShares, limit_shares
from mrts.viewer.player_state import PlayerState
from mrts.viewer.plots.time_plots import MOST_POINTS, PlottedMotion, compared_html, time_plots
from mrts.viewer.server import close_server, open_server
from mrts.viewer.viewer import Viewer

SUMMED = 5e-3
"""Of the width or height of a plot: the way is a sum over samples, the timing knows it better."""


def plotted(name, result):
    return PlottedMotion.of(name, result.trajectory, result.range)


def plot_of(kind, *motions):
    (plot,) = (plot for plot in time_plots(*motions) if plot.kind == kind)
    return plot


def curves_of(plot):
    """What the page is sent of each line: abscissae and ordinates without what is beyond its ends, by its name."""
    x, *values = plot.data
    names = [line["label"] for line in plot.props["series"][1:]]
    return {name: (x[~np.isnan(y)], y[~np.isnan(y)]) for name, y in zip(names, values, strict=True)}


@pytest.mark.quick
def test_lines_are_the_shares_of_limits(lifted):
    motion = plotted("lift", lifted)
    assert [plot.kind for plot in time_plots(motion)] == ["c2", "torque", "wrench", "phase"]
    (of,) = (of for of in motion.shares if of.kind == "torque")
    plot = plot_of("torque", motion)
    drawn = curves_of(plot)
    assert drawn.keys() == {*of.labels, "limit"}
    for column, label in enumerate(of.labels):
        time, share = drawn[label]
        np.testing.assert_allclose(share, 100 * of.share[:, column])
        np.testing.assert_allclose(time, motion.time)
    assert of.labels[of.ranked[0]] in lxml.html.fromstring(f"<p>{plot.names}</p>").text_content()
    np.testing.assert_array_equal(drawn["limit"][1], 100.0)


@pytest.mark.quick
def test_no_peak_is_lost_and_names_are_text(planar_cell, lift):
    count = 5 * MOST_POINTS + 3
    start, end = ({"xyz": lift.position[at].tolist()} for at in (0, -1))
    description = mrts.MotionDescription(start=start, end=end, duration=0.6, samples=count, profile="quintic")
    dense = mrts.scale(planar_cell, mrts.sample_motion(description), between=None)
    share = np.full((count, 1), 0.2)
    share[3333 % count] = 1.0
    plot = plot_of("torque", replace(plotted("", dense), shares=[LimitShares("torque", ("<b>/&",), share)]))
    time, drawn = curves_of(plot)["<b>/&"]
    assert len(time) <= MOST_POINTS + 2
    assert np.max(drawn) == 100.0
    names = lxml.html.fromstring(f"<p>{plot.names}</p>")
    assert not names.xpath("//b")
    assert "<b>/&" in names.text_content()


@pytest.mark.quick
def test_the_other_is_dashed_on_the_axis_of_the_longer(planar_cell, lift, lifted):
    slow = mrts.scale(planar_cell, lift, 0.5)
    both = plotted("fast", lifted), plotted("<slow>", slow)
    said = lxml.html.fromstring(compared_html(*both)).text_content()
    ratio = slow.trajectory.duration / lifted.trajectory.duration
    assert f"{ratio:.3g} × as fast as <slow>" in said
    plot = plot_of("torque", *both)
    assert plot.reach[0] == slow.trajectory.duration
    assert [line["label"] for line in plot.props["series"] if "dash" in line] == ["<slow>"]
    lines = curves_of(plot)
    (of,) = (of for of in limit_shares(slow.trajectory) if of.kind == "torque")
    time, share = lines.pop("<slow>")
    np.testing.assert_allclose(share, np.interp(time, slow.trajectory.time, 100 * of.largest))
    assert time[-1] == slow.trajectory.duration
    del lines["limit"]
    assert all(time[-1] == lifted.trajectory.duration for time, _ in lines.values())


def test_a_saved_timing_has_its_phase_plane(planar_cell, lift, tmp_path):
    """The independent side is the profile that was found, along the arc length that the timing itself counts."""
    found = mrts.retime(planar_cell, lift)
    mrts.save_result(found.retimed, tmp_path / "timed.npz")
    ((along, height),) = curves_of(plot_of("phase", plotted("", mrts.load_result(tmp_path / "timed.npz")))).values()
    (piece,) = found.pieces
    np.testing.assert_allclose(along / along[-1], piece.piece.arc / piece.piece.arc[-1], atol=SUMMED)
    np.testing.assert_allclose(height / np.max(height), piece.arc_speed / np.max(piece.arc_speed), atol=SUMMED)


def test_a_saved_result_plays_without_a_compiler_beside_another(lifted, planar_cell, lift, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    mrts.save_result(lifted, tmp_path / "fast.npz")
    mrts.save_result(mrts.scale(planar_cell, lift, 0.5), tmp_path / "slow.npz")
    fast, slow = (mrts.load_result(tmp_path / name) for name in ("fast.npz", "slow.npz"))
    state = PlayerState.saved(fast)
    assert state.admissible
    with pytest.raises(mrts.InputError, match="played as it was saved"):
        state.choose_speed(1.0)
    said = []
    server = open_server("127.0.0.1", 0, "test")
    try:
        viewer = Viewer(server, state, {}, said.append, [("slow", slow)])
        controls = {getattr(each, "label", ""): each for each in server.controls.values()}
        viewer.playback.toggle()
        viewer.step(1.0)
        before = state.sample
        for _ in range(4):
            viewer.step(0.2)
        assert state.sample > before
        assert controls["Play"].label == "Pause"
        longest = slow.trajectory.duration
        way = plotted("", fast).way
        style = viewer.parts[0].cursor.content
        assert f"--mrts-cursor: {state.time / longest:.4f}" in style
        assert f"--mrts-along: {way[state.sample] / way[-1]:.4f}" in style
        other = viewer.parts[1]
        sample = int(np.argmin(np.abs(slow.trajectory.time - state.time)))
        place = slow.motion.object.position[sample]
        np.testing.assert_allclose(other.body.position, place + other.offset, atol=1e-6)
        controls["stands"].value = "over it"
        viewer.step(0.0)
        np.testing.assert_allclose(other.body.position, slow.motion.object.position[sample], atol=1e-6)
        controls["stands"].value = "hidden"
        viewer.step(0.0)
        assert not other.body.visible
    finally:
        close_server(server)
    assert said == []
