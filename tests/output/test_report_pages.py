"""Reports of results in a real browser: they open offline and play."""

import re

import numpy as np
import pytest
from headless_browser import NARROW, browser, page  # noqa: F401 (fixtures)
from playwright.sync_api import expect
from report_pages import data_of, own_text
from shown_results import KINDS, result_of

import mrts

LARGEST = 2_100_000
"""Bytes of a report of an ordinary motion or study, 1.84 million of them plotly.js."""

SLOW = 60_000
"""A page drawn without a graphics card takes its time [ms]."""

PLOTTED_LIKE_ANOTHER = {"spatial", "least speed", "infeasible load", "fixed rule", "rates"}
"""Kinds whose pages have the plots of one that is opened; their texts and figures are tested where they are made."""


def until(page, done):  # noqa: F811
    """Wait until something is so; the page's policy forbids what playwright would poll with."""
    for _ in range(SLOW // 200):
        if done():
            return
        page.wait_for_timeout(200)
    raise AssertionError("not in time")


def opened(page, path):  # noqa: F811
    """Open a report, wait until all is drawn, and check what holds of every one; names of its plots."""
    text = path.read_text(encoding="utf-8")
    assert len(text.encode()) < LARGEST
    page.goto(path.as_uri())
    page.wait_for_selector("body[data-ready=yes]", timeout=SLOW)
    assert page.problems == []
    assert page.evaluate("window.broken") is None
    assert {url.split(":")[0] for url in page.requests} <= {"file", "data", "blob"}
    assert sum(url.startswith("file") for url in page.requests) == 1
    plots = set(data_of(text)["plots"])
    for name in plots:
        drawn = ".js-line, .shapelayer path, .barlayer path, .hm, svg.main-svg, canvas"
        assert page.locator(f"#{name} :is({drawn})").count() > 0, name
        assert page.locator(f"#{name}").bounding_box()["height"] < 1200
    places = re.findall(r' id="([^"]+)"', own_text(text))
    assert len(places) == len(set(places))
    assert set(places) >= plots
    page.set_viewport_size(NARROW)
    until(page, lambda: page.evaluate("document.documentElement.scrollWidth <= window.innerWidth"))
    return plots


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in PLOTTED_LIKE_ANOTHER])
def test_every_kind_of_result_opens_offline_with_all_its_plots(kind, planar_cell, dual_ur5, lift, tmp_path, page):  # noqa: F811
    found = result_of(kind, planar_cell, dual_ur5, lift, tmp_path)
    mrts.write_report(found, tmp_path / "report.html")
    expected = set() if found.origin else {"plot-c2_range"}
    robots = len(found.cell.robots)
    if found.trajectory is not None:
        panels = 4 if kind == "sliding joints" else 3  # forces and moments have an axis each
        expected |= {f"plot-torques_and_wrenches-{n}" for n in range(panels * robots)}
        expected |= {f"plot-power_and_energy-{n}" for n in range(robots + 1)}
        kinds = {use.name.kind for use in found.uses}
        expected |= {f"plot-limits-{number}" for number in range(len(kinds))} if len(kinds) > 1 else {"plot-limits"}
    assert opened(page, tmp_path / "report.html") == expected
    assert page.problems == []


def first_arm(page):  # noqa: F811
    """Where the first arm is drawn, Shape (points, 3)."""
    script = "['x', 'y', 'z'].map((axis) => Array.from(document.getElementById('player').data[0][axis]))"
    return np.array(page.evaluate(script)).T


def test_a_reader_moves_turns_and_asks_the_page(lifted, tmp_path, page):  # noqa: F811
    mrts.write_report(lifted, tmp_path / "report.html")
    page.goto((tmp_path / "report.html").as_uri())
    page.wait_for_selector("body[data-ready=yes]", timeout=SLOW)
    scene, button, slider = page.locator("#player canvas").first, page.locator("#play"), page.locator("#frame")
    start, seen = first_arm(page), scene.screenshot()
    assert len(set(seen)) > 50  # something is drawn
    last = int(slider.get_attribute("max"))
    slider.focus()
    page.keyboard.press("End")
    carried = lifted.motion.object
    grasp = carried.position[-1] + carried.rotation[-1] @ lifted.cell.robots[0].T_object_tip.p
    until(page, lambda: np.allclose(first_arm(page)[-1], grasp, atol=1e-5))
    assert scene.screenshot() != seen
    assert "0.299 s of 0.299 s" in page.locator("#now").text_content()
    page.locator("#speed").select_option("0.02")
    button.click()  # from the end it starts again
    expect(button).to_have_text("Pause")
    expect(slider).to_have_value(re.compile(r"^([3-9]|[1-8]\d)$"), timeout=SLOW)
    button.click()
    expect(button).to_have_text("Play", timeout=SLOW)
    assert np.max(np.abs(first_arm(page) - start)) > 1e-3
    page.locator("#speed").select_option("1")
    button.click()
    expect(slider).to_have_value(str(last), timeout=SLOW)
    expect(button).to_have_text("Play", timeout=SLOW)  # it stops at the end
    titles = page.evaluate("[...document.querySelectorAll('.modebar-btn')].map((button) => button.dataset.title)")
    assert set(titles) == {  # plotly's own choice of buttons has one that uploads the chart
        "Download plot as a PNG", "Zoom", "Pan", "Reset axes", "Turntable rotation", "Reset camera to default"
    }  # fmt: skip
    plot = page.locator("#plot-c2_range .nsewdrag").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    page.mouse.move(box["x"] + 0.02 * box["width"], box["y"] + box["height"] / 2)
    page.wait_for_selector("#plot-c2_range .hoverlayer .legend")
    said = page.locator("#plot-c2_range .hoverlayer").text_content()  # the rows that bind under the mouse
    assert "right/elbow ↓" in said
    assert "c² ≥ 0" in said
    assert page.problems == []
