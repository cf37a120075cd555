"""The report of a study: one page that opens offline, in a real browser."""

import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from found_studies import AWKWARD, drawn_study, found_study, grid_study, kinds
from headless_browser import NARROW, browser, page  # noqa: F401 (fixtures)
from report_pages import data_of, own_text

import mrts
from mrts.cli import main
from mrts.plots.study_plots import NO_DURATION
from mrts.plots.study_words import best_rows
from mrts.report import report_html, study_html, write_study_report

KINDS = kinds()

SLOW = 60_000
"""A page drawn without a graphics card takes its time [ms]."""

LARGEST = 2_100_000
"""Bytes of a report, 1.84 million of them plotly.js."""


@pytest.mark.parametrize("name", ["grid", "four numbers", "one number", "many numbers", "nothing can be played"])
def test_every_kind_of_study_opens_offline_with_all_its_plots(name, tmp_path, page):  # noqa: F811
    table = KINDS[name]
    path = tmp_path / "report.html"
    write_study_report(table, path)
    text = path.read_text(encoding="utf-8")
    assert len(text) < LARGEST
    page.set_viewport_size(NARROW)
    page.goto(path.as_uri())
    page.wait_for_selector("body[data-ready=yes]", timeout=SLOW)
    assert page.problems == []
    assert page.evaluate("window.broken") is None
    assert {url.split(":")[0] for url in page.requests} <= {"file", "data", "blob"}
    assert sum(url.startswith("file") for url in page.requests) == 1
    plots = set(data_of(text)["plots"])
    expected = {"plot-duration-line"} if len(table.knobs) == 1 else {"plot-duration-map", "plot-limit-map"}
    expected |= {"plot-lines"} if len(table.knobs) > 2 else set()
    expected |= {"plot-durations"} if len(table.ranked) else set()
    assert plots == expected
    for plot in plots:
        assert page.locator(f"#{plot} svg.main-svg").count() > 0, plot
        assert page.locator(f"#{plot}").bounding_box()["height"] < 1200
    if "plot-lines" in plots:
        assert page.locator("#plot-lines canvas").count() > 0
        assert len(set(page.locator("#plot-lines").screenshot())) > 50  # something is drawn
        assert "webgl" not in page.locator("#plot-lines").inner_text().lower()
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    places = re.findall(r' id="([^"]+)"', own_text(text))
    assert len(places) == len(set(places))
    assert "nan" not in re.findall(r"\w+", own_text(text).lower())


def test_only_a_page_with_parallel_coordinates_may_compile(planar_cell, lift):
    """plotly compiles what draws them; nothing else on the page does, and nothing is fetched either way."""
    with_lines, without = study_html(KINDS["four numbers"]), study_html(KINDS["grid"])
    result = report_html(mrts.scale(planar_cell, lift))
    for text in (with_lines, without, result):
        assert "default-src 'none'" in text
        assert not re.search(r"https?://|//[a-z]|\b(src|href)=.(?!#)|@import|url\(", own_text(text))
    assert ["'unsafe-eval'" in own_text(text) for text in (with_lines, without, result)] == [True, False, False]


def test_names_stay_text():
    text = own_text(study_html(KINDS["many numbers"]))
    assert AWKWARD not in text
    assert "&lt;img src=x onerror=window.broken=1&gt;" in text


def test_no_line_of_the_best_variants_begins_with_an_arrow():
    text = own_text(study_html(grid_study()))
    table = text[text.index('id="best"') : text.index('id="map"')]
    assert re.search(r">[^<>]* [↑↓]<", table)
    assert not re.search(r"[↑↓]", re.sub(r'<span class="whole">[^<]*</span>', "", table))


def test_plots_hold_the_numbers_of_the_study():
    table = grid_study()
    plots = data_of(study_html(table))["plots"]
    heat = plots["plot-duration-map"]["data"][0]
    z = np.array([[np.nan if value is None else value for value in row] for row in heat["z"]])
    np.testing.assert_allclose(z, table.duration.reshape(12, 9).T, rtol=1e-5)
    assert f"variant {table.ranked[0]}: " in "".join(text for row in heat["text"] for text in row)
    assert sum(text.startswith("unreachable") for row in heat["text"] for text in row) == 27
    drawn = drawn_study(600, 4)
    trace = data_of(study_html(drawn))["plots"]["plot-lines"]["data"][0]
    assert [axis["label"] for axis in trace["dimensions"]] == [*(f"knob {k} [m]" for k in range(4)), "duration [s]"]
    lengths = {len(axis["values"]) for axis in trace["dimensions"]} | {len(trace["line"]["color"])}
    assert len(lengths) == 1
    none = np.array(trace["dimensions"][-1]["values"]) == NO_DURATION
    assert none.tolist() == [kind == 0 for kind in trace["line"]["color"]]
    curve = data_of(study_html(drawn))["plots"]["plot-durations"]["data"][0]
    assert curve["y"][-1] == pytest.approx(100 * len(drawn.ranked) / 600, rel=1e-5)
    assert curve["x"][0] == pytest.approx(np.nanmin(drawn.duration), rel=1e-5)


def test_the_text_says_what_became_of_the_variants():
    table = grid_study()
    text = own_text(study_html(table))
    count = len(table.ranked)
    for words in (
        f"{count} of 108 variants may be played",
        "<td>unreachable</td><td>the arms cannot follow the object</td><td>27</td><td>25 %</td>",
        "knob 1 is at the lower end of what was tried",
        "<td>left/fx ↓</td>",
        "no way",
        "no duration suits",
    ):
        assert words in text, words
    nothing = study_html(KINDS["nothing can be played"])
    assert "no variant has a shortest duration" in nothing.lower()
    assert 'class="outcome infeasible"' in nothing


def test_a_long_study_makes_no_long_page():
    text = study_html(drawn_study(100_000, 5))
    assert len(text) < 8_000_000
    assert "An even choice of 600 of 100000 variants" in text


def test_the_same_study_gives_the_same_text():
    assert study_html(drawn_study(300, 4)) == study_html(drawn_study(300, 4))


def test_durations_far_apart_are_told_apart():
    values = np.linspace(0, 1, 100)[:, None]
    duration = np.concatenate([np.linspace(0.3, 0.5, 90), np.full(10, 40.0)])
    table = found_study(np.hstack([values, values[::-1]]), duration)
    plots = data_of(study_html(table))["plots"]
    assert plots["plot-durations"]["layout"]["xaxis"]["type"] == "log"
    assert plots["plot-duration-map"]["data"][0]["zmax"] < 1


def test_a_folder_of_a_study_is_reported(tmp_path, capsys):
    study = tmp_path / "study.yaml"
    files = f"cell: {DATA / 'cell.yaml'}\nmotion: {DATA / 'lift.yaml'}"
    study.write_text(f"{files}\nvary:\n  object.mass: [0.5, 3, 300]\n", encoding="utf-8")
    found = mrts.sweep(study, tmp_path / "found", workers=1).to_pandas()
    target = tmp_path / "report.html"
    assert main(["report", str(tmp_path / "found"), "-o", str(target)]) == 0
    assert "planar_dual_arm: 2 of 3 variants may be played (66.6 %); 1 infeasible" in capsys.readouterr().out
    text = target.read_text(encoding="utf-8")
    assert f"{found.duration.min():.4g} s" in text
    assert "<td>object.mass</td><td>0.5</td><td>300</td><td>kg</td>" in text
    assert main(["report", str(tmp_path)]) == 2
    assert "holds no study" in capsys.readouterr().err
    for part in (tmp_path / "found").glob("rows/*.parquet"):
        part.unlink()
    assert main(["report", str(tmp_path / "found")]) == 2
    assert "no variant of this study is solved yet" in capsys.readouterr().err


def test_a_speed_that_varies_where_no_constant_one_is_possible_has_no_c2():
    """As of a least and a largest speed at two moments that exclude each other."""
    values = np.linspace(0, 1, 60).reshape(-1, 3)
    table = found_study(values, np.linspace(0.3, 0.6, 20))
    table = replace(table, rows=table.rows.assign(c2_upper=np.nan))
    text = own_text(study_html(table))
    assert "nan" not in re.findall(r"\w+", text.lower())
    assert "variant 0: 0.3 s, limited by right/elbow ↑" in text
    head, rows = best_rows(table, 3)
    assert [row[head.index("c²⁺ [1]")] for row in rows] == ["", "", "", ""]
