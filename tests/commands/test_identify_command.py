"""`mrts identify` as it is typed: its file and figures."""

import numpy as np
import pytest
import yaml
from command_line import mrts_command
from conftest import DATA
from motor_recordings import exact_recording, random_motors, write_recording


@pytest.mark.quick
def test_motors_are_written_with_figures(planar_cell, tmp_path):
    target, plots, motors = tmp_path / "motors.yaml", tmp_path / "plots", random_motors(6)
    table = write_recording(tmp_path / "whole.csv", *exact_recording(planar_cell, motors, rate=200))
    done = mrts_command("identify", DATA / "cell.yaml", table, "-o", target, "--plot", plots)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("planar_dual_arm: 18 of 18 parameters of the motors of left, right identified\n")
    blocks = [robot["motors"] for robot in yaml.safe_load(target.read_text())["robots"]]
    for key, values in (("coulomb", motors.coulomb), ("viscous", motors.viscous)):
        found = np.concatenate([block["friction"][key] for block in blocks])
        np.testing.assert_allclose(found, values, rtol=1e-3)
    armature = np.concatenate([block["armature"] for block in blocks])
    np.testing.assert_allclose(armature, motors.armature, rtol=2e-3)
    assert sorted(path.name for path in plots.iterdir()) == ["motors_left.png", "motors_right.png"]
