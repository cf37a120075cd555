"""`mrts check`: exit codes, verbs that refuse before anything is compiled, one list of remarks, and URDFs alone."""

import json
import re
import shutil
import subprocess
import sys

import pytest
from conftest import UR5
from damaged_cells import URDF, sound, written

import mrts
from mrts.cell.remarks import NO_COLLISIONS
from mrts.cli import main


@pytest.fixture
def far(tmp_path):
    """Files of a cell with an arm that is too far away."""
    cell, motion = sound()
    cell["robots"][1]["base"]["xyz"] = [1.7, 0, 0]
    return [str(path) for path in written(tmp_path, cell, motion)]


def test_exit_codes_and_json(far, tmp_path, capsys):
    assert main(["check", str(UR5 / "cell.yaml")]) == 0
    assert "next: mrts scale" in capsys.readouterr().out
    assert main(["check", *far, "-q", "--json", "-"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["status"] == "impossible"
    assert told["clearance"] is None
    assert [arm["follows"] for arm in told["arms"]] == [True, False]
    assert NO_COLLISIONS in [one["text"] for one in told["assumed"]]
    output = tmp_path / "out.json"
    assert main(["check", *far[::-1], "--json", str(output)]) == 2
    assert json.loads(output.read_text(encoding="utf-8"))["status"] == "wrong-input"
    out, err = capsys.readouterr()
    assert "two files swapped" in out
    assert str(output) in err
    assert main(["check", *far[::-1], "-q"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert main(["check", str(tmp_path / "nowhere.yaml"), far[1]]) == 2
    assert "1 mistake in the files" in capsys.readouterr().out


def test_an_unreachable_cell_is_refused_before_its_dynamics_are_generated(far, tmp_path):
    """Only what follows the object is compiled, and what takes long to import is not imported."""
    script = "import sys; from mrts.cli import main; code = main(sys.argv[1:]); print(*sys.modules); sys.exit(code)"
    cache = tmp_path / "cache"
    done = subprocess.run(
        [sys.executable, "-c", script, "scale", *far],
        capture_output=True,
        text=True,
        check=False,
        env={"MRTS_CACHE_DIR": str(cache), "PATH": str(shutil.which("gcc")).rpartition("/")[0]},
    )
    assert done.returncode == 2
    assert "robot 'right' cannot reach its grasp" in done.stderr
    assert f"mrts check {far[0]} {far[1]}" in done.stderr
    assert {path.stem for path in cache.rglob("*") if path.is_file()} <= {"motion"}
    assert not {"yourdfpy", "trimesh", "scipy"} & {*done.stdout.split()}


def of_urdf(change):
    """A cell whose arms are as their URDF has them, and that URDF changed."""

    def damage(cell, folder):
        (folder / "arm.urdf").write_text(change(URDF.read_text(encoding="utf-8")), encoding="utf-8")
        for robot in cell["robots"]:
            robot["urdf"] = "arm.urdf"
            robot.pop("torque", None)

    return damage


def carries(**keys):
    return lambda cell, _: cell["object"].update(keys)


def weightless(text):
    return re.sub(r"<inertial>.*?</inertial>", "", text, count=2, flags=re.DOTALL)


BAD = {
    "effort-placeholders": [of_urdf(lambda text: re.sub('effort="[^"]*"', 'effort="300"', text))],
    "inertia-unlike-shape": [
        carries(mass=4.0, inertia=[4, 4, 4], shape={"box": [0.25, 0.25, 0.25]}),
        carries(mass=4.0, inertia=[4e-6] * 3, shape={"cylinder": {"radius": 0.1, "length": 0.2}}),
    ],
    "urdf-friction": [
        of_urdf(lambda text: text.replace("</joint>", '<dynamics damping="0.5" friction="1.0"/></joint>'))
    ],
    "links-without-mass": [of_urdf(weightless)],
}


@pytest.mark.parametrize(("code", "damage"), [(code, damage) for code, some in BAD.items() for damage in some])
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
    lines = capsys.readouterr().out.splitlines()
    assert str(remark) in lines
    expected = [one.code for one in checked.remarks if one.severity != "assumption"]
    warnings = json.loads(output.read_text(encoding="utf-8"))["warnings"]
    assert [one["code"] for one in warnings][: len(expected)] == expected
    assert code in {one.code for one in mrts.load_result(tmp_path / "result.npz").warnings}


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
    (changes, keys), text = BROKEN[name], URDF.read_text(encoding="utf-8")
    for pattern, replacement in changes:
        text, count = re.subn(pattern, replacement, text, count=1)
        assert count == 1
    cell, motion = sound()
    of_urdf(lambda _: text)(cell, tmp_path)
    files = written(tmp_path, cell, motion)
    assert main(["check", *map(str, files), "-q", "--json", "-"]) == 2
    told = json.loads(capsys.readouterr().out)
    assert told["status"] == "wrong-input"
    assert [mistake["key"] or "" for mistake in told["mistakes"]] == keys
    assert main(["new", str(tmp_path / "new"), "--robot", str(tmp_path / "arm.urdf")]) == 2
    assert told["mistakes"][0]["rule"] in capsys.readouterr().err
