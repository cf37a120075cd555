"""`mrts scale --profile smooth` and `--rates` say and write what the library finds."""

import json

import numpy as np
import pytest
from conftest import DATA
from shipped_cells import cell_file, shipped

import mrts
from mrts.cli import main

CELL, LIFT = str(DATA / "cell.yaml"), str(DATA / "lift.yaml")
SMOOTH = ("scale", CELL, LIFT, "--profile", "smooth", "--rates", "11.5")


@pytest.fixture(scope="module")
def rated(tmp_path_factory):
    """The shipped cell with torque rates in its file."""
    motors = {"torque_rate": [1150, 920, 575]}
    return str(cell_file(tmp_path_factory.mktemp("rated"), shipped(motors=motors)))


def answered(capsys, *words):
    assert main([*words, "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.quick
def test_the_smooth_profile_is_that_of_the_library(planar_cell, lift, tmp_path, capsys):
    table, saved = tmp_path / "smooth.csv", tmp_path / "smooth.npz"
    found = mrts.retime(planar_cell, lift, rates=11.5)
    output = answered(capsys, *SMOOTH, "--csv", str(table), "--save", str(saved))
    assert output == found.to_json()
    assert output["smooth"]["bound"] < output["duration"]
    rows = np.genfromtxt(table, delimiter=",", names=True, deletechars="")
    assert rows["t"][-1] == pytest.approx(found.duration, abs=2e-3)  # and a row at rest
    assert mrts.load_result(saved).to_json() == output
    assert main([*SMOOTH]) == 0
    said = capsys.readouterr().out
    assert said.startswith("planar_dual_arm: the smooth timing takes 0.335")
    assert "It takes 1 % longer than a local optimum" in said


@pytest.mark.quick
def test_rates_of_the_cell_file_need_no_number(rated, capsys):
    duration = answered(capsys, *SMOOTH)["duration"]
    for words in ((), ("--rates", "cell")):
        found = answered(capsys, "scale", rated, LIFT, "--profile", "smooth", *words)
        assert found["duration"] == pytest.approx(duration), words


@pytest.mark.quick
def test_the_constant_factor_keeps_rates_too(capsys):
    free, kept = answered(capsys, "scale", CELL, LIFT), answered(capsys, "scale", CELL, LIFT, "--rates", "3")
    assert kept["c2"]["upper"] < free["c2"]["upper"]


def test_energy_is_weighed_or_least_within_a_duration(capsys):
    weighed = answered(capsys, *SMOOTH, "--weights", "1", "--weigh", "time=1,energy=1e-4")
    assert weighed["smooth"]["goal"] == {"time": 1.0, "energy": 1e-4, "longest": None}
    within = answered(capsys, *SMOOTH, "--least-energy-in", "0.4")
    assert within["duration"] == pytest.approx(0.4, rel=1e-6)
    assert main([*SMOOTH, "--least-energy-in", "0.1"]) == 1
    assert capsys.readouterr().out.startswith("planar_dual_arm: duration too short: the motion cannot be done in 0.1 s")
