"""`mrts scale --profile smooth` and `--rates`: what the options say, which go together, the files, a terminal."""

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
    assert said.startswith("planar_dual_arm: the smooth timing takes 0.331")
    assert "It is a local optimum" in said


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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--rates", "0"], "--rates = 0.0: must be 'cell', or a number > 0"),
        (["--profile", "smooth"], "--rates: the cell 'planar_dual_arm' limits no rate."),
        (
            ["--profile", "optimal", "--rates", "cell"],
            "--rates: does not go with --profile optimal.",
        ),
        (["--rates", "cell"], "--rates: the cell 'planar_dual_arm' limits no rate"),
        (["--rates", "nan"], "--rates = 'nan'"),
        (["--rates", "3", "--formulation", "torque"], "--formulation = 'torque': with rates it must be"),
        (["--weigh", "time=1"], "--weigh: does not go with --profile constant."),
        (["--profile", "optimal", "--solver", "kernel"], "--solver: does not go with --profile"),
        ([*SMOOTH[3:], "--distribute", "reserve"], "--distribute = 'reserve': with rates it must be"),
        (["--c2", "1", "--nominal"], "--c2: does not go with --nominal."),
        (["--weights", "1", "--share", "equal"], "--weights: does not go with --share"),
        ([*SMOOTH[3:], "--weigh", "tim=1"], "--weigh = 'tim': may have the keys time and energy only."),
        ([*SMOOTH[3:], "--weigh", "time=1", "--least-energy-in", "1"], "--weigh: does not go with least_energy_in"),
        (
            [*SMOOTH[3:], "--end-torque", "left=1,2,3"],
            "--end-torque = ['left=1,2,3']: must be given once for every robot: ",
        ),
        (
            [*SMOOTH[3:], "--end-torque", "left=1,2", "--end-torque", "right=1,2,3"],
            "--end-torque = [1.0, 2.0]: must be 3 numbers for the robot",
        ),
    ],
)
def test_options_that_make_no_sense_are_told_by_name(options, message, capsys):
    assert main(["scale", CELL, LIFT, *options]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(f"mrts: error: {message}")
