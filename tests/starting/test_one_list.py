"""What is to know of a cell is told by every command in the same codes, and never as a traceback or not at all."""

import json
import re

import pytest
from damaged_cells import URDF, sound, written

import mrts
from mrts.cli import main


def of_urdf(change):
    """A cell whose arms are as their URDF has them, and that URDF changed."""

    def damage(cell, folder):
        (folder / "arm.urdf").write_text(change(URDF.read_text(encoding="utf-8")), encoding="utf-8")
        for robot in cell["robots"]:
            robot["urdf"] = "arm.urdf"
            robot.pop("torque", None)

    return damage


def efforts(value):
    return of_urdf(lambda text: re.sub('effort="[^"]*"', f'effort="{value}"', text))


def friction(text):
    return text.replace("</joint>", '<dynamics damping="0.5" friction="1.0"/></joint>')


def weightless(text):
    return re.sub(r"<inertial>.*?</inertial>", "", text, count=2, flags=re.DOTALL)


def carries(**keys):
    def damage(cell, _folder):
        cell["object"] = {**keys}

    return damage


BAD = {
    "effort-placeholders": [efforts(5e4), efforts(100)],
    "friction-placeholders": [of_urdf(friction)],
    "links-without-mass": [of_urdf(weightless)],
    "inertia-unlike-shape": [
        carries(mass=4.0, inertia=[4, 4, 4], shape={"box": [0.25, 0.25, 0.25]}),
        carries(mass=4.0, inertia=[4e-6] * 3, shape={"cylinder": {"radius": 0.1, "length": 0.2}}),
    ],
}


@pytest.mark.parametrize(
    ("code", "damage"), [(code, damage) for code, damages in BAD.items() for damage in damages], ids=lambda value: value
    if isinstance(value, str) else ""
)  # fmt: skip
def test_every_command_tells_what_a_check_does(code, damage, tmp_path, capsys):
    cell, motion = sound()
    damage(cell, tmp_path)
    paths = [str(path) for path in written(tmp_path, cell, motion)]
    checked = mrts.check(*paths)
    remark = next(one for one in checked.remarks if one.code == code)
    assert remark.severity != "assumption"
    assert main(["check", *paths, "-q", "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert code in {one["code"] for one in told["hints"] + told["warnings"]}
    output = tmp_path / "output.json"
    assert main(["scale", *paths, "--save", str(tmp_path / "result.npz"), "--json", str(output)]) in {0, 1}
    first, *lines = capsys.readouterr().out.splitlines()
    assert str(remark) in lines
    assert ("efforts of the URDF that look like placeholders" in first) == (code == "effort-placeholders")
    expected = [one.code for one in checked.remarks if one.severity != "assumption"]
    warnings = json.loads(output.read_text(encoding="utf-8"))["warnings"]
    assert [one["code"] for one in warnings][: len(expected)] == expected
    assert code in {one.code for one in mrts.load_result(tmp_path / "result.npz").warnings}
