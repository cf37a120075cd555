"""The report of a timing: its own answer first, limits told apart, one cursor, dark and printed."""

import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from headless_browser import NARROW, browser, page  # noqa: F401 (fixtures)
from report_pages import data_of

import mrts
from mrts.plots.limit_plots import limit_map
from mrts.plots.limit_shares import limiting_rows
from mrts.plots.phase_plane import phase_plane_plot
from mrts.plots.plot import HeatMap, Line
from mrts.report import report_html
from mrts.scaling.limit_use import limit_uses, used_shares

SLOW = 60_000
"""A page drawn without a graphics card takes its time [ms]."""

DRAWN = 1e-5
"""Numbers of a page have six digits."""


@pytest.fixture(scope="module")
def timing(planar_cell, lift):
    return mrts.retime(planar_cell, lift)


@pytest.fixture(scope="module")
def text(timing):
    return report_html(timing)


def sections(text):
    """Names of the sections in their order."""
    return re.findall(r'<section id="([^"]+)"', text)


@pytest.mark.quick
def test_the_timing_stands_first_with_saving_limits_and_phase_plane(timing, text):
    assert sections(text)[:2] == ["timing", "motion"]
    sentence = timing.sentence()
    assert f"{sentence[0].upper()}{sentence[1:]}" in text
    assert f"{100 * timing.saving:.3g} % less than the best constant factor" in text
    for name, share in timing.limits[:12]:
        assert re.search(rf"<td>{re.escape(name)}</td>\s*<td>.*?{100 * share:.0f} %</td>", text, re.DOTALL), name
    curves = [item for item in phase_plane_plot(timing).rows[0][0].items if isinstance(item, Line)]
    traces = {trace.get("name"): trace for trace in data_of(text)["plots"]["plot-phase-plane"]["data"]}
    assert [curve.label.split(",")[0] for curve in curves[-2:]] == ["fastest", "best constant c"]
    for curve in curves:
        np.testing.assert_allclose(traces[curve.label]["x"], curve.x, rtol=DRAWN)
        np.testing.assert_allclose(traces[curve.label]["y"], curve.y, rtol=DRAWN)
    links = re.findall(r'<a href="#([^"]+)"', text)
    assert links == sections(text)


def test_without_a_profile_the_best_constant_factor_is_shown(planar_cell, lift):
    found = mrts.retime(planar_cell.with_mass(24.0), lift)
    text = report_html(found)
    assert found.retimed is None
    assert "timing" not in sections(text)
    assert "conflicts" in sections(text)
    assert "The best constant factor, which is shown below" in text


@pytest.mark.quick
def test_limits_that_set_the_speed_stand_first_and_the_others_are_told_apart(lifted, planar_cell, lift):
    end = lifted.range.upper
    found = limiting_rows(lifted, None)
    assert set(found.setting) == {row.name for row in end.rows}
    slower = mrts.scale(planar_cell, lift, 0.5 * end.c2)
    told = limiting_rows(slower, None)
    assert told.setting == {}
    at_limit = {use.name for use in limit_uses(slower) if use.share > 1 - 1e-9}
    assert set(told.reached) == at_limit
    assert set(told.reached.values()) == {"reached through the distribution"}
    # another distribution at the same speed keeps off them, so the rows are truly not forced
    freer = mrts.scale(planar_cell, lift, 0.5 * end.c2, distribute="reserve")
    assert max(use.share for use in limit_uses(freer) if use.name in at_limit) < 1 - 1e-3
    (cells,) = (item for item in limit_map(lifted, found).rows[0][0].items if isinstance(item, HeatMap) and item.names)
    orange = cells.z == cells.names.index("at the limit where the speed is set")
    names, shares = used_shares(lifted.trajectory)
    assert [bool(row.any()) for row in orange] == [True] * len(end.rows) + [False] * (len(names) - len(end.rows))
    assert orange[:, 1:].any() == (np.count_nonzero(found.forced.any(axis=1)) > 2)
    assert shares.shape == (lifted.motion.samples, len(names))


def test_where_a_velocity_sets_the_speed_torques_and_wrenches_are_at_their_limits_through_the_distribution(dual_ur5):
    found = mrts.scale(dual_ur5, mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml"))
    (fastest,) = {row.name for row in found.range.upper.rows}
    assert fastest.kind == "velocity"
    told = limiting_rows(found, None)
    assert set(told.setting) == {fastest}
    names, _ = used_shares(found.trajectory)
    assert {names[place] for place in np.flatnonzero(told.forced.any(axis=0))} == {fastest}
    assert set(told.reached.values()) <= {"reached through the distribution"}


def test_of_a_saved_timing_what_sets_the_speed_is_still_told(timing):
    found, known = limiting_rows(timing.retimed, None), limiting_rows(timing.retimed, timing)
    assert found.setting.keys() <= known.setting.keys() | known.reached.keys()
    assert len(found.setting) >= 6


def test_positions_and_velocities_have_their_limits_and_percentages(planar_cell, lift):
    robots = [
        replace(robot, velocity_limit=np.full(3, 10.0), position_lower=np.full(3, -4.0), position_upper=np.full(3, 4.0))
        for robot in planar_cell.robots
    ]
    found = mrts.scale(replace(planar_cell, robots=tuple(robots)), lift)
    plots = data_of(report_html(found))["plots"]
    for kind, values, limit in (("velocity", found.trajectory.dq, 10), ("position", found.trajectory.q, 4)):
        lines = plots[f"plot-{kind}-1-0"]["data"]
        elbow = next(trace for trace in lines if trace["name"] == "elbow")
        np.testing.assert_allclose(elbow["y"], values[:, 4], rtol=DRAWN, atol=1e-9)
        assert elbow["customdata"] == np.round(100 * np.abs(values[:, 4]) / limit).astype(int).tolist()
        assert {abs(trace["y"][0]) for trace in lines if not trace["name"]} <= {limit}


def test_one_cursor_goes_through_all_and_the_page_is_dark_or_printed(text, tmp_path, page):  # noqa: F811
    path = tmp_path / "report.html"
    path.write_text(text, encoding="utf-8")
    page.emulate_media(color_scheme="dark")
    page.goto(path.as_uri())
    page.wait_for_selector("body[data-ready=yes]", timeout=SLOW)

    def look():
        return page.evaluate("""() => ({
            paper: getComputedStyle(document.body).backgroundColor,
            plot: document.querySelector('#plot-torque-0 .main-svg').style.background,
            theme: document.getElementById('theme').textContent,
        })""")

    dark = "rgb(21, 24, 28)"
    assert look() == {"paper": dark, "plot": dark, "theme": "Light"}
    page.locator("#theme").click()
    white = {"paper": "rgb(255, 255, 255)", "plot": "rgb(255, 255, 255)", "theme": "Dark"}
    assert look() == white
    page.locator("#theme").click()

    frame = 40
    slide = "(slider, frame) => { slider.value = frame; slider.dispatchEvent(new Event('input')); }"
    page.locator("#frame").evaluate(slide, frame)
    clocks = data_of(text)["player"]["clocks"]
    at = page.evaluate("""() => Object.fromEntries([...document.querySelectorAll('.cursor')].map((cursor) => {
        const plot = cursor.parentElement;
        return [plot.id, plot._fullLayout.xaxis.p2d(parseFloat(cursor.style.transform.slice('translateX('.length)))];
    }))""")
    kinds = {name: plot["clock"] for name, plot in data_of(text)["plots"].items() if plot["clock"]}
    assert set(at) == set(kinds)
    assert {"plot-phase-plane", "plot-limit-map", "plot-torque-1", "plot-position-0-0"} <= set(at)
    for name, x in at.items():
        assert x == pytest.approx(clocks[kinds[name]][frame], rel=1e-3), name
    box = page.locator("#plot-torque-0 .nsewdrag").first
    box.scroll_into_view_if_needed()
    box = box.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2)
    for _ in range(SLOW // 200):
        if int(page.locator("#frame").input_value()) != frame:
            break
        page.wait_for_timeout(200)
    shown = clocks["played"][int(page.locator("#frame").input_value())]
    assert shown == pytest.approx(clocks["played"][-1] / 4, rel=0.05)

    page.set_viewport_size(NARROW)
    for _ in range(SLOW // 200):
        if page.locator("#plot-phase-plane .main-svg").first.bounding_box()["width"] < NARROW["width"]:
            break
        page.wait_for_timeout(200)
    pictures = page.evaluate("""() => {
        dispatchEvent(new Event('beforeprint'));
        const picture = document.querySelector('#player canvas.picture');
        const pixels = picture.getContext('2d').getImageData(0, 0, picture.width, picture.height).data;
        const hidden = [...document.querySelectorAll('[id^=plot-]')].filter((plot) => {
            const places = ['.legend .bg', '.nsewdrag'].map((part) => plot.querySelector(part));
            const [legend, lines] = places.map((part) => part && part.getBoundingClientRect());
            return legend && legend.bottom > lines.top + 1;
        });
        return {
            colours: new Set(new Uint32Array(pixels.buffer)).size,
            width: document.body.clientWidth,
            hidden: hidden.map((plot) => plot.id),
        };
    }""")
    assert pictures["hidden"] == []  # no curve by a legend that takes more lines on paper
    assert pictures["colours"] > 50  # the scene, not an empty sheet
    assert look() | {"theme": "Dark"} == white
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert look()["paper"] == dark
    assert page.locator("#player canvas.picture").count() == 0
    assert page.problems == []
