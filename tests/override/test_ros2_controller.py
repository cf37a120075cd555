"""The ROS 2 controller docs/override_controller.cpp, against stand-ins of what it uses."""

import shutil
import subprocess

import numpy as np
import pytest
from command_line import mrts_command
from conftest import ROOT
from shipped_cells import DATA

import mrts

STUBS = ROOT / "tests" / "helpers" / "ros2_stubs"

SAME = 1e-9
"""Share of a torque by which the exported one differs: rounding, and another compiler's order of sums."""


@pytest.mark.slow
def test_it_plays_the_plan_from_its_start_to_its_end(turned, tmp_path):
    mrts.save_result(turned, tmp_path / "plan.npz")
    cell, library = DATA / "dual_ur5" / "cell.yaml", tmp_path / "library"
    done = mrts_command("export", cell, "--plan", tmp_path / "plan.npz", "-o", library)
    assert done.returncode == 0, done.stderr
    subprocess.run([shutil.which("make"), "-s", "-C", library], check=True, capture_output=True)
    checks = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    folders = [f"-I{folder}" for folder in (library / "include", STUBS, ROOT / "docs")]
    built = [
        shutil.which("g++"),
        *checks,
        *folders,
        STUBS / "play.cpp",
        *library.glob("build/*.a"),
        "-lm",
        "-o",
        tmp_path / "play",
    ]
    subprocess.run(built, check=True)
    said = subprocess.run([tmp_path / "play"], check=True, capture_output=True, text=True).stdout
    rest = mrts.SpeedOverride(turned).start(turned.duration).torque[:2]
    np.testing.assert_allclose(np.array(said.split(), dtype=float), rest, rtol=SAME)
