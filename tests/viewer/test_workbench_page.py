"""The workbench in a real browser: every control of its panel, and where the panel is."""

import shutil

import numpy as np
import pytest
from conftest import DATA
from playwright.sync_api import TimeoutError as NotInTime
from viewer_browser import chromium, in_picture, open_page, running_viewer

from mrts.scene.cell_view import look_at_cell
from mrts.viewer.controls.gizmo import ARM

assert chromium  # a fixture, imported for pytest

WIDTHS = (1400, 900, 700, 577, 500)
"""Of windows [pixels]."""

DRAGGED = 0.2
"""Way of a gizmo [m]."""

DRAWN = 500
"""Between frames of a browser that draws without a graphics card, mostly [ms]."""

TRIES, TRIED = 6, 10_000
"""How often a gizmo is taken that was not drawn in time, and how long it is waited for each time [ms]."""

PIXEL = 0.02
"""Three pixels of the scene at that size [m]: where a mouse can be."""

OVERLAP = """() => {
    const scene = document.querySelector('canvas').getBoundingClientRect();
    const outcome = document.querySelector('[data-text=outcome]');
    const panel = outcome.closest('.mantine-ScrollArea-root').getBoundingClientRect();
    const texts = [...document.querySelectorAll('[data-text], [data-bars] td')];
    return {
        width: Math.min(scene.right, panel.right) - Math.max(scene.left, panel.left),
        height: Math.min(scene.bottom, panel.bottom) - Math.max(scene.top, panel.top),
        scene: [scene.width, scene.height],
        cut: texts.filter(text => text.clientWidth && text.scrollWidth > text.clientWidth + 1)
            .map(text => text.innerText),
    };
}"""


def text(page, kind):
    return page.locator(f'[data-text="{kind}"]').inner_text()


def waits_for(page, kind, words):
    """Until a text has some words; the page's own time limit applies."""
    page.wait_for_function(
        "([kind, words]) => document.querySelector(`[data-text=${kind}]`)?.innerText.includes(words)", arg=[kind, words]
    )


def pick(page, menu, option):
    page.get_by_role("combobox", name=menu, exact=True).click()
    page.get_by_role("option", name=option).first.click()


def row(page, label):
    """The slider beside a label."""
    found = page.locator("div", has=page.get_by_text(label, exact=True)).filter(has=page.get_by_role("slider"))
    return found.last.get_by_role("slider")


def drag_along_x(page, cell, motion, base, way):
    """Take the gizmo's arrow at a base with the mouse, and move it until its slider shows some way along x [m]."""
    edge = page.evaluate(
        "() => { const at = document.querySelector('canvas').getBoundingClientRect();"
        " return [at.left, at.top, at.width, at.height]; }"
    )
    view = look_at_cell(cell, motion.q, motion.object.position)
    held = ARM * view.size * np.array([0.5, 0.0, 0.0])
    points = np.array([base + held, base + held + [way, 0, 0]])
    across, high = in_picture(view, points, edge[2] / edge[3])
    start, end = np.column_stack([edge[0] + edge[2] * (1 + across) / 2, edge[1] + edge[3] * (1 - high) / 2])
    slider = row(page, "along x [mm]").element_handle()
    there = "([slider, way, near]) => Math.abs(slider.getAttribute('aria-valuenow') - way) < near"
    for turn in range(1, TRIES + 1):
        page.mouse.move(*start)
        page.wait_for_timeout(turn * DRAWN)  # until the picture knows what is below the pointer
        page.mouse.down()
        page.mouse.move(*end, steps=8)
        try:
            page.wait_for_function(there, arg=[slider, 1000 * way, 1000 * PIXEL], timeout=TRIED)
        except NotInTime:
            assert turn < TRIES
            page.mouse.move(*start, steps=8)  # the camera, if that was taken, goes back
        else:
            return
        finally:
            page.mouse.up()


def drag_and_undo(page, cell, motion):
    """The left base follows the mouse, its slider says how far, and one step of undo takes back the whole drag."""
    first = text(page, "outcome")
    pick(page, "move", "left base")
    drag_along_x(page, cell, motion, cell.robots[0].T_world_base.p, DRAGGED)
    page.wait_for_function("text => document.querySelector('[data-text=outcome]').innerText != text", arg=first)
    page.get_by_role("button", name="Undo").click()
    page.wait_for_function("text => document.querySelector('[data-text=outcome]').innerText == text", arg=first)


def change_view(page):
    page.get_by_role("tab", name="View").click()
    for name in ("frames", "names", "shadows", "dark"):
        page.get_by_role("checkbox", name=name).click()
    page.wait_for_selector('[data-mantine-color-scheme="dark"]', state="attached")
    page.get_by_role("button", name="Show the whole cell").click()


@pytest.mark.slow
def test_every_control_does_what_it_says(chromium, planar_cell, lifted, tmp_path):
    folder = shutil.copytree(DATA, tmp_path / "cell")
    cell = folder / "cell.yaml"
    cell.write_text(cell.read_text().replace("  mass: 0.5 ", "  variation: {mass: [0.5, 2]}\n  mass: 0.5 "))
    with running_viewer(cell, folder / "lift.yaml") as (_, url), open_page(chromium, url) as page:
        first = text(page, "outcome")
        page.get_by_role("tab", name="Change").click()
        row(page, "mass [kg]").press("End")
        waits_for(page, "outcome", "2 kg")
        page.get_by_role("button", name="Undo").click()
        page.wait_for_function("text => document.querySelector('[data-text=outcome]').innerText == text", arg=first)
        page.get_by_role("button", name="Redo").click()
        waits_for(page, "outcome", "2 kg")
        page.get_by_role("button", name="Reset").click()
        pick(page, "load", "mass × 2")
        page.wait_for_function("text => document.querySelector('[data-text=outcome]').innerText != text", arg=first)
        pick(page, "load", "every load")
        page.wait_for_function("text => document.querySelector('[data-text=outcome]').innerText == text", arg=first)
        row(page, "left wrenches [%]").press("End")
        page.wait_for_function("text => document.querySelector('[data-text=outcome]').innerText != text", arg=first)
        page.get_by_role("button", name="Reset").click()
        pick(page, "profile", "optimal")
        waits_for(page, "outcome", "fastest timing")
        pick(page, "profile", "smooth")
        waits_for(page, "outcome", "smooth timing")
        pick(page, "profile", "constant")
        page.get_by_role("checkbox", name="fixed shares of the load").click()
        page.wait_for_function("text => document.querySelector('[data-text=outcome]').innerText != text", arg=first)
        page.get_by_role("button", name="Reset").click()
        page.wait_for_function("text => document.querySelector('[data-text=outcome]').innerText == text", arg=first)
        drag_and_undo(page, planar_cell, lifted.motion)
        pick(page, "move", "end of the motion")
        row(page, "along y [mm]").press("End")
        waits_for(page, "outcome", "No motion")
        assert "cannot reach" in text(page, "outcome")
        assert "Red in the scene" in text(page, "outcome")
        page.get_by_role("button", name="Undo").click()
        page.wait_for_function("text => document.querySelector('[data-text=outcome]').innerText == text", arg=first)
        page.get_by_role("button", name="Rank all configurations").click()
        pick(page, "configuration", "2: ")
        page.wait_for_function("text => document.querySelector('[data-text=outcome]').innerText != text", arg=first)
        change_view(page)
        page.get_by_role("tab", name="Save").click()
        page.get_by_role("button", name="Save").last.click()
        waits_for(page, "saved", "configuration 2")
        page.get_by_role("button", name="Save").last.click()
        waits_for(page, "error", "exists already")
        assert page.problems == []
    assert "variation: {mass: [0.5, 2]}" in (folder / "changed_cell.yaml").read_text()
    assert (folder / "changed_motion.yaml").read_text() == (folder / "lift.yaml").read_text()


@pytest.mark.slow
def test_the_panel_covers_no_scene_and_cuts_no_text(chromium):
    with running_viewer(DATA / "cell.yaml", DATA / "lift.yaml") as (_, url), open_page(chromium, url) as page:
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 800})
            page.wait_for_function(
                f"() => {{ const found = ({OVERLAP})(); return found.cut.length == 0"
                " && Math.min(found.width, found.height) <= 1 && Math.min(...found.scene) >= 300; }"
            )
        assert page.problems == []


TOPS = """() => [...document.querySelectorAll('.mantine-Slider-root, [role=tab], [role=combobox], button')]
    .filter(each => each.offsetParent).map(each => each.getBoundingClientRect().top)"""

TALL = {"width": 1400, "height": 1700}
"""Of a window in which the panel does not scroll [pixels]."""


@pytest.mark.slow
def test_numbers_keep_the_point_that_is_typed(chromium):
    with running_viewer(DATA / "cell.yaml", DATA / "lift.yaml") as (_, url), open_page(chromium, url) as page:
        page.get_by_role("tab", name="Change").click()
        pick(page, "move", "left base")
        for label, number in (
            ("time [s]", "0.15"), ("speed c", "1.5"), ("along x [mm]", "1.5"), ("left torques [%]", "87.5"),
        ):  # fmt: skip
            slider = row(page, label)
            field = (
                slider.locator("xpath=ancestor::div[contains(@class, 'mantine-Flex-root')][1]").locator("input").last
            )
            field.press("Control+a")
            field.press_sequentially(number, delay=50)
            page.wait_for_selector("[data-text=computing]", state="detached")
            assert (field.input_value(), slider.get_attribute("aria-valuenow")) == (number, number)
        assert page.problems == []


@pytest.mark.slow
def test_no_control_moves_when_an_answer_comes(chromium):
    """Feasible, beyond the range, infeasible and out of reach, and while each is found."""
    with running_viewer(DATA / "cell.yaml", DATA / "lift.yaml") as (_, url), open_page(chromium, url) as page:
        page.set_viewport_size(TALL)
        page.get_by_role("tab", name="Change").click()
        pick(page, "move", "end of the motion")
        row(page, "about z [°]").wait_for()
        before = page.evaluate(TOPS)
        for label, key, kind, words in (
            ("mass [kg]", "End", "outcome", "1.972"),
            ("speed c", "End", "speed", "Outside"),
            ("left torques [%]", "Home", "outcome", "infeasible"),
            ("along y [mm]", "End", "outcome", "No motion"),
        ):
            row(page, label).press(key)
            assert page.evaluate(TOPS) == before, label
            waits_for(page, kind, words)
            page.wait_for_selector("[data-text=computing]", state="detached")
            assert page.evaluate(TOPS) == before, label
        assert page.problems == []
