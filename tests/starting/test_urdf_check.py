"""`mrts check URDF`: what is wrong with one URDF, all at once, where `mrts new` names the first."""

import json
import re

import pytest
from conftest import DATA

from mrts.cli import main
from mrts.starting.urdf_check import check_urdf

UR5 = DATA.parent / "dual_ur5" / "ur5_class_arm.urdf"


def changed(folder, *changes):
    """The shipped arm with patterns replaced, each once."""
    text = UR5.read_text(encoding="utf-8")
    for pattern, replacement in changes:
        text, count = re.subn(pattern, replacement, text, count=1)
        assert count == 1
    path = folder / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    return path


BROKEN = {
    "text": (
        [(r"<mass value=", "<mass weight="), (r'effort="150"', 'effort="strong"')],
        ["link 'shoulder'", "joint 'shoulder_pan', <limit> effort"],
    ),
    "numbers": (
        [(r'ixx="[^"]*"', 'ixx="-1"'), (r'lower="[^"]*" upper="[^"]*"', 'lower="2" upper="1"'),
         (r'velocity="[^"]*"', 'velocity="-1"')],
        ["link 'shoulder' inertia", "joint 'shoulder_pan'", "joint 'shoulder_pan' velocity limit"],
    ),
    "no XML": ([(r"</robot>", "")], [""]),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_all_that_is_wrong_is_told_once(name, tmp_path, capsys):
    changes, keys = BROKEN[name]
    path = changed(tmp_path, *changes)
    assert main(["check", str(path), "-q", "--json", "-"]) == 2
    told = json.loads(capsys.readouterr().out)
    assert told["status"] == "wrong-input"
    assert [mistake["key"] or "" for mistake in told["mistakes"]] == keys
    assert main(["new", str(tmp_path / "new"), "--robot", str(path)]) == 2
    assert told["mistakes"][0]["rule"] in capsys.readouterr().err


def test_a_sound_arm_with_its_numbers(tmp_path, capsys):
    path = changed(tmp_path)
    assert main(["check", str(path), "--json", str(tmp_path / "found.json")]) == 0
    assert "arm.urdf: the URDF is sound\n" in capsys.readouterr().out
    told = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    assert {joint["robot"] for joint in told["joints"]} == {"tool0"}
    assert [joint["torque"][1] for joint in told["joints"]] == [150, 150, 150, 28, 28, 28]
    assert sum(joint["carried_mass"] for joint in told["joints"]) == pytest.approx(17.05, abs=0.01)
    assert (told["hints"], told["warnings"]) == ([], [])


def test_why_an_arm_can_hold_nothing(tmp_path):
    fixed = changed(tmp_path, (r'name="wrist_3_turn" type="revolute"', 'name="wrist_3_turn" type="fixed"'))
    found = check_urdf(fixed, {})
    assert (found.status, [remark.code for remark in found.hints]) == ("fine", ["cannot-hold"])
    assert "has 5 joints" in found.hints[0].text
