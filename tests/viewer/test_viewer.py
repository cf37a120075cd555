"""The viewer without a browser: its controls are set as a browser's messages set them, its scene is read back."""

import sys
import time
from dataclasses import replace

import lxml.html
import numpy as np
import pytest
import viser
from conftest import DATA, UR5
from scipy.spatial.transform import Rotation
from shipped_cells import shipped
from shown_viewer import PATIENCE, cell_of_real_arms, news_of, planar_given, settle, shown_viewer, spatial_given

import mrts
from mrts.cli import main
from mrts.plots.plot import Axis, Line, Panel
from mrts.plots.plotly_drawer import MOST_SAMPLES
from mrts.plots.trajectory_plots import limit_shares
from mrts.scene.scene import PACES, blended
from mrts.viewer.controls import DECIMALS, assign
from mrts.viewer.player_state import PlayerState
from mrts.viewer.time_plots import names_html, time_panels, uplot_props
from mrts.viewer.viewer import FRAME, Viewer
from mrts.viewer.workbench import Given, Place

BLENDED = 1e-3
"""By how much less a turn between samples is than a rotation: the square of a step, which is at most 0.06 rad here."""

SINGLE = 2e-6
"""Of positions in a scene [m]: single precision of some metres."""

TORQUES = "Joint torques"


@pytest.fixture
def viewer(planar_cell):
    with shown_viewer(planar_given(planar_cell)) as opened:
        yield opened


@pytest.fixture(scope="module")
def spatial(dual_ur5):
    with shown_viewer(spatial_given(dual_ur5)) as opened:
        yield opened


def choose(viewer, **values):
    """Set controls, and wait for the answer."""
    for label, value in values.items():
        assign(viewer.controls[label.replace("_", " ")], value)
    settle(viewer.shown)


def drawn(viewer, name):
    return viewer.server.scene.get_handle_by_name(name)


def test_another_profile_is_played_at_its_own_speed(viewer):
    """A chosen c is a factor of the given motion; of a timing it would be a share."""
    choose(viewer, speed_c=0.5)
    assert viewer.shown.state.trajectory.c == pytest.approx(0.5)
    choose(viewer, profile="optimal")
    assert viewer.shown.state.trajectory.c == 1
    assert viewer.shown.state.admissible
    choose(viewer, speed_c=0.5)
    choose(viewer, profile="constant")
    assert viewer.shown.state.trajectory.c == viewer.shown.state.speeds.start


def test_every_slider_changes_its_number(viewer):
    """Of one number field without decimal places the page drops the point: a typed 1.5 is 15."""
    sliders = {name: each for name, each in viewer.controls.items() if isinstance(each, viser.GuiSliderHandle)}
    assert len(sliders) == 9
    assert all(slider.precision >= DECIMALS for slider in sliders.values())
    choose(viewer, **{"mass [kg]": 1.0})
    for limit, share in (("left: all torques", 87.5), ("right: all wrenches", 50.0)):
        choose(viewer, limit=limit)
        choose(viewer, **{"of that limit [%]": share})
    choices, left = viewer.bench.choices, viewer.bench.given.cell.robots[0]
    assert choices.mass == 1.0
    assert {choices.limits["torque", "left", joint] for joint in left.joints} == {0.875}
    assert {share for (kind, robot, _), share in choices.limits.items() if (kind, robot) == ("wrench", "right")} == {
        0.5
    }
    choose(viewer, limit="left/elbow torque")
    assert viewer.controls["of that limit [%]"].value == 87.5
    choose(viewer, **{"of that limit [%]": 60.0})
    assert viewer.bench.choices.limits["torque", "left", "elbow"] == 0.6
    choose(viewer, move="left base")
    choose(viewer, **{"along x [mm]": 20.0, "about z [°]": 10.0})
    pose, given = viewer.bench.choices.poses(viewer.bench.given)[Place("base", "left")], left.T_world_base
    np.testing.assert_allclose(pose.p - given.p, [0.02, 0, 0], atol=1e-9)
    turn = Rotation.from_matrix(pose.R @ given.R.T).as_rotvec(degrees=True)
    np.testing.assert_allclose(turn, [0, 0, 10], atol=1e-9)
    viewer.shown._changes._reset()  # noqa: SLF001 (as its button does)
    assert [sliders[name].value for name in ("along x [mm]", "of that limit [%]")] == [0, 100]


def test_a_hand_on_the_slider_is_not_pushed_back(viewer, monkeypatch):
    """An answer to where the slider was comes after it has moved on."""
    slider, bench = viewer.controls["speed c"], viewer.bench
    slider.value = 0.5
    viewer.shown.step(0.0)
    slider.value = 0.7
    news = news_of(bench)
    with monkeypatch.context() as just_ready:
        just_ready.setattr(bench, "take", lambda: news)
        viewer.shown.step(0.0)
    assert viewer.shown.state.trajectory.c == pytest.approx(0.5)
    assert slider.value == 0.7
    settle(viewer.shown)
    assert slider.value == 0.7
    assert viewer.shown.state.trajectory.c == pytest.approx(0.7)


def test_what_was_changed_just_before_a_button_is_older_than_it(viewer):
    """Both come between two frames: the change is taken back with the rest."""
    shown, profile = viewer.shown, viewer.controls["profile"]
    assign(profile, "optimal")
    shown._todo.put(shown._changes._reset)  # noqa: SLF001 (as its button does)
    settle(shown)
    assert (viewer.bench.choices.profile, profile.value) == ("constant", "constant")


def test_an_answer_is_outdated_as_soon_as_a_control_changes(viewer):
    shown, bench = viewer.shown, viewer.bench

    def verdict():
        content = shown._verdict.content  # noqa: SLF001 (what the page shows)
        return 'data-text="computing"' in content, 'data-text="error"' in content, "--mrts-answer" in content

    settle(shown)
    assert verdict() == (False, False, False)
    for label, value in (("mass [kg]", 1.0), ("speed c", 0.5)):
        assign(viewer.controls[label], value)
        shown.step(0.0)
        assert verdict() == (True, False, True), label
        settle(shown)
        assert verdict() == (False, False, False), label
    bench.edit(replace(bench.choices, mass=-1.0))
    settle(shown)
    assert verdict() == (False, True, True)  # the last answer stays, of the values before
    bench.edit(replace(bench.choices, mass=None))
    shown.step(0.0)
    assert verdict() == (True, False, True)
    settle(shown)
    assert verdict() == (False, False, False)


def test_it_opens_at_the_moment_that_decides(spatial):
    state, upper = spatial.shown.state, spatial.shown.state.result.range.upper
    assert 0 < upper.sample < len(state.trajectory.time) - 1
    assert spatial.shown.sample == upper.sample
    assert spatial.controls["time [s]"].value == pytest.approx(state.trajectory.time[upper.sample], abs=1e-4)
    assert state.card.deciding.name.element in spatial.controls["limit"].value


def test_a_cell_alone_has_nothing_to_play_and_shows_gaps(planar_cell, monkeypatch, capsys):
    with shown_viewer(Given(planar_cell, None)) as viewer:
        assert not any(viewer.controls[name].visible for name in ("speed c", "time [s]", "Play"))
        viewer.bench.edit(viewer.bench.choices.with_offset(Place("base", "left"), np.array([0.0, -3.0, 0, 0, 0, 0])))
        settle(viewer.shown)
        ((tip, grasp),) = drawn(viewer, "/gaps").points
        held = viewer.bench.answer.shown
        assert np.linalg.norm(grasp - tip) == pytest.approx(held.gap[0, 0], rel=1e-5)
    monkeypatch.setattr(Viewer, "run", lambda _viewer: None)  # Ctrl-C comes at once
    assert main(["view", str(DATA / "cell.yaml"), "--port", "0", "--no-open"]) == 0
    assert "no motion was given, the cell stands at its posture" in capsys.readouterr().out


def test_surroundings_are_drawn_and_the_nearest_pair_is_told(dual_ur5, monkeypatch):
    """Beside a post, and then through a shelf: as `mrts.clearance` says, and when at the speed that is played."""
    given = spatial_given(dual_ur5)
    posts = [{"name": "post", "cylinder": {"radius": 0.05, "length": 1.0}, "pose": {"xyz": [0.0, 0.6, 0.2]}}]
    shelf = {"name": "shelf", "box": [0.6, 0.4, 0.002], "pose": {"xyz": [0.0, 0.2, 0.5]}}
    for surroundings, red in ((posts, False), ([*posts, shelf], True)):
        cell = mrts.Cell.from_description(shipped("dual_ur5") | {"surroundings": surroundings}, folder=UR5)
        near = mrts.clearance(cell, given.motion)
        with shown_viewer(replace(given, cell=cell)) as viewer:
            settle(viewer.shown)
            choose(viewer, speed_c=0.5)
            for number, one in enumerate(surroundings):
                middle = np.mean(drawn(viewer, f"/surroundings/{number}").vertices, axis=0)
                np.testing.assert_allclose(middle, one["pose"]["xyz"], atol=SINGLE)
            c = viewer.shown.state.trajectory.c
            text = viewer.shown._outcome  # noqa: SLF001 (what the page shows)
            assert near.at_speed(c).sentence() in text
            assert ('data-text="collisions" style="color:var(--mrts-over)"' in text) == red
    monkeypatch.setitem(sys.modules, "coal", None)
    with shown_viewer(given) as viewer:
        settle(viewer.shown)
        assert "mrts[collision]" in viewer.shown._outcome  # noqa: SLF001 (likewise)


def turned(handle):
    return Rotation.from_quat(np.roll(handle.wxyz, -1)).as_matrix()


def test_between_samples_hands_stay_at_their_grasps_and_a_pause_is_a_sample(spatial):
    viewer = spatial.shown
    state, course = viewer.state, viewer.state.scene
    for place in (3.25, 50.5, 99.99):
        position, rotation = (blended(each, place) for each in (course.position, course.rotation))
        low, high = int(place), int(place) + 1
        between = course.position[low] + (place - low) * (course.position[high] - course.position[low])
        np.testing.assert_allclose(position, between)
        for robot, (R, _), line in zip(state.result.cell.robots, course.bodies, course.lines, strict=True):
            grasp = position + rotation @ robot.T_object_tip.p
            np.testing.assert_allclose(blended(line, place)[-1], grasp, atol=1e-6)
            np.testing.assert_allclose(np.linalg.det(blended(R, place)), 1, atol=BLENDED)
    viewer.playback.toggle()
    viewer.step(0.4 * FRAME)
    viewer._todo.put(viewer.playback.toggle)  # noqa: SLF001 (as its button does)
    viewer.step(FRAME)
    np.testing.assert_array_equal(drawn(spatial, "/carried").position, course.position[viewer.sample])
    np.testing.assert_allclose(turned(drawn(spatial, "/carried")), course.rotation[viewer.sample], atol=1e-12)
    for robot, (R, p) in zip(state.result.cell.robots, course.bodies, strict=True):
        frame = drawn(spatial, f"/arms/{robot.name}/body{len(robot.joints)}")
        np.testing.assert_allclose(frame.position, p[viewer.sample, -1], atol=SINGLE)
        np.testing.assert_allclose(turned(frame), R[viewer.sample, -1], atol=1e-9)


@pytest.mark.parametrize("spoil", ["gone", "broken", "http"])
def test_an_arm_without_its_meshes_is_drawn_simply(spoil, tmp_path):
    other = {"gone": "package://nowhere/forearm.dae", "broken": "broken.dae", "http": "http://127.0.0.1:9/x.dae"}[spoil]
    (tmp_path / "broken.dae").write_text("<not a mesh")
    path = cell_of_real_arms(tmp_path, other)
    warnings = []
    given = Given(mrts.load_cell(path), mrts.load_motion(UR5 / "lift_and_turn.yaml"))
    with shown_viewer(given, warn=warnings.append) as viewer:
        viewer.shown.step(0.0)
        assert all(drawn(viewer, f"/arms/{name}/body6/mesh1") is not None for name in ("left", "right"))
    assert len(warnings) == 2
    assert all("is drawn with simple shapes" in warning and "arm.urdf" in warning for warning in warnings)
    assert spoil == "broken" or other in warnings[0]


def curves_of(props):
    """What the page is sent of each line: abscissae and ordinates without what is beyond its ends, by its name."""
    x, *values = props["data"]
    names = [line["label"] for line in props["series"][1:]]
    return {name: (x[~np.isnan(y)], y[~np.isnan(y)]) for name, y in zip(names, values, strict=True)}


@pytest.mark.quick
def test_lines_are_the_shares_of_limits(lifted):
    panels = time_panels(lifted)
    (of,) = (of for of in limit_shares(lifted.trajectory) if of.title == TORQUES)
    assert list(panels) == ["Range of c² of each sample", TORQUES, "Contact wrenches"]
    curves = curves_of(uplot_props(panels[TORQUES]))
    names = lxml.html.fromstring(f"<p>{names_html(panels[TORQUES])}</p>").text_content()
    for label, used in zip(of.labels[:4], of.share.T, strict=False):
        (name,) = (name for name in curves if name.startswith(f"{label}:"))
        time, share = curves[name]
        np.testing.assert_allclose(share, 100 * used)
        np.testing.assert_allclose(time, lifted.trajectory.time)
        assert name in names.replace("\xa0", " ")


@pytest.mark.quick
def test_no_peak_is_lost_and_names_are_text():
    x, y = np.linspace(0, 1, 5 * MOST_SAMPLES), np.full(5 * MOST_SAMPLES, 20.0)
    y[1333] = 100.0
    panel = Panel(x=Axis(ends=(0.0, 1.0)), y=Axis(ends=(0.0, 160.0)), items=[Line(x=x, y=y, label="<b>/&")])
    time, curve = curves_of(uplot_props(panel))["<b>/&"]
    assert len(time) <= MOST_SAMPLES + 2
    assert np.max(curve) == 100.0
    names = lxml.html.fromstring(f"<p>{names_html(panel)}</p>")
    assert not names.xpath("//b")
    assert "<b>/&" in names.text_content()


def test_a_saved_result_plays_without_a_compiler(lifted, tmp_path, monkeypatch):
    mrts.save_result(lifted, tmp_path / "fast.npz")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    state = PlayerState.saved(mrts.load_result(tmp_path / "fast.npz"))
    assert state.admissible
    with shown_viewer(state) as opened:
        viewer = opened.shown
        viewer.playback.toggle()
        viewer.step(1.0)
        before = viewer.sample
        for _ in range(4):
            viewer.step(0.2)
        assert viewer.sample > before
        assert opened.controls["Play"].label == "Pause"
        share = state.trajectory.time[viewer.sample] / state.trajectory.duration
        assert f"--mrts-cursor: {share:.4f}" in viewer.plots.cursor.content


def test_the_knob_stops_the_motion_on_its_path_and_lets_it_go_on(viewer):
    shown, knob = viewer.shown, viewer.controls["override [%]"]
    assign(viewer.controls["pace"], PACES[1.0])
    shown.playback.toggle()
    assign(knob, 0)
    end, before = time.monotonic() + PATIENCE, -1.0
    while shown.playback.time != before and time.monotonic() < end:  # it goes on as planned until its tables are made
        before = shown.playback.time
        shown.step(1e-4)
    stood = shown.playback.time
    shown.step(0.05)
    assert shown.playback.time == stood > 0
    assign(knob, 30)
    shown.step(0.1)  # it has come to the wanted speed
    before = shown.playback.time
    shown.step(0.04)
    assert shown.playback.time - before == pytest.approx(0.3 * 0.04, rel=1e-6)
    assign(viewer.controls["time [s]"], 0.05)
    shown.step(0.0)
    assert shown.playback.time == pytest.approx(0.05)
    choose(viewer, speed_c=1.15 * shown.state.speeds.upper / 1.2)
    assert knob.disabled
