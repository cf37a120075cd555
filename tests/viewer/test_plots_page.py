"""A saved result in a real browser: its plots follow the motion, another stands beside it, and a picture is taken."""

import io
import time

import numpy as np
import pytest
from PIL import Image
from viewer_browser import SECONDS, chromium, open_page, running_viewer

import mrts
from mrts.viewer.plots.time_plots import time_panels

assert chromium  # a fixture, imported for pytest

CURSOR = """() => parseFloat(getComputedStyle(document.documentElement).getPropertyValue('--mrts-cursor'))"""

CUT = """() => [...document.querySelectorAll('[data-plot]')]
    .filter(text => text.clientWidth && text.scrollWidth > text.clientWidth + 1).map(text => text.innerText)"""

OUTSIDE = """() => [...document.querySelectorAll('.uplot')].filter(plot => {
    const edge = plot.parentElement.getBoundingClientRect(), place = plot.getBoundingClientRect();
    return place.left < edge.left - 1 || place.right > edge.right + 1;
}).length"""

OFF = """() => Math.max(...[...document.querySelectorAll('.u-over')].map(over => {
    const style = getComputedStyle(document.documentElement), named = over.closest('.uplot').querySelector('.u-title');
    const share = parseFloat(style.getPropertyValue(named ? '--mrts-along' : '--mrts-cursor'));
    return Math.abs(parseFloat(getComputedStyle(over, '::after').left) - share * over.clientWidth);
}))"""
"""How far the cursor of some plot is from where its style sheet says [pixels]."""


@pytest.mark.slow
def test_plots_follow_a_saved_result_and_its_picture_is_taken(chromium, lifted, planar_cell, lift, tmp_path):
    mrts.save_result(lifted, tmp_path / "fast.npz")
    mrts.save_result(mrts.scale(planar_cell, lift, 0.5), tmp_path / "slow.npz")
    with (
        running_viewer(tmp_path / "fast.npz", "--with", tmp_path / "slow.npz") as (_, url),
        open_page(chromium, url) as page,
    ):
        page.get_by_role("tab", name="Plots").click()
        page.wait_for_selector(".uplot canvas")
        plots = page.locator("[data-plot]:not([data-plot=names])").evaluate_all(
            "all => all.map(each => each.dataset.plot)"
        )
        assert plots == ["compared", *time_panels(lifted)]
        assert page.locator(".uplot canvas").count() == len(plots) - 1
        assert page.locator("[data-plot=compared]").inner_text().startswith("Shown: 0.2992 s, 2.47 × as fast as slow")
        assert page.evaluate(OFF) < 1
        page.get_by_role("button", name="Play", exact=True).click()
        seen = set()
        end = time.monotonic() + SECONDS
        while len(seen) < 4:
            assert time.monotonic() < end, seen
            seen.add(page.evaluate(CURSOR))
        page.get_by_role("button", name="Pause").click()
        assert max(seen) <= lifted.trajectory.duration / (lift.time[-1] / np.sqrt(0.5)) + 1e-3
        assert page.evaluate(OFF) < 1
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
            assert page.evaluate(CUT) == [], width
            assert page.evaluate(OUTSIDE) == 0, width
        page.get_by_role("tab", name="Plots").click()  # a window that becomes wide shows the first tab
        page.get_by_role("button", name="Play", exact=True).click()
        page.wait_for_function(f"before => ({CURSOR})() != before", arg=page.evaluate(CURSOR))
        assert page.problems == []
