"""`mrts scale --what-if`: the table and the files."""

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
