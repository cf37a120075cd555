"""What a notebook or an interpreter shows of the objects that a user holds: short, and never an array."""

import xml.etree.ElementTree as ET

import pytest

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


def shown(result):
    """Tables of the HTML by their first title, each as rows by name, parsed as XML; and the first paragraph."""
    html = ET.fromstring(result._repr_html_())  # noqa: S314 (our own text; notebooks' protocol)
    tables = {}
    for each in html.findall("table"):
        rows = [["".join(cell.itertext()) for cell in row] for row in each]
        tables[rows[0][0] if len(each[0].findall("th")) > 1 else ""] = {row[0]: row[1:] for row in rows}
    return tables, html.find("p").text


def test_the_tables_have_outcome_range_speed_and_what_is_made_of_each_limit(results):
    tables, said = shown(results["feasible"])
    assert said.endswith(results["feasible"].summary())
    assert [tables[""][key] for key in ("outcome", "range of c²", "chosen c²")] == [
        ["feasible"],
        ["[0, 3.062]"],
        ["3.062"],
    ]
    assert tables["torque"]["left/elbow"][2:] == ["100 %", "[-80, 80] N m, binds"]
    for result in results.values():
        assert ("torque" in shown(result)[0]) == (result.trajectory is not None)
    assert shown(results["infeasible"])[0] == {"": {"outcome": ["infeasible"]}}
    assert set(shown(results["possible"])[0][""]) == {"outcome", "range of c²"}
    assert shown(results["unbounded"])[0][""]["range of c²"] == ["[0, ∞)"]
