"""The report of a study: what its text, tables and plots say, without a browser."""

import re

from conftest import DATA
from found_studies import AWKWARD, kinds
from report_pages import own_text

import mrts
from mrts.cli import main
from mrts.report import report_html

KINDS = kinds()


def test_names_stay_text_and_the_page_loads_nothing():
    text = own_text(report_html(KINDS["many numbers"]))
    plain = own_text(report_html(KINDS["grid"]))
    assert not re.search(r"https?://|//[a-z]|\b(src|href)=.(?!#)|@import|url\(", plain)
    assert AWKWARD not in text
    assert "&lt;img src=x onerror=window.broken=1&gt;" in text


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
