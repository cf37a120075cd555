"""`mrts identify` as it is typed: files, figures, warnings, exit codes, and what it refuses."""

import numpy as np
import pytest
import yaml
from command_line import mrts_command
from conftest import DATA
from motor_recordings import exact_recording, random_motors, write_recording

CELL = str(DATA / "cell.yaml")


@pytest.fixture(scope="module")
def tables(planar_cell, tmp_path_factory):
    """Recordings of both arms: whole, with a left elbow that stands still, of nothing that moves, with mistakes."""
    folder = tmp_path_factory.mktemp("recordings")
    motors = random_motors(6)
    for name, still in (("whole", ()), ("still", (1,)), ("rest", range(6))):
        recorded = exact_recording(planar_cell, motors, rate=200, still=still)
        write_recording(folder / f"{name}.csv", *recorded)
    joints, time, q, effort = exact_recording(planar_cell, motors, rate=200)
    write_recording(folder / "right.csv", joints[3:], time, q[:, 3:], effort[:, 3:])
    write_recording(folder / "constant.csv", joints, time, q, np.where(np.arange(6) == 4, 1.5, effort))
    write_recording(folder / "short.csv", joints, time[:100], q[:100], effort[:100])
    write_recording(folder / "renamed.csv", [f"arm/joint_{k}" for k in range(6)], time, q, effort)
    text = (folder / "whole.csv").read_text().splitlines()
    text[3] = text[3].replace(text[3].split(",")[1], "nan")
    (folder / "nan.csv").write_text("\n".join(text))
    (folder / "no_effort.csv").write_text("\n".join(",".join(line.split(",")[:7]) for line in text[:3]))
    return folder


@pytest.mark.quick
def test_motors_are_written_with_figures(tables, tmp_path):
    target, plots = tmp_path / "motors.yaml", tmp_path / "plots"
    done = mrts_command("identify", CELL, tables / "whole.csv", "-o", target, "--plot", plots)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("planar_dual_arm: 18 of 18 parameters of the motors of left, right identified\n")
    motors = random_motors(6)
    blocks = [robot["motors"] for robot in yaml.safe_load(target.read_text())["robots"]]
    for key, values in (("coulomb", motors.coulomb), ("viscous", motors.viscous)):
        found = np.concatenate([block["friction"][key] for block in blocks])
        np.testing.assert_allclose(found, values, rtol=1e-3)
    armature = np.concatenate([block["armature"] for block in blocks])
    np.testing.assert_allclose(armature, motors.armature, rtol=2e-3)
    assert sorted(path.name for path in plots.iterdir()) == ["motors_left.png", "motors_right.png"]
