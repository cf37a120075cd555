"""`mrts scale --what-if`: the table, what it goes with, files."""

import json

import pytest
from conftest import DATA

import mrts
from mrts.cli import main

CELL, LIFT = str(DATA / "cell.yaml"), str(DATA / "lift.yaml")
SCALE = ("scale", CELL, LIFT, "--what-if")


def answered(capsys, *words):
    assert main([*SCALE, *words, "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.quick
def test_it_says_and_writes_what_the_library_finds(planar_cell, lift, tmp_path, capsys):
    found = mrts.scale(planar_cell, lift).what_if()
    assert main([*SCALE, "--save", str(tmp_path / "a.npz"), "--report", str(tmp_path / "a.html")]) == 0
    said = capsys.readouterr().out
    written = "".join(f"  {tmp_path / name}\n" for name in ("a.npz", "a.html"))
    assert said.endswith(f"\n\n{found}\n\nwritten:\n{written}")
    assert answered(capsys)["what_if"] == found.to_json()
    assert mrts.load_result(tmp_path / "a.npz").changes == found
    assert "What changes would do" in (tmp_path / "a.html").read_text(encoding="utf-8")
    assert main(["report", str(tmp_path / "a.npz"), "-o", str(tmp_path / "b.html")]) == 0
    assert (tmp_path / "b.html").read_bytes() == (tmp_path / "a.html").read_bytes()


def test_it_goes_with_other_questions(planar_cell, lift, tmp_path, capsys):
    assert answered(capsys, "--share", "0.6,0.4", "--reserve", "0.1")["what_if"] == (
        mrts.scale(planar_cell, lift, sharing=mrts.LoadSharing([0.6, 0.4]), reserve=0.1).what_if().to_json()
    )
    own = mrts.scale(planar_cell, lift).what_if(solver="qpsol:qpoases").to_json()
    assert answered(capsys, "--solver", "qpsol:qpoases")["what_if"] == own
    timing = answered(capsys, "--profile", "optimal", "--save", str(tmp_path / "a.npz"))["what_if"]
    found = mrts.retime(planar_cell, lift).what_if()
    assert timing == found.to_json()
    assert timing["before"]["c2_upper"] is None
    assert mrts.load_result(tmp_path / "a.npz").changes == found
    assert main([*SCALE, "--profile", "optimal"]) == 0
    assert str(found) in capsys.readouterr().out
