"""The report: one page that opens offline, in a real browser."""

import os
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from command_line import mrts_without
from conftest import DATA
from headless_browser import NARROW, browser, page  # noqa: F401 (fixtures)
from playwright.sync_api import expect
from report_pages import data_of, own_text
from shown_results import AWKWARD, KINDS, UGLY_JOINTS, result_of, with_awkward_names

import mrts
from mrts.cli import main
from mrts.plots.limit_shares import all_shares
from mrts.plots.plotly_drawer import MOST_SAMPLES, plotly_figure, shown_samples
from mrts.plots.trajectory_plots import torque_plots
from mrts.report import report_html
from mrts.report.tables import duty_table

FILES = [str(DATA / "cell.yaml"), str(DATA / "lift.yaml")]
LARGEST = 2_000_000
"""Bytes of a report of an ordinary motion, 1.84 million of them plotly.js."""

SLOW = 60_000
"""A page drawn without a graphics card takes its time [ms]."""


@pytest.fixture(scope="module")
def result(planar_cell, lift):
    return mrts.scale(planar_cell, lift)


def show(page, path):  # noqa: F811
    """Open a report and wait until all is drawn."""
    page.goto(path.as_uri())
    assert page.problems == []
    page.wait_for_selector("body[data-ready=yes]", timeout=SLOW)


PLOTTED_LIKE_ANOTHER = {"spatial", "least speed", "infeasible load", "fixed rule", "rates"}
"""Kinds whose pages have the plots of one that is opened; their texts and figures are tested where they are made."""


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in PLOTTED_LIKE_ANOTHER])
def test_every_kind_of_result_opens_offline_with_all_its_plots(kind, planar_cell, dual_ur5, lift, tmp_path, page):  # noqa: F811
    found = result_of(kind, planar_cell, dual_ur5, lift, tmp_path)
    path = tmp_path / "report.html"
    mrts.write_report(found, path)
    assert path.stat().st_size < LARGEST
    show(page, path)
    assert page.problems == []
    assert {url.split(":")[0] for url in page.requests} <= {"file", "data", "blob"}
    assert sum(url.startswith("file") for url in page.requests) == 1
    assert page.evaluate("window.broken") is None
    plots = set(data_of(path.read_text(encoding="utf-8"))["plots"])
    expected = set() if found.origin else {"plot-c2-range"}
    robots = len(found.cell.robots)
    if found.trajectory is not None:
        expected |= {f"plot-{what}-{n}" for what in ("torque", "force", "moment", "power") for n in range(robots)}
        expected |= {"plot-energy", "plot-limit-map"}
        units = [len(set(robot.position_units)) for robot in found.cell.robots]
        whats = ("velocity", "position")
        expected |= {f"plot-{what}-{n}-{part}" for what in whats for n in range(robots) for part in range(units[n])}
        others = {name.kind for name in all_shares(found)[0]} - {"torque", "wrench", "velocity"}
        expected |= {f"plot-limits-{number}" for number in range(len(others))}
    if found.load is not None and found.load.points:
        expected.add("plot-load-study")
    if found.changes is not None:
        expected.add("plot-what-if")
    assert plots == expected
    for name in plots:
        drawn = page.locator(f"#{name} :is(.js-line, .shapelayer path, .barlayer path, .hm)").count()
        assert drawn > 0, name
        assert page.locator(f"#{name}").bounding_box()["height"] < 1200
    page.set_viewport_size(NARROW)
    for _ in range(SLOW // 200):  # the page's policy forbids what playwright would poll with
        fits = page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        if fits:
            break
        page.wait_for_timeout(200)
    assert fits
    places = re.findall(r' id="([^"]+)"', own_text(path.read_text(encoding="utf-8")))
    assert len(places) == len(set(places))
    assert set(places) >= plots | {"motion", "inputs", "player"} | ({"range"} if not found.origin else set())
    assert page.problems == []


def scene(page):  # noqa: F811
    """Pixels of the player's scene."""
    return page.locator("#player canvas").first.screenshot()


def first_arm(page):  # noqa: F811
    """Where the first arm is drawn, Shape (points, 3)."""
    x, y, z = page.evaluate(
        "['x', 'y', 'z'].map((axis) => Array.from(document.getElementById('player').data[0][axis]))"
    )
    return np.array([x, y, z]).T


def plays(result, page):  # noqa: F811
    start, seen = first_arm(page), scene(page)
    assert len(set(seen)) > 50  # something is drawn
    slider = page.locator("#frame")
    last = int(slider.get_attribute("max"))
    slider.focus()
    page.keyboard.press("End")
    page.wait_for_timeout(500)
    end = first_arm(page)
    grasp = result.motion.object.position[-1] + result.motion.object.rotation[-1] @ result.cell.robots[0].T_object_tip.p
    np.testing.assert_allclose(end[-1], grasp, atol=1e-5)
    assert scene(page) != seen
    assert "0.299 s of 0.299 s" in page.locator("#now").text_content()
    page.locator("#speed").select_option("0.02")
    page.locator("#play").click()  # from the end it starts again
    button = page.locator("#play")
    expect(button).to_have_text("Pause")
    expect(slider).to_have_value(re.compile(r"^([3-9]|[1-8]\d)$"), timeout=SLOW)
    button.click()
    expect(button).to_have_text("Play", timeout=SLOW)
    stopped = int(slider.input_value())
    assert 0 < stopped < last
    assert np.max(np.abs(first_arm(page) - start)) > 1e-3
    page.wait_for_timeout(500)
    assert int(slider.input_value()) == stopped
    page.locator("#speed").select_option("1")
    button.click()
    expect(slider).to_have_value(str(last), timeout=SLOW)
    expect(button).to_have_text("Play", timeout=SLOW)  # it stops at the end
    assert page.problems == []


def keeps_the_readers_camera_while_it_plays(page):  # noqa: F811

    def eye():
        camera = page.evaluate("document.getElementById('player')._fullLayout.scene._scene.getCamera().eye")
        return np.array([camera[axis] for axis in "xyz"])

    slider = page.locator("#frame")
    page.locator("#speed").select_option("0.01")
    page.locator("#play").click()  # from the end it starts again
    expect(slider).to_have_value(re.compile(r"^[1-9]\d?$"), timeout=SLOW)
    page.locator("#player").scroll_into_view_if_needed()
    box, before = page.locator("#player").bounding_box(), eye()
    page.mouse.move(box["x"] + 300, box["y"] + 300)
    page.mouse.down()
    page.wait_for_timeout(1000)
    held = slider.input_value()
    for step in range(5):
        page.mouse.move(box["x"] + 320 + 20 * step, box["y"] + 300)
        page.wait_for_timeout(100)
    assert slider.input_value() == held
    page.mouse.up()
    turned = eye()
    assert np.linalg.norm(turned - before) > 0.1
    expect(slider).not_to_have_value(held, timeout=SLOW)
    np.testing.assert_allclose(eye(), turned, atol=0.2)


def names_the_rows_that_bind_under_the_mouse(page):  # noqa: F811
    plot = page.locator("#plot-c2-range .nsewdrag").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    page.mouse.move(box["x"] + 0.02 * box["width"], box["y"] + box["height"] / 2)
    page.wait_for_selector("#plot-c2-range .hoverlayer .legend")
    said = page.locator("#plot-c2-range .hoverlayer").text_content()
    assert "right/elbow ↓" in said
    assert "c² ≥ 0" in said


def sends_nothing_away(page):  # noqa: F811
    """plotly's own choice of buttons has one that uploads the chart."""
    titles = page.evaluate("[...document.querySelectorAll('.modebar-btn')].map((button) => button.dataset.title)")
    assert set(titles) == {
        "Download plot as a PNG", "Zoom", "Pan", "Reset axes", "Turntable rotation", "Reset camera to default"
    }  # fmt: skip


def test_a_reader_moves_turns_and_asks_the_page(result, tmp_path, page):  # noqa: F811
    mrts.write_report(result, tmp_path / "report.html")
    show(page, tmp_path / "report.html")
    plays(result, page)
    keeps_the_readers_camera_while_it_plays(page)
    names_the_rows_that_bind_under_the_mouse(page)
    sends_nothing_away(page)


def test_the_page_loads_nothing(result):
    text = own_text(report_html(result))
    assert not re.search(r"https?://|//[a-z]|\b(src|href)=.(?!#)|@import|url\(", text)
    assert "default-src 'none'" in text


@pytest.mark.quick
def test_names_stay_text(planar_cell, lift):
    text = own_text(report_html(mrts.scale(with_awkward_names(planar_cell), lift)))
    assert text.count("</script>") == 3  # of the library, the data and our own script
    for name in (AWKWARD, *UGLY_JOINTS):
        assert name not in text
    assert "&lt;/script&gt;&lt;script&gt;window.broken=1&lt;/script&gt;" in text
    names = [trace["name"] for trace in data_of(text)["plots"]["plot-torque-0"]["data"] if trace["name"]]
    assert all("<" not in name and "$" not in name for name in names)


def test_plots_hold_the_numbers_of_the_result(dual_ur5):
    found = mrts.scale(dual_ur5, mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml"))
    plots = data_of(report_html(found))["plots"]
    for number, robot in enumerate(dual_ur5.robots):
        traces = {trace["name"]: trace for trace in plots[f"plot-torque-{number}"]["data"] if trace["name"]}
        for index, joint in enumerate(robot.joints):
            np.testing.assert_allclose(traces[joint]["y"], found.torque[robot.name][:, index], rtol=1e-5)
            np.testing.assert_allclose(traces[joint]["x"], found.trajectory.time, rtol=1e-5)
        thin = [trace["y"][0] for trace in plots[f"plot-torque-{number}"]["data"] if not trace["name"]]
        assert sorted(thin) == sorted([*robot.torque_lower, *robot.torque_upper])
    curves = {trace.get("name"): trace for trace in plots["plot-c2-range"]["data"]}
    upper = np.array([np.inf if value is None else value for value in curves["c²⁺(t)"]["y"]])
    np.testing.assert_allclose(upper, found.range.samples.upper, rtol=1e-5)
    assert plots["plot-energy"]["data"][-1]["y"][-1] == pytest.approx(found.trajectory.energy, rel=1e-5)


@pytest.mark.quick
def test_the_text_says_what_was_given_and_found(planar_cell, lift, result):
    text = report_html(result)
    for words in (
        "c² ∈ [0, 3.062]: you may play it up to 1.75 × as fast as given",
        "The given 0.5236 s become 0.2992 s",
        "0.5 kg, moments of inertia 0.0005, 0.2, 0.2 kg m²",
        "0.5236 s in 101 samples, from (1.25, 1, 0) m to (1.25, 1.5, 0) m",
        "[-80, 80] N m",
        "<td>left/elbow torque<br><span",
    ):
        assert words in text, words
    infeasible = report_html(mrts.scale(planar_cell.with_mass(24.0), lift))
    assert "50 samples from 0 s to 0.2566 s" in infeasible
    assert "these limits conflict" in infeasible
    uncertain = report_html(mrts.scale(planar_cell.with_variation(mass=(0.2, 6.0)), lift))
    assert "<td>mass 3 kg</td>" in uncertain
    slow = tuple(replace(robot, velocity_limit=np.full(3, 0.1)) for robot in planar_cell.robots)
    too_fast = replace(planar_cell, robots=slow).without_velocity_limits()
    assert "its limit is 0.1 rad/s" in report_html(mrts.scale(too_fast, lift))
    assert "nan" not in own_text(text).lower().replace("nano", "")


def test_what_is_left_over_from_larger_terms_is_shown_as_zero():
    """Of joints that hardly move: their powers and speeds are sums of terms that cancel."""
    folder = DATA.parent / "squeeze"
    found = mrts.scale(mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(folder / "lift_and_turn.yaml"))
    text = str(duty_table(found).rows)
    assert "0 / 0 W" in text
    assert not re.search(r"e-1\d|-0 ", text)


def test_a_long_motion_makes_no_long_file_and_keeps_its_extremes(planar_cell, lift, tmp_path):
    description = {
        "duration": 0.5,
        "samples": 20_000,
        "profile": "quintic",
        "start": {"xyz": lift.position[0].tolist()},
        "end": {"xyz": lift.position[-1].tolist()},
    }
    found = mrts.scale(planar_cell, mrts.sample_motion(mrts.MotionDescription.model_validate(description)))
    mrts.write_report(found, tmp_path / "report.html")
    assert (tmp_path / "report.html").stat().st_size < LARGEST
    traces = data_of((tmp_path / "report.html").read_text(encoding="utf-8"))["plots"]["plot-torque-0"]["data"]
    for index, joint in enumerate(planar_cell.robots[0].joints):
        drawn = next(trace["y"] for trace in traces if trace["name"] == joint)
        assert len(drawn) <= MOST_SAMPLES + 6
        exact = found.torque["left"][:, index]
        np.testing.assert_allclose([min(drawn), max(drawn)], [np.min(exact), np.max(exact)], rtol=1e-5)


def test_few_samples_are_all_shown():
    assert shown_samples(5).tolist() == [0, 1, 2, 3, 4]
    spike = np.zeros((10_001, 1))
    spike[5003] = 1
    assert 5003 in shown_samples(10_001, spike)


def test_the_same_result_gives_the_same_bytes(result, tmp_path):
    texts = {report_html(result)}
    for seed in ("1", "2"):
        target = tmp_path / f"{seed}.html"
        command = [sys.executable, "-m", "mrts", "scale", *FILES, "--report", str(target)]
        subprocess.run(command, check=True, env=os.environ | {"PYTHONHASHSEED": seed}, capture_output=True)
        texts.add(target.read_text(encoding="utf-8"))
    assert len(texts) == 1


def test_a_result_without_a_trajectory_is_reported_when_the_speed_is_refused(tmp_path, capsys):
    target = tmp_path / "report.html"
    assert main(["scale", *FILES, "--c2", "100", "--report", str(target)]) == 2
    assert "outside the admissible range" in capsys.readouterr().err
    assert set(data_of(target.read_text(encoding="utf-8"))["plots"]) == {"plot-c2-range"}


@pytest.mark.quick
def test_a_saved_result_is_reported(result, tmp_path, capsys):
    from mrts.output.saved_result import save_result  # noqa: PLC0415 (only this test needs it)

    save_result(result, tmp_path / "result.npz")
    target = tmp_path / "report.html"
    assert main(["report", str(tmp_path / "result.npz"), "-o", str(target)]) == 0
    assert "planar_dual_arm: feasible" in capsys.readouterr().out
    assert target.read_text(encoding="utf-8") == report_html(result)
    (tmp_path / "no.npz").write_text("nothing")
    assert main(["report", str(tmp_path / "no.npz")]) == 2
    assert "no.npz" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["scale", *FILES, "--report", "r.html"], ["report", "result.npz"]])
@pytest.mark.parametrize("package", ["plotly", "jinja2"])
def test_a_missing_package_is_named_before_any_work(arguments, package):
    done = mrts_without(package, *arguments)
    assert done.returncode == 2
    assert "pip install 'mrts[report]'" in done.stderr
    assert done.stdout == ""


def test_torques_far_beyond_their_limits_are_so_many_percent(result):
    done = result.trajectory
    beyond = replace(result, trajectory=replace(done, torque=np.full_like(done.torque, 1e30)))
    assert plotly_figure(torque_plots(beyond)[0])["data"][0]["customdata"][0] == int(1e30)


def test_a_file_that_cannot_be_written_is_refused(result, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(mrts.InputError, match="cannot be written"):
        mrts.write_report(result, tmp_path / "file" / "report.html")
