"""`mrts view` without a page: pictures of motions and saved results."""

import numpy as np
import pytest
from conftest import DATA

import mrts
from mrts.cli import main
from mrts.scene import film

CELL, LIFT = str(DATA / "cell.yaml"), str(DATA / "lift.yaml")


def drawn(monkeypatch):
    """What is asked to be drawn, in place of drawing it."""
    asked = []
    monkeypatch.setattr(film, "write_picture", lambda clips, path, at, **_: asked.append((clips, path, at)))
    return asked


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
    assert main(["view", fast, "--png", str(tmp_path / "x.png")]) == 0
    (clip,) = asked[0][0]
    assert clip.title == "c² = 3.062"
    np.testing.assert_array_equal(clip.trajectory.torque, lifted.trajectory.torque)
