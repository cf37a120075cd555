"""Bad input through the command line: one clear paragraph, exit code 2, never a traceback."""

import shutil

import pytest
import yaml
from conftest import DATA

from mrts import CompilerError, load_cell
from mrts.cli import main

pytestmark = pytest.mark.quick

BOMB = """<?xml version="1.0"?><!DOCTYPE bomb [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;">]><robot name="&c;"><link name="base_link"/></robot>"""


@pytest.fixture
def files(tmp_path):
    """A copy of the shipped cell to spoil."""
    for path in DATA.iterdir():
        shutil.copy(path, tmp_path / path.name)
    return tmp_path


def change(path, edit):
    data = yaml.safe_load(path.read_text())
    edit(data)
    path.write_text(yaml.safe_dump(data))


def refused(capsys, *arguments):
    code = main([str(argument) for argument in arguments])
    captured = capsys.readouterr()
    assert code == 2, captured.out
    assert captured.err.startswith("mrts: error: ")
    assert "Traceback" not in captured.err
    assert "\n\n" not in captured.err.strip()
    return captured.err


def run(capsys, files, *options):
    return refused(capsys, "scale", files / "cell.yaml", files / "lift.yaml", *options)


CELL_MISTAKES = {
    "unknown key": (lambda d: d.update(masss=1), ["unknown key 'masss'", "The keys here are: name, gravity"]),
    "nan": (lambda d: d.update(gravity=[0, float("nan"), 0]), ["gravity[1]", "nan", "finite"]),
    "text for a number": (lambda d: d["object"].update(mass="heavy"), ["object.mass", "'heavy'", "number"]),
    "non-PD inertia": (
        lambda d: d["object"].update(inertia=[[1, 2, 0], [2, 1, 0], [0, 0, 1]]),
        ["inertia", "not positive definite", "-1, 1, 3"],
    ),
    "mass next to nothing": (lambda d: d["object"].update(mass=1e-320), ["object.mass", "1e-100"]),
    "asymmetric inertia": (
        lambda d: d["object"].update(inertia=[[1, 0.2, 0], [0, 1, 0], [0, 0, 1]]),
        ["inertia", "not symmetric"],
    ),
    "triangle inequality": (lambda d: d["object"].update(inertia=[1, 1, 3]), ["triangle inequality"]),
    "bad name": (lambda d: d.update(name="a; rm -rf /"), ["name", "letters, digits"]),
    "two equal names": (lambda d: d["robots"][1].update(name="left"), ["two robots are called 'left'"]),
    "sexagesimal": (lambda d: d["object"].update(mass="1:30"), ["object.mass", "'1:30'"]),
    "null byte": (lambda d: d["robots"][0].update(urdf="t\0.urdf"), ["cannot be read"]),
    "posture out of all bounds": (lambda d: d["robots"][0].update(posture=[1e300, 0, 0]), ["posture[0]", "<= 10000"]),
    "unknown tip": (lambda d: d["robots"][0].update(tip_link="tool"), ["tip_link = 'tool'", "contact"]),
    "tip above base": (
        lambda d: d["robots"][0].update(base_link="hand", tip_link="forearm"),
        ["'forearm'", "not below base_link 'hand'"],
    ),
    "posture too long": (lambda d: d["robots"][0].update(posture=[0] * 4), ["posture", "3 values", "shoulder"]),
    "torque zero": (lambda d: d["robots"][1].update(torque=[100, 0, 50]), ["torque", "'elbow'", "must be > 0"]),
    "torque upside down": (
        lambda d: d["robots"][1].update(torque={"lower": [1, 1, 1], "upper": [0, 2, 2]}),
        ["torque", "'shoulder'", "below"],
    ),
    "wrench upside down": (
        lambda d: d["robots"][0].update(wrench={"lower": [2, None, None], "upper": [-2, None, None]}),
        ["wrench.lower[0]", "at most the upper one"],
    ),
    "missing urdf": (lambda d: d["robots"][0].update(urdf="nothing.urdf"), ["nothing.urdf", "no such URDF"]),
    "unknown package": (
        lambda d: d["robots"][0].update(urdf="package://no_such_thing/arm.urdf"),
        ["robots[0] (left).urdf", "package://no_such_thing/arm.urdf'", "is not found", "AMENT_PREFIX_PATH"],
    ),
    "effort missing": (
        lambda d: d["robots"][0].pop("torque"),
        ["joint 'shoulder'", "effort limit is missing or 0", "torque: [shoulder, elbow, wrist]"],
    ),
    "tilted tip": (
        lambda d: d["robots"][0].update(grasp={"xyz": [-1.1, 0, 0], "rpy": [0.5, 0, 0]}),
        ["grasp.rpy", "'contact'", "tilted by 28.65°"],
    ),
    "tilted base": (lambda d: d["robots"][0].update(base={"rpy": [0.1, 0, 0]}), ["base.rpy", "normal"]),
    "base out of the plane": (
        lambda d: d["robots"][0].update(base={"xyz": [0, 0, 0.2]}),
        ["robot 'left'", "came no nearer than 0.2 m"],
    ),
}

MOTION_MISTAKES = {
    "a list for a pose": (lambda d: d.update(start=[0, 0, 0]), ["start", "a mapping of keys to values, of xyz, rpy, "]),
    "zero duration": (lambda d: d.update(duration=0), ["duration = 0", "must be > 1e-09"]),
    "no end": (lambda d: d.pop("end"), ["required with 'start'", "end"]),
    "nothing": (lambda d: d.clear() or d.update(duration=1), ["here is none of them"]),
    "equal waypoints": (
        lambda d: [d.pop("start"), d.pop("end"), d.update(waypoints=[{}, {}, {"xyz": [1, 0, 0]}])],
        ["waypoints 0 and 1 are the same"],
    ),
    "missing table": (lambda d: d.clear() or d.update(file="no.csv"), ["no.csv", "no such table"]),
    "unreachable": (
        lambda d: d.update(end={"xyz": [1.25, 3.0, 0]}),
        ["robot 'left' cannot reach", "sample 100", "too far"],
    ),
}


@pytest.mark.parametrize(
    ("file", "mistakes", "mistake"),
    [("cell.yaml", CELL_MISTAKES, mistake) for mistake in CELL_MISTAKES]
    + [("lift.yaml", MOTION_MISTAKES, mistake) for mistake in MOTION_MISTAKES],
)
def test_mistakes_in_the_cell_and_the_motion_file(file, mistakes, mistake, files, capsys):
    edit, expected = mistakes[mistake]
    change(files / file, edit)
    message = run(capsys, files)
    for part in expected:
        assert part in message


URDF_MISTAKES = {
    "not xml": (lambda _: "robot: planar", ["not well-formed XML"]),
    "cut off": (lambda text: text[: len(text) // 2], ["not well-formed XML", "line"]),
    "entity bomb": (lambda _: BOMB, ["document type or an entity"]),
    "xacro": (lambda text: text.replace('value="5"', 'value="${m}"'), ["unexpanded xacro"]),
    "no mass": (lambda text: text.replace('<mass value="5"/>', ""), ["link 'upper_arm'", "<mass value=…>"]),
    "unphysical": (lambda text: text.replace('ixx="0.025"', 'ixx="2.5"'), ["link 'upper_arm' inertia", "triangle"]),
    "zero axis": (lambda text: text.replace('xyz="0 0 1"', 'xyz="0 0 0"', 1), ["joint 'shoulder' axis", "zero"]),
    "ball joint": (
        lambda text: text.replace('"elbow" type="continuous"', '"elbow" type="floating"'),
        ["joint 'elbow' type", "'floating'", "revolute"],
    ),
    "no such parent": (
        lambda text: text.replace('<parent link="forearm"/>', '<parent link="elsewhere"/>'),
        ["joint 'wrist'", "'elsewhere'"],
    ),
    "loop": (
        lambda text: text.replace('<parent link="base_link"/>', '<parent link="hand"/>'),
        ["loop", "tree"],
    ),
    "two links": (lambda text: text.replace('name="forearm">', 'name="upper_arm">'), ["link 'upper_arm'", "two links"]),
    "mimic": (
        lambda text: text.replace('<origin xyz="1 0 0"/>', '<origin xyz="1 0 0"/><mimic joint="shoulder"/>', 1),
        ["joint 'elbow' mimic", "'shoulder'", "a motor of its own"],
    ),
    "python number": (lambda text: text.replace('value="5"', 'value="4_0"'), ["'4_0'", "finite number"]),
    "mass next to nothing": (lambda text: text.replace('value="5"', 'value="5e-324"'), ["'5e-324'", "1e-100"]),
    "binary": (None, ["not UTF-8"]),
}


@pytest.mark.parametrize("mistake", URDF_MISTAKES)
def test_mistakes_in_the_urdf(mistake, files, capsys):
    edit, expected = URDF_MISTAKES[mistake]
    path = files / "planar_arm.urdf"
    if edit is None:
        path.write_bytes(b"\xff\xfe\x00<robot/>")
    else:
        path.write_text(edit(path.read_text()))
    message = run(capsys, files)
    assert "planar_arm.urdf" in message
    for part in expected:
        assert part in message


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("name: [", ["not valid YAML", "line"]),
        ("- a\n- b", ["mapping"]),
        ("name: a\nname: b\n", ["'name' stands twice"]),
        ("name: !!python/object/apply:os.system ['true']", ["not valid YAML"]),
    ],
)
def test_files_that_are_not_a_cell(text, expected, files, capsys):
    (files / "cell.yaml").write_text(text)
    message = run(capsys, files)
    for part in expected:
        assert part in message


def test_missing_files(files, capsys):
    assert "no such cell file" in refused(capsys, "scale", files / "no.yaml", files / "lift.yaml")
    assert "no such motion file" in refused(capsys, "scale", files / "cell.yaml", files / "no.yaml")
    for verb in ("scale", "check"):
        assert f"name the cell file in it: {files / 'cell.yaml'}" in refused(capsys, verb, files, files / "lift.yaml")
    assert "no such cell file" in refused(capsys, "generate", files / "no.yaml")


def test_a_refused_speed_still_writes_the_range(files, capsys, tmp_path):
    message = run(capsys, files, "--c2", "7", "--json", tmp_path / "range.json")
    assert "outside the admissible range [0, 3.06181]" in message
    saved = yaml.safe_load((tmp_path / "range.json").read_text())
    assert saved["c2"]["upper"] == pytest.approx(3.0618125)
    assert "selected" not in saved


def test_wrong_options_and_places(files, capsys, monkeypatch):
    (files / "file").write_text("")
    assert "cannot be written" in run(capsys, files, "--json", files / "file" / "result.json")
    assert "qpsol:qpoases" in run(capsys, files, "--solver", "magic")
    assert "sum to 1" in run(capsys, files, "--share", "0.5,0.6")
    monkeypatch.setenv("MRTS_CACHE_DIR", str(files / "file" / "cache"))
    assert "Set MRTS_CACHE_DIR" in run(capsys, files)


@pytest.mark.parametrize(
    ("compiler", "part"),
    [("sh -c 'echo no space left; exit 3' cc", "no space left"), ("no-such-compiler -O1", "names no program")],
)
def test_a_compiler_that_fails(files, capsys, monkeypatch, tmp_path, compiler, part):
    monkeypatch.setenv("CC", compiler)
    monkeypatch.setenv("MRTS_CACHE_DIR", str(tmp_path / "cache"))
    message = run(capsys, files)
    assert part in message
    assert "CC" in message
    assert not list((tmp_path / "cache").rglob("*.so"))


def test_without_a_compiler_a_cell_is_generated_and_not_answered(files, capsys, monkeypatch, tmp_path):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("MRTS_CACHE_DIR", str(tmp_path / "cache"))
    assert main(["check", str(files / "cell.yaml")]) == 0
    assert main(["check", str(files / "cell.yaml"), str(files / "lift.yaml")]) == 2
    assert "no C compiler" in capsys.readouterr().err
    assert main(["generate", str(files / "cell.yaml"), "-o", str(tmp_path / "generated")]) == 0
    for path in (files / "cell.yaml", tmp_path / "generated"):
        with pytest.raises(CompilerError):
            load_cell(path)
        said = refused(capsys, "scale", path, files / "lift.yaml")
        assert "no C compiler" in said
        assert "CC" in said
