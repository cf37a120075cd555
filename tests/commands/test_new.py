"""`mrts new`: files that run, nothing overwritten, nothing left behind."""

import re
import shutil

import pytest
import yaml
from command_line import mrts_command
from conftest import DATA

from mrts.base.errors import MotionError
from mrts.cli import main

UR5 = DATA.parent / "dual_ur5" / "ur5_class_arm.urdf"


@pytest.fixture(scope="module")
def begun(dual_ur5, tmp_path_factory):
    """A cell begun from an arm whose chains are compiled already."""
    folder = tmp_path_factory.mktemp("begun")
    assert dual_ur5.library
    shutil.copy(UR5, folder / "my arm.urdf")
    done = mrts_command("new", "first cell", "--robot", "my arm.urdf", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder, done


def test_what_it_tells_is_enough_to_go_on(begun):
    folder, done = begun
    assert "left and right: ../my arm.urdf, base_link to tool0" in done.stdout
    assert re.search(
        r"shoulder_pan\s+revolute\s+\[-\d+, \d+\] N m\s+\[-6\.283, 6\.283\] rad\s+[\d.]+ rad/s", done.stdout
    )
    assert "you may play it up to" in done.stdout
    assert "the least distance is " in done.stdout
    *_, next_line = done.stdout.splitlines()
    assert next_line == "  mrts scale 'first cell/cell.yaml' 'first cell/motion.yaml'"
    scaled = mrts_command("scale", "first cell/cell.yaml", "first cell/motion.yaml", cwd=folder)
    assert scaled.returncode == 0
    assert scaled.stdout.startswith("first_cell: c² ∈ [0, ")
    assert yaml.safe_load((folder / "first cell" / "cell.yaml").read_text())["name"] == "first_cell"


def test_a_gripper_beyond_the_tip_is_told(monkeypatch, tmp_path, capsys):
    def stop(*_):
        raise MotionError("no layout")

    monkeypatch.setattr("mrts.starting.proposal.propose", stop)
    jaw = '<link name="jaw"/><joint name="j" type="fixed"><parent link="tool0"/><child link="jaw"/></joint>'
    text = UR5.read_text(encoding="utf-8").replace("</robot>", f"{jaw}</robot>")
    (tmp_path / "arm.urdf").write_text(text, encoding="utf-8")
    for words, said in (([], True), (["--tip", "jaw", "--tip", "jaw"], False)):
        assert main(["new", str(tmp_path / "x"), "--robot", str(tmp_path / "arm.urdf"), *words]) == 1
        assert ("jaw beyond tool0 may reach into the object" in capsys.readouterr().out) is said


def test_files_that_are_there_stay(begun):
    folder, _ = begun
    cell = folder / "first cell" / "cell.yaml"
    before = cell.read_bytes()
    done = mrts_command("new", "first cell", "--robot", "my arm.urdf", cwd=folder)
    assert (done.returncode, cell.read_bytes()) == (2, before)
    assert "first cell/cell.yaml: is there already; --force overwrites it" in done.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "Missing argument 'DIR'"),
        (["x", "--robot", UR5, "--base", "-1,2"], "--base = '-1,2': must be 3 or 6 numbers"),
        (["x", "--robot", UR5, "--base=0,0,0", "--base=0,0,0"], "--base: two arms stand in one place"),
        (["x", "--robot", UR5, "--mass", "-3"], "--mass = -3.0: must be a number > 0, in kg"),
    ],
)
def test_bad_input_is_named_and_nothing_is_made(words, said, tmp_path):
    done = mrts_command("new", *words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert [*tmp_path.iterdir()] == []
