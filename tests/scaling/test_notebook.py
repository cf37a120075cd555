"""What a notebook or an interpreter shows of the objects that a user holds: short, and never an array."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from cell_bank import random_spatial_cell
from shown_results import renamed

import mrts

LONGEST = 2000
"""Characters of any of them; the longest says why a motion is infeasible."""


@pytest.fixture(scope="module")
def results(planar_cell, lift):
    box = planar_cell.with_variation(mass=(0.2, 6.0))
    here, rest = 0 * lift.position + lift.position[0], 0 * lift.twist
    still = mrts.ObjectMotion(lift.time, here, lift.rotation, rest, rest)
    return {
        "feasible": mrts.scale(planar_cell, lift),
        "uncertain": mrts.scale(box, lift),
        "possible": mrts.scale(box, lift, load="possible"),
        "infeasible": mrts.scale(planar_cell.with_variation(mass=(0.2, 200.0)), lift),
        "unbounded": mrts.scale(planar_cell, still),
    }


def test_nothing_shows_an_array(results):
    for result in results.values():
        held = [result, result.cell, result.cell.robots[0], result.motion, result.motion.object, result.range]
        for value in [*held, result.trajectory, result.load]:
            text = repr(value)
            assert "array(" not in text
            assert "nan" not in text.lower().replace("nominal", "")
            assert len(text) < LONGEST, text
        assert result.sentence() in repr(result)


def test_they_say_what_matters(results, planar_cell, lift):
    assert repr(planar_cell) == "<Cell 'planar_dual_arm': left (3 joints), right (3 joints); xy; load 0.5 kg>"
    assert repr(results["uncertain"].cell).endswith("load mass 0.1 … 3 kg>")
    assert repr(lift) == "<ObjectMotion: 101 samples in 0.5236 s>"
    found = results["feasible"]
    assert repr(found).endswith("Chosen: c² = 3.062, 0.2992 s.>")
    assert repr(found.motion) == "<CoordinatedMotion: 101 samples in 0.5236 s, 6 joints>"
    assert repr(found.range) == "<ScalingRange feasible: c² ∈ [0, 3.062], 101 samples>"
    assert repr(found.trajectory) == "<ScaledTrajectory: 101 samples in 0.2992 s, c² = 3.062>"
    assert repr(results["infeasible"].range) == "<ScalingRange infeasible: 101 samples>"
    assert repr(results["unbounded"].range) == "<ScalingRange unbounded: c² ∈ [0, ∞), 101 samples>"


def table(result):
    """Rows of the HTML table, parsed as XML."""
    html = ET.fromstring(result._repr_html_())  # noqa: S314 (our own text; notebooks' protocol)
    return {row.find("th").text: row.find("td").text for row in html.find("table")}, html.find("p").text


def test_the_table_has_outcome_range_speed_and_margins(results):
    rows, said = table(results["feasible"])
    assert said.endswith(results["feasible"].summary())
    assert (rows["outcome"], rows["range of c²"], rows["chosen c²"]) == ("feasible", "[0, 3.062]", "3.062")
    assert rows["left/elbow"] == "margin 0 N m, limits [-80, 80] N m"
    shoulder = np.max(np.abs(results["feasible"].torque["left"][:, 0]))
    assert rows["left/shoulder"] == f"margin {100 - shoulder:.3g} N m, limits [-100, 100] N m"
    assert table(results["infeasible"])[0] == {"outcome": "infeasible"}
    assert set(table(results["possible"])[0]) == {"outcome", "range of c²"}
    assert table(results["unbounded"])[0]["range of c²"] == "[0, ∞)"


def test_sliding_joints_have_forces_and_names_are_escaped(tmp_path):
    case = random_spatial_cell(np.random.default_rng(2), tmp_path, 1)
    result = mrts.scale(case.cell, case.motion)
    rows = table(result)[0]
    assert rows["arm0/j2"].endswith("] N")
    assert rows["arm0/j1"].endswith("] N m")
    joints = ("<script>alert('&')</script>", *result.cell.robots[0].joints[1:])
    spiteful = replace(result, cell=renamed(result.cell, "arm", ("arm0",), joints))
    assert "<script>" not in spiteful._repr_html_()
    assert "arm0/<script>alert('&')</script>" in table(spiteful)[0]
