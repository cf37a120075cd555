"""`mrts place` as it is typed: the answer, its file, exit codes, and what it refuses."""

import yaml
from command_line import mrts_command
from layouts import DATA, write_study
from shipped_cells import shipped

import mrts
import mrts.commands.place
from mrts.cli import main

LIFT = DATA / "planar_dual_arm" / "lift.yaml"
VARY = {
    "robots.left.base.xyz[0]": {"from": -0.3, "to": 0.3},
    "robots.right.base.xyz[1]": {"from": -0.3, "to": 0.3},
    "robots.right.grasp.xyz[1]": {"from": -0.1, "to": 0.1},
}
OUT_OF_REACH = {"robots.left.base.xyz[0]": {"from": -9, "to": -8}}


def test_the_best_layout_is_a_cell_file(tmp_path):
    study, target = write_study(tmp_path, shipped("planar_dual_arm"), LIFT, VARY), tmp_path / "new" / "best.yaml"
    target.parent.mkdir()
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
