"""The plots along time as the page is sent them, and the viewer of saved results without a browser."""

import lxml.html
import numpy as np
import pytest

import mrts
from mrts.cli import main
from mrts.plots.limit_shares import limit_shares
from mrts.plots.plot import Axis, Line, Panel
from mrts.plots.plotly_drawer import MOST_SAMPLES
from mrts.viewer.player_state import PlayerState
from mrts.viewer.plots.time_plots import PHASE, compared_html, names_html, time_panels, uplot_props
from mrts.viewer.server import close_server, open_server
from mrts.viewer.viewer import Viewer

TORQUES = "Joint torques"

SUMMED = 5e-3
"""Of the width or height of a plot: the way is a sum over samples, the timing knows it better."""


def curves_of(props):
    """What the page is sent of each line: abscissae and ordinates without what is beyond its ends, by its name."""
    x, *values = props["data"]
    names = [line["label"] for line in props["series"][1:]]
    return {name: (x[~np.isnan(y)], y[~np.isnan(y)]) for name, y in zip(names, values, strict=True)}


def shares_of(result, title=TORQUES):
    (of,) = (of for of in limit_shares(result.trajectory) if of.title == title)
    return of


@pytest.mark.quick
def test_lines_are_the_shares_of_limits(lifted):
    panels, of = time_panels(lifted), shares_of(lifted)
    assert list(panels) == ["Range of c² of each sample", TORQUES, "Contact wrenches", PHASE]
    drawn = curves_of(uplot_props(panels[TORQUES]))
    names = lxml.html.fromstring(f"<p>{names_html(panels[TORQUES])}</p>").text_content()
    for column in of.ranked[:4]:
        (name,) = (name for name in drawn if name.startswith(f"{of.labels[column]}:"))
        time, share = drawn[name]
        np.testing.assert_allclose(share, 100 * of.share[:, column])
        np.testing.assert_allclose(time, lifted.trajectory.time)
        assert name in names.replace("\xa0", " ")


@pytest.mark.quick
def test_no_peak_is_lost_and_names_are_text():
    x, y = np.linspace(0, 1, 5 * MOST_SAMPLES), np.full(5 * MOST_SAMPLES, 20.0)
    y[1333] = 100.0
    panel = Panel(x=Axis(ends=(0.0, 1.0)), y=Axis(ends=(0.0, 160.0)), items=[Line(x=x, y=y, label="<b>/&")])
    time, drawn = curves_of(uplot_props(panel))["<b>/&"]
    assert len(time) <= MOST_SAMPLES + 2
    assert np.max(drawn) == 100.0
    names = lxml.html.fromstring(f"<p>{names_html(panel)}</p>")
    assert not names.xpath("//b")
    assert "<b>/&" in names.text_content()


@pytest.mark.quick
def test_the_other_is_dashed_on_the_axis_of_the_longer(planar_cell, lift, lifted):
    slow = mrts.scale(planar_cell, lift, 0.5)
    ratio = slow.trajectory.duration / lifted.trajectory.duration
    assert (
        f"{ratio:.3g} × as fast as <slow>" in lxml.html.fromstring(compared_html(lifted, "<slow>", slow)).text_content()
    )
    props = uplot_props(time_panels(lifted)[TORQUES], time_panels(slow)[TORQUES])
    assert props["scales"]["x"]["range"] == (0.0, slow.trajectory.duration)
    assert [line["label"] for line in props["series"] if "dash" in line] == ["the other"]
    lines = curves_of(props)
    time, share = lines.pop("the other")
    np.testing.assert_allclose(share, np.interp(time, slow.trajectory.time, 100 * shares_of(slow).largest))
    assert time[-1] == slow.trajectory.duration
    assert all(time[-1] == lifted.trajectory.duration for name, (time, _) in lines.items() if name)


def test_a_saved_timing_has_its_phase_plane(planar_cell, lift, tmp_path):
    """The independent side is the profile that was found, along the arc length that the timing itself counts."""
    found = mrts.retime(planar_cell, lift)
    mrts.save_result(found.retimed, tmp_path / "timed.npz")
    panel = time_panels(mrts.load_result(tmp_path / "timed.npz"))[PHASE]
    ((along, height),) = curves_of(uplot_props(panel)).values()
    (piece,) = found.pieces
    np.testing.assert_allclose(along / along[-1], piece.piece.arc / piece.piece.arc[-1], atol=SUMMED)
    np.testing.assert_allclose(height / np.max(height), piece.arc_speed / np.max(piece.arc_speed), atol=SUMMED)


def test_what_some_load_admits_has_no_motion_to_play(planar_cell, tmp_path, capsys):
    start, end = ({"xyz": [1.25, y, 0.0]} for y in (1.0, 1.5))
    description = mrts.MotionDescription(start=start, end=end, duration=0.6, samples=11, profile="quintic")
    motion = mrts.sample_motion(description)
    found = mrts.scale(planar_cell.with_variation(mass=(0.5, 2.0)), motion, load="possible")
    mrts.save_result(found, tmp_path / "possible.npz")
    assert found.status.admits_motion
    assert main(["view", str(tmp_path / "possible.npz"), "--no-open"]) == 2
    assert "chooses no c² and no torques" in capsys.readouterr().err


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
        (line,) = time_panels(fast)[PHASE].items
        way = line.x
        style = viewer.parts[0].cursor.content
        assert f"--mrts-cursor: {state.time / longest:.4f}" in style
        assert f"--mrts-along: {way[state.sample] / way[-1]:.4f}" in style
        other = viewer.parts[1]
        sample = int(np.argmin(np.abs(slow.trajectory.time - state.time)))
        place = slow.motion.object.position[sample]
        np.testing.assert_allclose(other.body.position, place, atol=1e-6)
        np.testing.assert_allclose(other.frame.position, other.offset, atol=1e-6)
        controls["stands"].value = "over it"
        viewer.step(0.0)
        np.testing.assert_allclose(other.frame.position, 0.0)
        controls["stands"].value = "hidden"
        viewer.step(0.0)
        assert not other.frame.visible
    finally:
        close_server(server)
    assert said == []
