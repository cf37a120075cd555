"""The ROS 2 controller of docs/ros2.md, against stand-ins of what it uses, with the library of `mrts export`."""

import shutil
import subprocess

import numpy as np
import pytest
from command_line import mrts_command
from conftest import ROOT
from page_runner import BLOCK
from shipped_cells import DATA

import mrts

STUBS = ROOT / "tests" / "helpers" / "ros2_stubs"

SAME = 1e-9
"""Share of a torque by which the exported one differs: rounding, and another compiler's order of sums."""


@pytest.mark.slow
def test_it_plays_the_plan_from_its_start_to_its_end(turned, tmp_path):
    mrts.save_result(turned, tmp_path / "plan.npz")
    cell, library = DATA / "dual_ur5" / "cell.yaml", tmp_path / "library"
    done = mrts_command("export", cell, "--plan", tmp_path / "plan.npz", "-o", library, "--functions", "override")
    assert done.returncode == 0, done.stderr
    page = (ROOT / "docs" / "ros2.md").read_text(encoding="utf-8")
    (code,) = (code for _, title, code in BLOCK.findall(page) if title == "override_controller.cpp")
    assert code.count("\n") < 120
    (tmp_path / "override_controller.cpp").write_text(code, encoding="utf-8")
    subprocess.run([shutil.which("make"), "-s", "-C", library], check=True, capture_output=True)
    checks = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    folders = [f"-I{folder}" for folder in (library / "include", STUBS, tmp_path)]
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
