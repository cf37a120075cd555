"""Controls of the viewer without a browser: their values are set as a browser's messages set them."""

import time
from dataclasses import replace
from types import SimpleNamespace

import pytest
import viser
from conftest import DATA

import mrts
from mrts.motion.motion_file import described_motion
from mrts.viewer.controls.bound_control import DECIMALS, assign
from mrts.viewer.server import close_server, open_server
from mrts.viewer.viewer import Viewer
from mrts.viewer.workbench.choices import Given
from mrts.viewer.workbench.workbench import Workbench

PATIENCE = 30.0


@pytest.fixture(scope="module")
def server():
    opened = open_server("127.0.0.1", 0, "test")
    yield opened
    close_server(opened)


@pytest.fixture
def viewer(server, planar_cell, lift):
    """The viewer, its workbench, and its controls by label."""
    server.gui.reset()
    bench = Workbench(Given(planar_cell, lift, described_motion(DATA / "lift.yaml")))
    shown = Viewer(server, bench, {}, pytest.fail)
    controls = {getattr(handle, "label", ""): handle for handle in server.controls.values()}
    yield SimpleNamespace(shown=shown, bench=bench, controls=controls)
    shown.close()


def choose(viewer, **values):
    """Set controls, and wait for the answer."""
    for label, value in values.items():
        assign(viewer.controls[label.replace("_", " ")], value)
    viewer.shown.settle()


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


def test_a_hand_on_the_slider_is_not_pushed_back(viewer, monkeypatch):
    """An answer to where the slider was comes after it has moved on."""
    slider, bench = viewer.controls["speed c"], viewer.bench
    slider.value = 0.5
    viewer.shown.step(0.0)
    slider.value = 0.7
    end, news = time.monotonic() + PATIENCE, []
    while not news and time.monotonic() < end:
        news = bench.take()
        time.sleep(0.001)
    with monkeypatch.context() as just_ready:
        just_ready.setattr(bench, "take", lambda: news)
        viewer.shown.step(0.0)
    assert viewer.shown.state.trajectory.c == pytest.approx(0.5)
    assert slider.value == 0.7
    viewer.shown.settle()
    assert slider.value == 0.7
    assert viewer.shown.state.trajectory.c == pytest.approx(0.7)


def test_ranking_again_keeps_the_chosen_configuration(viewer):
    bench, menu = viewer.bench, viewer.controls["configuration"]
    bench.rank()
    viewer.shown.settle()
    second = menu.options[2]
    choose(viewer, configuration=second)
    postures = bench.choices.postures
    bench.edit(replace(bench.choices, mass=2 * bench.given.cell.mass))
    bench.rank()
    viewer.shown.settle()
    assert second not in bench.configuration_labels()  # its c²⁺ is another one
    assert bench.choices.postures == postures
    assert menu.value == second
    choose(viewer, configuration=bench.configuration_labels()[0])
    assert bench.choices.postures != postures
    viewer.shown.step(0.0)
    assert viewer.shown.state is not None


def test_what_was_changed_just_before_a_button_is_older_than_it(viewer):
    """Both come between two frames: the change is taken back with the rest, and is a step of its own."""
    shown, bench, shares = viewer.shown, viewer.bench, viewer.controls["fixed shares of the load"]
    group = viewer.controls["change"]

    def press(which):
        assign(group, which)
        for pressed in group._impl.update_cb:  # noqa: SLF001 (as viser calls it)
            pressed(SimpleNamespace(target=group))
        shown.settle()

    assign(shares, value=True)
    press("Reset")
    assert (bench.choices.shares, shares.value) == (None, False)
    press("Undo")
    assert bench.choices.shares is not None
    assert shares.value


def test_an_answer_is_outdated_as_soon_as_a_control_changes(viewer):
    shown, bench = viewer.shown, viewer.bench

    def verdict():
        content = shown._verdict.content  # noqa: SLF001 (what the page shows)
        return 'data-text="computing"' in content, 'data-text="error"' in content, "--mrts-answer" in content

    shown.settle()
    assert verdict() == (False, False, False)
    for label, value in (("mass [kg]", 1.0), ("speed c", 0.5)):
        assign(viewer.controls[label], value)
        shown.step(0.0)
        assert verdict() == (True, False, True), label
        shown.settle()
        assert verdict() == (False, False, False), label
    bench.edit(replace(bench.choices, mass=-1.0))
    shown.settle()
    assert verdict() == (False, True, True)  # the last answer stays, of the values before
    bench.undo()
    shown.step(0.0)
    assert verdict() == (True, False, True)
    shown.settle()
    assert verdict() == (False, False, False)


def test_start_and_goal_are_outlines(viewer, lift):
    scene = viewer.shown.server.scene
    for name, at in (("/start", 0), ("/goal", -1)):
        outline = scene.get_handle_by_name(name)
        assert outline.points.shape[1:] == (2, 3)
        assert len(outline.points) >= 12  # sides of a box
        assert outline.position == pytest.approx(lift.position[at])


def test_every_number_field_takes_decimal_places(viewer):
    """Of one with none the page drops the point: a typed 1.5 is 15."""
    sliders = [each for each in viewer.controls.values() if isinstance(each, viser.GuiSliderHandle)]
    assert len(sliders) == 13
    assert all(slider.precision >= DECIMALS for slider in sliders)


def test_it_opens_at_the_moment_that_decides(server, dual_ur5):
    server.gui.reset()
    motion = mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml")
    shown = Viewer(server, Workbench(Given(dual_ur5, motion)), {}, pytest.fail)
    state, upper = shown.state, shown.state.result.range.upper
    (time_slider,) = (each for each in server.controls.values() if getattr(each, "label", "") == "time [s]")
    shown.close()
    assert 0 < upper.sample < len(state.trajectory.time) - 1
    assert state.sample == upper.sample
    assert time_slider.value == pytest.approx(state.trajectory.time[upper.sample], abs=1e-4)
