"""The viewer in a real browser: its controls, where its panel is, its plots, and who may connect."""

import re
import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest
from conftest import DATA
from headless_browser import running_chromium

SECONDS = 60
SIZE = {"width": 1200, "height": 700}

COARSE = 0.25
"""Pixels a point of the page: the scene is drawn without a graphics card, and no test looks at its pixels."""


@contextmanager
def running_viewer(*arguments):
    """`mrts view` on a free port: its process, and its URL."""
    command = [sys.executable, "-m", "mrts", "view", *map(str, arguments), "--port", "0", "--no-open"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            said = ""
            while not (found := re.search(r"http://\S+", said)):
                line = process.stdout.readline()
                assert line, f"{said}{process.stderr.read()}"
                said += line
            process.said = said
            yield process, found.group()
        finally:
            if process.poll() is None:
                process.kill()


def interrupt(process):
    """Ctrl-C; all that the viewer says, and its exit code."""
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=SECONDS)
    return process.said + out, err, process.returncode


@pytest.fixture(scope="module")
def chromium():
    with running_chromium("--use-angle=swiftshader", "--enable-unsafe-swiftshader") as running:
        yield running


@contextmanager
def open_page(browser, url):
    """The viewer's page once its panel is there; what went wrong in it is in `page.problems`."""
    page = browser.new_page(viewport=SIZE, device_scale_factor=COARSE)
    page.set_default_timeout(1000 * SECONDS)
    page.problems = []
    page.on("console", lambda message: page.problems.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: page.problems.append(str(error)))
    page.goto(url)
    page.wait_for_selector("[data-bar]", timeout=1000 * SECONDS)
    try:
        yield page
    finally:
        page.close()


FILES = DATA / "cell.yaml", DATA / "lift.yaml"

WIDTHS = (1400, 900, 700, 577, 500)
"""Of windows [pixels]."""

TALL = {"width": 1400, "height": 1700}
"""Of a window in which the panel does not scroll [pixels]."""

USED = "parseFloat(document.querySelector('[data-bar] td:last-child').innerText)"
"""Share of the limit of which most is used [%]."""

LAID_OUT = """() => {
    const scene = document.querySelector('canvas').getBoundingClientRect();
    const outcome = document.querySelector('[data-text=outcome]');
    const panel = outcome.closest('.mantine-ScrollArea-root').getBoundingClientRect();
    const texts = [...document.querySelectorAll('[data-text], [data-bars] td, [data-plot]')];
    const wide = Math.min(scene.right, panel.right) - Math.max(scene.left, panel.left);
    const high = Math.min(scene.bottom, panel.bottom) - Math.max(scene.top, panel.top);
    const right = each => each.getBoundingClientRect().right;
    const plots = [...document.querySelectorAll('.uplot')];
    return Math.min(wide, high) <= 1 && Math.min(wide, high) > -60 && Math.min(scene.width, scene.height) >= 300
        && !texts.some(text => text.clientWidth && text.scrollWidth > text.clientWidth + 1)
        && !plots.some(plot => right(plot) > right(plot.parentElement) + 1);
}"""
"""Whether the panel stands beside the scene, its own head between them at most, and cuts no text and no plot."""

RESET = "Reset all changes"

TOPS = """() => [...document.querySelectorAll('.mantine-Slider-root, [role=tab], [role=combobox], button')]
    .filter(each => each.offsetParent).map(each => each.getBoundingClientRect().top)"""


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


def press(page, name):
    page.get_by_role("button", name=name, exact=True).last.click()


def row(page, label):
    """The slider beside a label."""
    found = page.locator("div", has=page.get_by_text(label, exact=True)).filter(has=page.get_by_role("slider"))
    return found.last.get_by_role("slider")


@pytest.mark.quick
def test_the_page_follows_the_speed_slider(chromium):
    with running_viewer(*FILES) as (process, url), open_page(chromium, url) as page:
        page.wait_for_selector("canvas")
        assert "1.75 × as fast" in text(page, "outcome")
        assert "Inside the admissible range [0, 3.062]" in text(page, "speed")
        assert page.evaluate(USED) == 100
        before = page.locator("[data-bars]").inner_text()
        speed, time, _ = page.get_by_role("slider").all()
        speed.press("Home")
        waits_for(page, "speed", "c = 0.0")
        assert page.locator("[data-bars]").inner_text() != before
        assert "Inside" in text(page, "speed")
        speed.press("End")
        page.wait_for_function(f"{USED} > 101")
        assert "Outside the admissible range" in text(page, "speed")
        time.press("End")
        assert time.get_attribute("aria-valuenow") == "0.2493"
        assert page.problems == []
        out, err, code = interrupt(process)  # while the page is open
    assert (code, err) == (0, "")
    assert len(out.splitlines()) == 2  # the outcome and the address: no banner


@pytest.mark.slow
def test_numbers_keep_the_point_that_is_typed_and_no_control_moves(chromium):
    """Feasible, beyond the range, infeasible and out of reach, and while each is found; at every width."""
    with running_viewer(*FILES) as (_, url), open_page(chromium, url) as page:
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 800})
            page.wait_for_function(LAID_OUT)
        page.set_viewport_size(TALL)
        page.get_by_role("tab", name="Change").click()
        pick(page, "move", "end of the motion")
        pick(page, "limit", "left: all torques")
        row(page, "about z [°]").wait_for()
        for label, number in (("time [s]", "0.15"), ("speed c", "1.5"), ("of that limit [%]", "87.5")):
            slider = row(page, label)
            flex = slider.locator("xpath=ancestor::div[contains(@class, 'mantine-Flex-root')][1]")
            field = flex.locator("input").last
            field.press("Control+a")
            field.press_sequentially(number, delay=50)
            page.wait_for_selector("[data-text=computing]", state="detached")
            assert (field.input_value(), slider.get_attribute("aria-valuenow")) == (number, number)
        press(page, RESET)
        waits_for(page, "speed", "[0, 3.062]")
        before = page.evaluate(TOPS)
        for label, key, kind, words in (
            ("mass [kg]", "End", "speed", "1.972"),
            ("speed c", "End", "speed", "Outside"),
            ("of that limit [%]", "Home", "outcome", "infeasible"),
            ("along y [mm]", "End", "outcome", "No motion"),
        ):
            row(page, label).press(key)
            assert page.evaluate(TOPS) == before, label
            waits_for(page, kind, words)
            page.wait_for_selector("[data-text=computing]", state="detached")
            assert page.evaluate(TOPS) == before, label
        assert page.problems == []
