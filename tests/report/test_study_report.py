"""The report of a study: what its text, tables and plots say, without a browser."""

import re

import numpy as np
import pytest
from conftest import DATA
from found_studies import AWKWARD, drawn_study, grid_study, kinds
from report_pages import data_of, own_text

import mrts
from mrts.cli import main
from mrts.report import study_html

KINDS = kinds()


def test_names_stay_text_and_the_page_loads_nothing():
    text = own_text(study_html(KINDS["many numbers"]))
    plain = own_text(study_html(KINDS["grid"]))
    assert not re.search(r"https?://|//[a-z]|\b(src|href)=.(?!#)|@import|url\(", plain)
    assert AWKWARD not in text
    assert "&lt;img src=x onerror=window.broken=1&gt;" in text


def test_plots_hold_the_numbers_of_the_study():
    table = grid_study()
    plots = data_of(study_html(table))["plots"]
    heat = plots["plot-duration-map"]["data"][0]
    z = np.array([[np.nan if value is None else value for value in row] for row in heat["z"]])
    np.testing.assert_allclose(z, table.duration.reshape(12, 9).T, rtol=1e-5)
    assert f"variant {table.ranked[0]}: " in "".join(text for row in heat["text"] for text in row)
    assert sum(text.startswith("unreachable") for row in heat["text"] for text in row) == 27
    drawn = drawn_study(600, 4)
    curve = data_of(study_html(drawn))["plots"]["plot-durations"]["data"][0]
    assert curve["y"][-1] == pytest.approx(100 * len(drawn.ranked) / 600, rel=1e-5)
    assert curve["x"][0] == pytest.approx(np.nanmin(drawn.duration), rel=1e-5)


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
    assert "object.mass: 0.5, 3, 300 kg" in text
    for part in (tmp_path / "found").glob("rows/*.parquet"):
        part.unlink()
    assert main(["report", str(tmp_path / "found")]) == 2
    assert "no variant of this study is solved yet" in capsys.readouterr().err
