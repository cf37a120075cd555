"""`mrts view` without a page: pictures of motions, saved results and variants."""

import shutil

import numpy as np
import pytest
from conftest import DATA
from PIL import Image

import mrts
from mrts.cli import main
from mrts.scene import film

CELL, LIFT = str(DATA / "cell.yaml"), str(DATA / "lift.yaml")

STUDY = """\
cell: cell.yaml
motion: lift.yaml
vary:
  object.mass: [1.0, 2.0, 4.0]
"""


def drawn(monkeypatch):
    """What is asked to be drawn, in place of drawing it."""
    asked = []
    monkeypatch.setattr(film, "write_picture", lambda clips, path, at, **_: asked.append((clips, path, at)))
    return asked


def test_a_picture_and_a_film_of_sides(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(film, "suited_pace", lambda _duration: 1.0)
    picture, video = tmp_path / "lift.png", tmp_path / "lift.gif"
    assert main(["view", CELL, LIFT, "--png", str(picture), "--at", "0.1", "--video", str(video)]) == 0
    assert str(picture) in capsys.readouterr().out
    with Image.open(picture) as still, Image.open(video) as moving:
        assert still.size == moving.size
        assert moving.n_frames > 3


def test_sides_are_what_scale_and_retime_find(planar_cell, lift, monkeypatch, tmp_path):
    asked = drawn(monkeypatch)
    sides = "given,fastest,optimal,smooth"
    command = ["view", CELL, LIFT, "--png", str(tmp_path / "x.png"), "--side-by-side", sides, "--rates", "20"]
    assert main(command) == 0
    ((clips, path, at),) = asked
    assert path == tmp_path / "x.png"
    given, fastest, optimal, smooth = (clip.trajectory for clip in clips)
    assert given.c2 == 1
    assert fastest.c2 == pytest.approx(mrts.scale(planar_cell, lift).range.upper.c2)
    assert optimal.duration == pytest.approx(mrts.retime(planar_cell, lift).duration)
    assert smooth.duration == pytest.approx(mrts.retime(planar_cell, lift, rates=20.0).duration, rel=1e-6)
    assert at == given.duration / 2
    assert [clip.title.split(" ")[0] for clip in clips] == ["as", "constant", "fastest", "smooth"]


def test_a_saved_result_clips_no_compiler(lifted, monkeypatch, tmp_path):
    asked = drawn(monkeypatch)
    mrts.save_result(lifted, tmp_path / "fast.npz")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    fast = str(tmp_path / "fast.npz")
    assert main(["view", fast, "--png", str(tmp_path / "x.png"), "--with", fast]) == 0
    first, second = asked[0][0]
    assert first.title == second.title == "fast"
    np.testing.assert_array_equal(first.trajectory.torque, lifted.trajectory.torque)


@pytest.mark.parametrize("named", ["study.yaml", "swept"])
def test_a_variant_is_that_of_the_study(named, monkeypatch, tmp_path, capsys):
    for name in ("cell.yaml", "lift.yaml", "planar_arm.urdf"):
        shutil.copy(DATA / name, tmp_path)
    (tmp_path / "study.yaml").write_text(STUDY, encoding="utf-8")
    if named == "swept":
        assert main(["sweep", str(tmp_path / "study.yaml"), "-o", str(tmp_path / "swept"), "-q"]) == 0
    asked = drawn(monkeypatch)
    path = str(tmp_path / named)
    assert main(["view", path, "--variant", "2", "--png", str(tmp_path / "x.png")]) == 0
    ((clip,), _, _) = asked[0]
    assert clip.trajectory.cell.mass == 4.0
    capsys.readouterr()
    assert main(["view", path, "--variant", "3", "--png", str(tmp_path / "x.png")]) == 2
    assert f"{path}: --variant = 3" in capsys.readouterr().err
    if named == "swept":
        assert main(["view", path, "--png", str(tmp_path / "x.png")]) == 2
        (tmp_path / "study.yaml").write_text(STUDY.replace("4.0", "5.0"), encoding="utf-8")
        assert main(["view", path, "--variant", "2", "--png", str(tmp_path / "x.png")]) == 2
