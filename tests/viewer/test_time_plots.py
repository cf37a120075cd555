"""The plots along time, read back from their SVG, and the viewer of saved results without a browser."""

from dataclasses import replace

import lxml.html
import numpy as np
import pytest

import mrts
from mrts.plots.limit_plots import LimitShares, limit_shares
from mrts.viewer.plots.saved_state import SavedState
from mrts.viewer.plots.time_plots import (
    BOTTOM,
    HEIGHT,
    LEFT,
    MOST_POINTS,
    RIGHT,
    ROOM,
    TOP,
    WIDTH,
    PlottedMotion,
    cursor_html,
    plots_html,
)  # fmt: skip
from mrts.viewer.saved_viewer import SavedViewer
from mrts.viewer.server import close_server, open_server

SUMMED = 5e-3
"""Of the width or height of a plot: the way is a sum over samples, the timing knows it better."""

DRAWN = 0.1 / (HEIGHT - TOP - BOTTOM)
"""A coordinate is written with one decimal."""


def plotted(name, result):
    return PlottedMotion.of(name, result.trajectory, result.range)


def lines_of(page, kind):
    """Times and shares of the lines of a plot whose upper edge is that of limits that are kept, by what they say."""
    (plot,) = page.xpath(f"//div[@data-plot='{kind}']")
    found = {}
    for line in plot.xpath(".//polyline"):
        x, y = np.array([pair.split(",") for pair in line.get("points").split()], dtype=float).T
        share = (HEIGHT - BOTTOM - y) / (HEIGHT - BOTTOM - TOP) * ROOM
        found[line.findtext("title")] = (x - LEFT) / (WIDTH - LEFT - RIGHT), share
    return found


@pytest.mark.quick
def test_lines_are_the_shares_of_limits(lifted):
    motion = plotted("lift", lifted)
    page = lxml.html.fromstring(f"<div>{plots_html(motion)}</div>")
    assert [plot.get("data-plot") for plot in page.xpath("//div[@data-plot]")] == ["c2", "torque", "wrench", "phase"]
    (of,) = (of for of in motion.shares if of.kind == "torque")
    drawn = lines_of(page, "torque")
    assert len(drawn) == len(of.labels)
    for column, label in enumerate(of.labels):
        ((time, share),) = (line for title, line in drawn.items() if title.startswith(f"{label}:"))
        np.testing.assert_allclose(share, of.share[:, column], atol=2 * DRAWN)
        np.testing.assert_allclose(time, motion.time / motion.duration, atol=1e-3)
    named = page.xpath("//div[@data-plot='torque']/div[@class='names']")[0].text_content()
    assert of.labels[of.ranked[0]] in named
    assert page.xpath("//text[starts-with(., '100 %')]")


@pytest.mark.quick
def test_no_peak_is_lost_and_names_are_text(planar_cell, lift):
    count = 5 * MOST_POINTS + 3
    start, end = ({"xyz": lift.position[at].tolist()} for at in (0, -1))
    description = mrts.MotionDescription(start=start, end=end, duration=0.6, samples=count, profile="quintic")
    dense = mrts.scale(planar_cell, mrts.sample_motion(description), between=None)
    share = np.full((count, 1), 0.2)
    share[3333 % count] = 1.0
    found = replace(plotted("", dense), shares=[LimitShares("torque", ("<b>/&",), share)])
    page = lxml.html.fromstring(f"<div>{plots_html(found)}</div>")
    ((_, drawn),) = lines_of(page, "torque").values()
    assert len(drawn) <= MOST_POINTS
    assert np.max(drawn) == pytest.approx(1, abs=2 * DRAWN)
    assert not page.xpath("//b")
    assert "<b>/&" in page.text_content()


@pytest.mark.quick
def test_the_other_is_dashed_on_the_axis_of_the_longer(planar_cell, lift, lifted):
    slow = mrts.scale(planar_cell, lift, 0.5)
    page = lxml.html.fromstring(f"<div>{plots_html(plotted('fast', lifted), plotted('<slow>', slow))}</div>")
    said = page.xpath("//div[@data-plot='compared']")[0].text_content()
    ratio = slow.trajectory.duration / lifted.trajectory.duration
    assert f"{ratio:.3g} × as fast as <slow>" in said
    lines = lines_of(page, "torque")
    time, share = lines["<slow>: largest"]
    assert time[-1] == pytest.approx(1, abs=1e-3)
    (of,) = (of for of in limit_shares(slow.trajectory) if of.kind == "torque")
    np.testing.assert_allclose(share, of.largest, atol=2 * DRAWN)
    others = [time for title, (time, _) in lines.items() if "<slow>" not in title]
    assert all(time[-1] == pytest.approx(1 / ratio, abs=1e-3) for time in others)


def test_a_saved_timing_has_its_phase_plane(planar_cell, lift, tmp_path):
    """The independent side is the profile that was found, along the arc length that the timing itself counts."""
    found = mrts.retime(planar_cell, lift)
    mrts.save_result(found.retimed, tmp_path / "timed.npz")
    page = lxml.html.fromstring(f"<div>{plots_html(plotted('', mrts.load_result(tmp_path / 'timed.npz')))}</div>")
    ((along, height),) = lines_of(page, "phase").values()
    (piece,) = found.pieces
    np.testing.assert_allclose(along, piece.piece.arc / piece.piece.arc[-1], atol=SUMMED)
    np.testing.assert_allclose(height, piece.arc_speed / np.max(piece.arc_speed), atol=SUMMED)


def test_a_saved_result_plays_without_a_compiler_beside_another(lifted, planar_cell, lift, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    mrts.save_result(lifted, tmp_path / "fast.npz")
    mrts.save_result(mrts.scale(planar_cell, lift, 0.5), tmp_path / "slow.npz")
    fast, slow = (mrts.load_result(tmp_path / name) for name in ("fast.npz", "slow.npz"))
    state = SavedState(fast)
    assert state.admissible
    with pytest.raises(mrts.InputError, match="played as it was saved"):
        state.choose_speed(1.0)
    said = []
    server = open_server("127.0.0.1", 0, "test")
    try:
        viewer = SavedViewer(server, state, said.append, [("slow", slow)])
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
        assert viewer.parts[0].cursor.content == cursor_html(state.time / longest, way[state.sample] / way[-1])
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
