"""A saved result in a real browser: its plots follow the motion, another stands beside it, and a picture is taken."""

import io
import time

import numpy as np
import pytest
from PIL import Image
from viewer_browser import SECONDS, chromium, open_page, running_viewer

import mrts

assert chromium  # a fixture, imported for pytest

CURSOR = """() => parseFloat(getComputedStyle(document.documentElement).getPropertyValue('--mrts-cursor'))"""

CUT = """() => [...document.querySelectorAll('[data-plot] .names, [data-plot] .title')]
    .filter(text => text.clientWidth && text.scrollWidth > text.clientWidth + 1).map(text => text.innerText)"""

OUTSIDE = """() => [...document.querySelectorAll('[data-plot] svg')].flatMap(svg => {
    const edge = svg.getBoundingClientRect();
    return [...svg.querySelectorAll('text')].filter(text => {
        const place = text.getBoundingClientRect();
        return place.left < edge.left - 1 || place.right > edge.right + 1 || place.bottom > edge.bottom + 1;
    }).map(text => text.textContent);
})"""


@pytest.mark.slow
def test_plots_follow_a_saved_result_and_its_picture_is_taken(chromium, lifted, planar_cell, lift, tmp_path):
    mrts.save_result(lifted, tmp_path / "fast.npz")
    mrts.save_result(mrts.scale(planar_cell, lift, 0.5), tmp_path / "slow.npz")
    with (
        running_viewer(tmp_path / "fast.npz", "--with", tmp_path / "slow.npz") as (_, url),
        open_page(chromium, url) as page,
    ):
        page.get_by_role("tab", name="Plots").click()
        page.wait_for_selector("[data-plot=torque] polyline", state="attached")
        plots = page.locator("[data-plot]").evaluate_all("all => all.map(each => each.dataset.plot)")
        assert plots == ["compared", "c2", "torque", "wrench", "phase"]
        assert page.locator("[data-plot=compared]").inner_text().startswith("Shown: 0.2992 s, 2.47 × as fast as slow")
        assert page.evaluate(CURSOR) == 0
        page.get_by_role("button", name="Play", exact=True).click()
        seen = set()
        end = time.monotonic() + SECONDS
        while len(seen) < 4:
            assert time.monotonic() < end, seen
            seen.add(page.evaluate(CURSOR))
        page.get_by_role("button", name="Pause").click()
        assert max(seen) <= 312 * lifted.trajectory.duration / (lift.time[-1] / np.sqrt(0.5)) + 0.1
        page.get_by_role("tab", name="View").click()
        page.get_by_role("combobox", name="stands").click()
        page.get_by_role("option", name="over it").click()
        page.get_by_role("tab", name="Save").click()
        with page.expect_download() as saved:
            page.get_by_role("button", name="Picture (PNG)").click()
        with Image.open(io.BytesIO(saved.value.path().read_bytes())) as picture:
            assert picture.size[0] == 960
        assert saved.value.suggested_filename == f"{planar_cell.name}.png"
        page.get_by_role("tab", name="Plots").click()
        for width in (900, 500, 1400):
            page.set_viewport_size({"width": width, "height": 700})
            assert page.evaluate(CUT) == page.evaluate(OUTSIDE) == [], width
        page.get_by_role("tab", name="Plots").click()  # a window that becomes wide shows the first tab
        page.get_by_role("button", name="Play", exact=True).click()
        page.wait_for_function(f"before => ({CURSOR})() > before", arg=page.evaluate(CURSOR))
        assert page.problems == []
