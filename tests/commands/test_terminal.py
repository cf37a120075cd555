"""The command line at a terminal: progress, colours, Ctrl-C, --quiet, help."""

import json
import re
import shutil
import subprocess
import sys
from importlib import import_module

import pytest
from conftest import DATA, UR5
from motor_recordings import exact_recording, random_motors, write_recording
from shipped_cells import cell_file, changed_cell, shipped
from terminal_session import at_terminal

import mrts
from mrts.cli import COMMANDS, main

MRTS = (sys.executable, "-m", "mrts")
LIFT = ("scale", DATA / "cell.yaml", DATA / "lift.yaml")
SOON = "import mrts.commands.console as console; console.PATIENCE = 0.2;"
"""Signs of life show before a second has passed, so that less work is enough to see them."""

MAIN = "import sys; from mrts.cli import main; sys.exit(main(sys.argv[1:]))"

HEAVY = ("numpy", "casadi", "scipy", "pydantic", "yaml", "matplotlib", "mrts_codegen")

ELSEWHERE = ("mrts view", "tcp://", "mrts demo -o")
"""Examples that other tests run: one serves until Ctrl-C, see test_viewer.py; a cluster is in test_sweep.py; the demo
takes seconds, see test_command_line.py."""

STUDY = """
cell: cell.yaml
motion: motion.yaml
load: nominal
vary: {"robots.left.base.xyz[0]": {from: -0.1, to: 0.1}}
sample: sobol
count: 4
"""


def varied(name, folder, **variation):
    """A copy of a shipped cell file whose load varies, and may need any wrenches."""
    cell = shipped(name)
    cell["object"]["variation"] = variation
    for robot in cell["robots"]:
        robot.pop("wrench", None)
    return cell_file(folder, cell)


@pytest.fixture(scope="module")
def uncertain(tmp_path_factory):
    """A cell, generated already, whose load has 128 corners: seconds of work for every question."""
    factors = {name: [0.5, 1.5] for name in ("mass", "ixx", "iyy", "izz")}
    moments = {name: [-0.1, 0.1] for name in ("mx", "my", "mz")}
    path = varied("dual_ur5", tmp_path_factory.mktemp("uncertain"), **factors, **moments)
    mrts.load_cell(path)
    return path


def test_colours_tell_the_outcome_the_failure_and_the_notes(tmp_path):
    command = [*MRTS, "scale", UR5 / "cell.yaml", UR5 / "lift_and_turn.yaml", "--no-velocity-limits"]
    feasible = at_terminal(command).shown
    assert "\x1b[1mdual_ur5: c² ∈ [0, 22.98]" in feasible
    assert "\x1b[33mwarning: right/wrist_2_turn velocity" in feasible
    heavy = changed_cell(tmp_path, lambda cell: cell["object"].update(mass=60))
    assert "\x1b[1m" not in at_terminal([*MRTS, *LIFT], NO_COLOR="").shown
    infeasible = at_terminal([*MRTS, "scale", heavy, DATA / "lift.yaml"])
    assert infeasible.code == 1
    assert "\x1b[1;31mplanar_dual_arm: infeasible" in infeasible.shown
    wrong = at_terminal([*MRTS, "scale", tmp_path / "cel.yaml", DATA / "lift.yaml"], COLUMNS="300")
    assert wrong.code == 2
    assert f"\x1b[1;31mmrts: error: {tmp_path / 'cel.yaml'}: there is no such cell file" in wrong.shown


@pytest.mark.parametrize(
    ("arguments", "shows"),
    [
        (["export", UR5 / "cell.yaml", "-o", "embedded"], "generating and compiling"),
        (["scale", "UNCERTAIN", UR5 / "lift_and_turn.yaml", "--load", "grid:10000"], "of 10000"),
        (["scale", "UNCERTAIN", UR5 / "lift_and_turn.yaml", "--load", "possible"], "scaling"),
    ],
    ids=["export", "grid", "possible"],
)
def test_control_c_ends_the_work_tidily(arguments, shows, uncertain, tmp_path, private_cache):
    words = [uncertain if word == "UNCERTAIN" else word for word in arguments]
    words += ["--json", tmp_path / "answer.json"] if words[0] == "scale" else []
    words = [tmp_path / word if word == "embedded" else word for word in words]
    cache = private_cache if uncertain in words else tmp_path / "cache"
    command = [sys.executable, "-c", SOON + MAIN, *words]
    done = at_terminal(command, keys=[(shows, "\x03")], MRTS_CACHE_DIR=str(cache), COLUMNS="150")
    assert done.code == 130, done.shown
    assert done.shown.endswith("mrts: interrupted\x1b[0m\r\n")
    assert "Traceback" not in done.shown
    assert "CasADi" not in done.shown
    assert not (tmp_path / "answer.json").exists()
    assert list(tmp_path.rglob(".*")) == []  # no file is left half written


def test_quiet_says_nothing_but_writes_the_files(tmp_path, capsys):
    target = tmp_path / "result.json"
    for words in ([*LIFT, "-q", "--json", target], ["--quiet", *LIFT, "--json", target]):
        target.unlink(missing_ok=True)
        assert main([*map(str, words)]) == 0
        assert capsys.readouterr() == ("", "")
        assert json.loads(target.read_text())["status"] == "feasible"
    assert main([*map(str, LIFT), "-q", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == "feasible"
    assert main(["scale", "-q", str(tmp_path / "none.yaml"), str(DATA / "lift.yaml")]) == 2
    assert "there is no such cell file" in capsys.readouterr().err
    assert main(["demo", "-q", "-o", str(tmp_path / "demo")]) == 0
    assert capsys.readouterr() == ("", "")
    assert (tmp_path / "demo" / "figure_4.png").exists()


def test_help_has_examples_and_imports_nothing_heavy():
    script = (
        "import sys\nfrom mrts.cli import main\n"
        "for words in (['--help'], *([name, '--help'] for name in sys.argv[1:])):\n"
        "    main(words)\n"
        f"    print('heavy:', [name for name in {HEAVY!r} if name in sys.modules], end='\\f')"
    )
    done = subprocess.run([sys.executable, "-c", script, *COMMANDS], capture_output=True, text=True, check=True)
    *helps, end = done.stdout.split("\f")
    assert (len(helps), end) == (len(COMMANDS) + 1, "")
    for said in helps:
        text, heavy = said.split("heavy:")
        assert heavy == " []"
        assert re.search(r"\n  examples:\n    (mrts|make) ", text), text
        assert "--quiet" in text


@pytest.mark.slow
def test_every_example_of_the_help_is_understood(tmp_path, monkeypatch):
    """The examples run as they stand, in a folder with the files that they name."""
    varied("planar_dual_arm", tmp_path, mass=[0.5, 2], izz=[0.5, 2])
    shutil.copy(DATA / "lift.yaml", tmp_path / "motion.yaml")
    cell = mrts.load_cell(tmp_path / "cell.yaml")
    (tmp_path / "study.yaml").write_text(STUDY, encoding="utf-8")
    for name in ("arm", "left", "right"):
        shutil.copy(UR5 / "ur5_class_arm.urdf", tmp_path / f"{name}.urdf")
    write_recording(tmp_path / "recorded.csv", *exact_recording(cell, random_motors(6), rate=200.0))
    mrts.write_trajectory_csv(mrts.scale(cell, mrts.load_motion(tmp_path / "motion.yaml")), tmp_path / "plan.csv")
    monkeypatch.chdir(tmp_path)
    ran = 0
    for verb in COMMANDS:
        for line in import_module(f"mrts.commands.{verb}").run.epilog.splitlines()[2:]:
            command = re.split(r"\s{2,}|\s\|", line.strip())[0].split()
            if command[0] == "mrts" and not any(word in line for word in ELSEWHERE):
                assert main(command[1:]) == 0, line
                ran += 1
    assert ran >= 2 * (len(COMMANDS) - 1) - 2
    assert (tmp_path / "plots" / "c2_range.png").exists()
