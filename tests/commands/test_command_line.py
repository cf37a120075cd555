"""The command line as a user runs it: files, options, exit codes of `mrts scale`, `mrts identify` and `mrts view`."""

import json
import shutil

import numpy as np
import pytest
import yaml
from command_line import mrts_command, mrts_process
from conftest import DATA, UR5
from motor_recordings import exact_recording, random_motors, write_recording
from shipped_cells import cell_file, changed_cell, shipped

import mrts
from mrts.cli import main
from mrts.output import film

CELL, LIFT = str(DATA / "cell.yaml"), str(DATA / "lift.yaml")


def drawn(monkeypatch):
    """What is asked to be drawn, in place of drawing it."""
    asked = []
    monkeypatch.setattr(film, "write_picture", lambda clips, path, at, **_: asked.append((clips, path, at)))
    return asked


def test_sides_are_what_scale_and_retime_find(planar_cell, lift, monkeypatch, tmp_path):
    asked = drawn(monkeypatch)
    sides = "given,fastest,optimal,smooth"
    command = ["view", CELL, LIFT, "--png", str(tmp_path / "x.png"), "--side-by-side", sides, "--rates", "20"]
    assert main(command) == 0
    ((clips, path, at),) = asked
    assert path == tmp_path / "x.png"
    given, fastest, optimal, smooth = (clip.trajectory for clip in clips)
    assert given.c2 == 1
    assert fastest.c2 == pytest.approx(mrts.scale(planar_cell, lift).range.upper.c2)
    assert optimal.duration == pytest.approx(mrts.retime(planar_cell, lift).duration)
    assert smooth.duration == pytest.approx(mrts.retime(planar_cell, lift, rates=20.0).duration, rel=1e-6)
    assert at == given.duration / 2
    assert [clip.title.split(" ")[0] for clip in clips] == ["as", "constant", "fastest", "smooth"]


def test_a_saved_result_clips_no_compiler(lifted, monkeypatch, tmp_path):
    asked = drawn(monkeypatch)
    mrts.save_result(lifted, tmp_path / "fast.npz")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    fast = str(tmp_path / "fast.npz")
    assert main(["view", fast, "--png", str(tmp_path / "x.png")]) == 0
    (clip,) = asked[0][0]
    assert clip.title == "c² = 3.062"
    np.testing.assert_array_equal(clip.trajectory.torque, lifted.trajectory.torque)


PICTURES = ["c2_range.png", "limits.png", "power_and_energy.png", "torques_and_wrenches.png"]


@pytest.mark.quick
def test_scale_reports_and_writes_the_documented_json(tmp_path, planar_cell, lift):
    target = tmp_path / "result.json"
    done = mrts_command("scale", DATA / "cell.yaml", DATA / "lift.yaml", "--json", target, "--plot", tmp_path / "plots")
    assert done.returncode == 0, done.stderr
    assert "c² ∈ [0, 3.062]" in done.stdout
    assert "left/elbow torque (upper, 80 N m)" in done.stdout
    result = json.loads(target.read_text())
    assert result["status"] == "feasible"
    assert set(result["c2"]) == set(result["binding"]) == {"lower", "upper"}
    assert set(result["samples"]) == {"time", "status", "c2_lower", "c2_upper"}
    assert result["selected"]["c2"] == result["c2"]["upper"]
    assert result["selected"]["duration"] == pytest.approx(result["torque"]["time"][-1])
    for key in ("torque", "wrench", "internal_wrench", "power"):
        assert {"time", "left", "right"} <= set(result[key])
        assert len(result[key]["left"]) == len(result[key]["time"]) == 101
    assert result == mrts.scale(planar_cell, lift).to_json()
    assert sorted(path.name for path in (tmp_path / "plots").iterdir()) == PICTURES


OPTIONS = {
    "--c2 1 --formulation torque --solver qpsol:qpoases --weights 1,2,3,4,5,6": {
        "select": 1.0, "formulation": "torque", "solver": "qpsol:qpoases", "weights": np.arange(1.0, 7.0)
    },
    "--c2 1 --distribute reserve --reserve 0.1": {"select": 1.0, "distribute": "reserve", "reserve": 0.1},
    "--rates 3": {"rates": 3.0},
    "--c2 1 --share equal": {"select": 1.0, "sharing": mrts.LoadSharing()},
}  # fmt: skip


def test_a_brief_answer_is_one_line_and_its_warnings_stand_apart(tmp_path, capsys):
    cell = shipped("planar_dual_arm")
    cell["object"]["shape"] = {"box": [1e-3, 1e-3, 1e-3]}
    main(["scale", str(cell_file(tmp_path, cell)), str(DATA / "lift.yaml"), "--brief"])
    out, err = capsys.readouterr()
    assert out.count("\n") == 1
    assert out.startswith(f"{cell['name']}: 1.75 ×")
    assert "radius of gyration" in err


def test_options_reach_the_library(planar_cell, lift, tmp_path):
    target = tmp_path / "plan.json"
    for words, asked in OPTIONS.items():
        assert main(["scale", CELL, LIFT, *words.split(), "--json", str(target), "-q"]) == 0
        assert json.loads(target.read_text()) == mrts.scale(planar_cell, lift, **asked).to_json()
    assert main(["scale", CELL, LIFT, "--no-wrench-limits", "--json", str(target), "-q"]) == 0
    assert json.loads(target.read_text()) == mrts.scale(planar_cell.without_wrench_limits(), lift).to_json()
    assert mrts_process("--version").stdout.strip() == f"mrts {mrts.__version__}"


def test_an_infeasible_motion_is_an_outcome(tmp_path):
    path = changed_cell(tmp_path, lambda cell: cell["object"].update(mass=60))
    arguments = ("scale", path, DATA / "lift.yaml", "--json", tmp_path / "r.json", "--plot", tmp_path)
    done = mrts_command(*arguments)
    assert done.returncode == 1
    assert done.stderr == ""
    assert "infeasible" in done.stdout
    assert "these limits conflict" in done.stdout
    assert "moving all limits outward by" in done.stdout
    result = json.loads((tmp_path / "r.json").read_text())
    assert result["c2"] == {"lower": None, "upper": None}
    assert result["conflicts"][0]["rows"]
    assert (tmp_path / "c2_range.png").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--csv", "-"], "only --json takes '-'"),
        (["--merged"], "goes with --ros-bag"),
        (["--sample-rate", "250"], "goes with --csv or --ros-bag"),
        (["--plot", "r.png"], "names a file, but writes a folder"),
        (["--json", "same.x", "--csv", "./none/../same.x"], "names the same file as --json"),
        (["--csv", "none.yaml"], "names the same file as MOTION"),
        (["--json", "file/x.json"], "is in a folder that is not there"),
        (["--report", "deep/x.html"], "is in a folder that is not there"),
        (["--csv", "folder"], "cannot be written"),
        (["--ros-bag", "folder"], "exists already"),
        (["--save", "nul\udcff/../file/x.npz"], "is in a folder that is not there"),
    ],
)
def test_outputs_that_make_no_sense_are_refused_before_any_work(options, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    assert main(["scale", str(DATA / "cell.yaml"), "none.yaml", *options]) == 2
    assert message in capsys.readouterr().err.replace("none.yaml", "MOTION")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["scael"], "No such command 'scael'. Did you mean 'scale'? ('mrts --help' has "),
        (
            ["scale", "--distribut", "x"],
            "No such option '--distribut'. Did you mean '--distribute'? ('mrts scale --help' has ",
        ),
        (["scale", "cell.yaml", "lift.yaml", "--plot", ""], "--plot: must not be empty: name a file or a folder."),
        (["scale", "c.yaml", "m.yaml", "--save", "a.npz", "--save", "b.npz"], "--save: is given twice."),
        (["new", "x", "--mass", "heavy"], "Invalid value for '--mass': 'heavy' is not a valid float ('mrts new --he"),
        (["scale", CELL, LIFT, "--csv", "plan.csv", "--sample-rate", "nan"], "--sample-rate = nan: must be"),
        (["scale", CELL, LIFT, "--csv", "plan.csv", "--sample-rate", "1e12"], "--sample-rate = 1000000000000.0"),
        (["scale", CELL, LIFT, "--reserve", "1.5"], "--reserve = 1.5: must be < 1."),
        (["scale", CELL, LIFT, "--weights", "1,2"], "--weights = [1.0, 2.0]: must be finite: one number, 6 of"),
        (["scale", CELL, LIFT, "--load", "foo"], "--load = 'foo': must be nominal"),
        (["scale", CELL, LIFT, "--between", "2"], "--between = 2.0: must be a share of a limit from 1e-05"),
        (["simulate", CELL, LIFT], "PLAN = '"),
        (["view", CELL, LIFT, "--video", "lift.avi"], "--video = 'lift.avi': must end in .gif or .mp4."),
        (["report", CELL], "RESULT = '"),
        (["export", CELL, "-o", "library", "--plan", "plan.csv"], "--plan = 'plan.csv': must end in .npz."),
    ],
)
def test_what_cannot_be_asked_for_is_told_in_one_line(words, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"mrts: error: {said}")
    assert error.count("\n") == 1
    assert [*tmp_path.iterdir()] == []


def test_no_output_overwrites_a_file_that_was_read(tmp_path, monkeypatch, capsys):
    """Whichever file names it: the URDF is the cell's."""
    shutil.copytree(DATA, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    before = (tmp_path / "planar_arm.urdf").read_bytes()
    assert main(["scale", "cell.yaml", "lift.yaml", "--csv", "./planar_arm.urdf", "--json", "result.json"]) == 2
    out, err = capsys.readouterr()
    assert "planar_arm.urdf: is a file that this command has read" in err
    assert out.startswith("planar_dual_arm: ")
    assert (tmp_path / "planar_arm.urdf").read_bytes() == before
    assert (tmp_path / "result.json").exists()
    shutil.copytree(UR5, "dual")
    assert main(["place", "dual/place.yaml", "-o", "dual/poor_cell.yaml"]) == 2
    assert capsys.readouterr().out == ""  # before the search


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
def test_what_changes_would_do_is_said_and_written_as_the_library_finds_it(planar_cell, lift, tmp_path, capsys):
    command, found = ["scale", CELL, LIFT, "--what-if"], mrts.scale(planar_cell, lift).what_if()
    assert main([*command, "--save", str(tmp_path / "a.npz"), "--report", str(tmp_path / "a.html")]) == 0
    written = "".join(f"  {tmp_path / name}\n" for name in ("a.npz", "a.html"))
    assert capsys.readouterr().out.endswith(f"\n\n{found}\n\nwritten:\n{written}")
    assert answered(capsys, *command)["what_if"] == found.to_json()
    assert mrts.load_result(tmp_path / "a.npz").changes == found
    assert "What changes would do" in (tmp_path / "a.html").read_text(encoding="utf-8")
    assert main(["report", str(tmp_path / "a.npz"), "-o", str(tmp_path / "b.html")]) == 0
    assert (tmp_path / "b.html").read_bytes() == (tmp_path / "a.html").read_bytes()


def test_energy_is_least_within_a_duration(capsys):
    within = answered(capsys, *SMOOTH, "--least-energy-in", "0.4")
    assert within["duration"] == pytest.approx(0.4, rel=1e-6)
    assert main([*SMOOTH, "--least-energy-in", "0.1"]) == 1
    assert capsys.readouterr().out.startswith("planar_dual_arm: duration too short: the motion cannot be done in 0.1 s")


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
