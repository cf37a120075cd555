"""What is said of a motion before its range is trusted, and that it is said wherever the result is."""

import json
from dataclasses import replace

import numpy as np
import pytest
from motion_tables import QUATERNION_NAMES, write_table

import mrts
from mrts.base.errors import Remark
from mrts.motion.object_courses import PROFILES, spline_motion
from mrts.output.report_page import report_html

pytestmark = pytest.mark.quick

SAID = Remark("told-by-a-test", "the <cell> says something.", 3)


def codes(result):
    return [warning.code for warning in result.warnings]


def straight_lift(profile="quintic", duration=1.0, samples=101):
    ends = {"start": {"xyz": [1.25, 1.0, 0.0]}, "end": {"xyz": [1.25, 1.5, 0.0]}}
    return mrts.load_motion({"duration": duration, "samples": samples, "profile": profile, **ends})


def table(path, time, heights):
    """A table of poses of the lift."""
    values = np.broadcast_arrays(np.round(time, 9), 1.25, heights, 0, 0, 0, 0, 1)
    return mrts.load_motion(write_table(path, dict(zip(["t", *QUATERNION_NAMES], values, strict=True)), ".17g"))


@pytest.mark.parametrize("samples", [11, 21, 25, 101, 400])
@pytest.mark.parametrize("profile", PROFILES)
def test_motions_from_rest_to_rest_are_not_warned_of(planar_cell, profile, samples):
    assert codes(mrts.scale(planar_cell, straight_lift(profile, samples=samples))) == []


@pytest.mark.parametrize(
    ("samples", "noise", "said"), [(101, 3e-5, True), (101, 3e-9, False), (301, 3e-6, True), (301, 3e-8, False)]
)
@pytest.mark.parametrize("between", [1, 10])
def test_noise_that_sets_the_range(planar_cell, tmp_path, samples, noise, said, between):
    smooth = straight_lift(samples=samples)
    unturned = np.tile([0.0, 0.0, 0.0, 1.0], (samples, 1))
    heights = smooth.position[:, 1] + noise * np.random.default_rng(5).normal(size=samples)
    motion = table(tmp_path / "lift.csv", smooth.time, heights)
    if between > 1:
        at = np.linspace(0, motion.time[-1], between * (samples - 1) + 1)
        motion = spline_motion(motion.time, motion.position, unturned, at)
    clean = spline_motion(smooth.time, smooth.position, unturned, motion.time)
    result, true = mrts.scale(planar_cell, motion), mrts.scale(planar_cell, clean)
    assert set(codes(result)) - {"not-at-rest"} == ({"noise"} if said else set())
    off = abs(result.range.upper.c2 / true.range.upper.c2 - 1)
    assert off > 0.2 if said else off < 0.02


def test_a_row_out_of_line_is_a_jump(planar_cell, tmp_path):
    smooth = straight_lift()
    heights = np.where(np.arange(101) == 40, 0.01, 0.0) + smooth.position[:, 1]
    result = mrts.scale(planar_cell, table(tmp_path / "lift.csv", smooth.time, heights), between=None)
    (jump,) = [warning for warning in result.warnings if warning.code == "jump"]
    assert jump.sample in {39, 40, 41}


def test_a_warning_is_wherever_the_result_is(planar_cell, lift, tmp_path):
    cell = replace(planar_cell, remarks=(SAID,))
    result = mrts.scale(cell, lift)
    assert result.warnings == (SAID,)
    assert result.summary().splitlines() == [result.sentence(), f"warning: {SAID.text}"]
    assert result.to_json()["warnings"] == [{"code": SAID.code, "severity": "warning", "text": SAID.text, "sample": 3}]
    assert "the &lt;cell&gt; says something." in report_html(result)
    mrts.save_result(result, tmp_path / "result.npz")
    again = mrts.load_result(tmp_path / "result.npz")
    assert again.warnings == (SAID,)
    assert again.json_text() == result.json_text()
    timed = mrts.retime(cell, lift)
    assert timed.warnings == timed.retimed.warnings == (SAID,)
    assert json.loads(timed.json_text())["warnings"] == result.to_json()["warnings"]
