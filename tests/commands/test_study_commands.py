"""`mrts sweep` and `mrts place` as a user runs them: answers, files, exit codes, and what is refused."""

import re

import pytest
import yaml
from command_line import mrts_command
from conftest import DATA
from shipped_cells import shipped
from study_files import planar_study, write_study
from sweep_processes import driver_command
from terminal_session import at_terminal

import mrts
from mrts.cli import main

VARY = 'vary: {object.mass: [1, 24, 2], "robots.left.base.xyz[0]": [0, -2]}'


def study_file(folder, text=VARY):
    return planar_study(folder, text).path


@pytest.mark.quick
def test_a_study_is_solved_said_and_written(tmp_path):
    done = mrts_command("sweep", study_file(tmp_path), "-o", tmp_path / "out", "--workers", 1, "--top", 9)
    assert (done.returncode, done.stderr) == (0, "")
    outcome, best, *lines = done.stdout.splitlines()
    assert outcome == "study.yaml: 6 variants: 3 unreachable, 2 feasible, 1 infeasible"
    rows = mrts.read_study_folder(tmp_path / "out").table().to_pylist()
    fastest = min((row for row in rows if row["duration"]), key=lambda row: row["duration"])
    assert best == f"best: variant {fastest['variant']}, {fastest['duration']:.4g} s"
    folder = tmp_path / "out" / "best-1"
    first = mrts.scale(mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(folder / "motion.yaml"), between=None)
    assert first.trajectory.duration == pytest.approx(fastest["duration"], rel=1e-9)
    assert lines == ["", "written:", *(f"  {folder.with_name(name)}" for name in ("best-1", "best-2"))]
    assert len([*folder.parent.glob("best-*/*")]) == 2 * 2
    again = mrts_command("sweep", study_file(tmp_path), "-o", tmp_path / "out", "--top", 9)
    assert (again.returncode, again.stdout) == (0, done.stdout)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "Missing option '-o' / '--output'"),
        (("-o", "out", "--workers", 0), "--workers = 0: must be at least 1."),
        (("-o", "out", "--workers", 2, "--scheduler", "tcp://h:1"), "--workers = 2: goes with processes of this"),
        (("-o", "out", "--top", -1), "'--top': -1 is not in the range"),
        (("-o", "study.yaml"), "--output = 'study.yaml': names the same file as STUDY."),
        (("-o", "."), "holds no study, but study.yaml: name a new or empty folder."),
    ],
)
def test_wrong_options_are_named(arguments, said, tmp_path):
    study_file(tmp_path)
    done = mrts_command("sweep", "study.yaml", *arguments, cwd=tmp_path)
    assert done.returncode == 2, done.stdout
    assert said in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["study.yaml"]


def test_a_terminal_sees_how_far_it_is_and_ctrl_c_says_how_to_go_on(tmp_path):
    path = study_file(tmp_path, "vary: {object.mass: {from: 1, to: 4, steps: 500}}\nbetween: 0.001")
    command = driver_command(path, "-o", tmp_path / "out", "--workers", 1)
    done = at_terminal(command, keys=[("of 500;", "\x03\x03")], COLUMNS="200")
    assert done.code == 130, done.shown
    ending = done.shown[done.shown.index("out holds") :]
    assert re.match(r"out holds \d+ of 500 variants: the same command goes on from there", ending)
    assert ending.rstrip().endswith("mrts: interrupted\x1b[0m")


LIFT = DATA / "lift.yaml"
PLACED = {
    "robots.left.base.xyz[0]": {"from": -0.3, "to": 0.3},
    "robots.right.base.xyz[1]": {"from": -0.3, "to": 0.3},
    "robots.right.grasp.xyz[1]": {"from": -0.1, "to": 0.1},
}
OUT_OF_REACH = {"robots.left.base.xyz[0]": {"from": -9, "to": -8}}


def test_the_best_layout_is_a_cell_file(tmp_path):
    study, target = write_study(tmp_path, shipped("planar_dual_arm"), LIFT, PLACED), tmp_path / "best.yaml"
    done = mrts_command("place", study, "-o", target, "--starts", "1", "--look", "8")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("planar_dual_arm: c² up to 3.")
    assert "collisions of robot 'left', robot 'right' are not looked at" in done.stdout
    given, best = (yaml.safe_load(path.read_text()) for path in (tmp_path / "cell.yaml", target))
    assert best["robots"][0].pop("base")["xyz"][1:] == given["robots"][0].pop("base")["xyz"][1:]
    assert best["object"] == given["object"]
    c2 = mrts.scale(mrts.load_cell(target), mrts.load_motion(LIFT)).range.upper.c2
    assert f"c² up to {c2:.4g} instead of" in done.stdout


def test_no_layout_is_exit_code_1_and_leaves_what_was_there(tmp_path, capsys):
    study, target = write_study(tmp_path, shipped("planar_dual_arm"), LIFT, OUT_OF_REACH), tmp_path / "best.yaml"
    target.write_text("kept")
    assert main(["place", str(study), "-o", str(target), "--look", "2"]) == 1
    out, err = capsys.readouterr()
    assert "no layout that was looked at can be played. robot 'left'" in out
    assert f"{target} not written" in out + err
    assert target.read_text() == "kept"
