"""Bad input through the command line: one clear paragraph, exit code 2, never a traceback."""

import json
import shutil

import pytest
import yaml
from conftest import DATA

import mrts
from mrts import CompilerError, load_cell
from mrts.base.errors import LONGEST_MESSAGE, html_text, printable
from mrts.cli import main
from mrts.commands.console import put, say, warn
from mrts.kernel import compiler as kernel_compiler

pytestmark = pytest.mark.quick

HOSTILE = "a\x1b[31mb\r\x07\u202e\u200b\u2028\x9b\x7f\ud800"
SHOWN = r"a\u001b[31mb\r\u0007\u202e\u200b\u2028\u009b\u007f\ud800"


def test_control_characters_and_invisible_signs_are_escaped_as_json_does():
    assert printable("c² ∈ [0, ∞) µm 日本 τ̈ \\ {} %s") == "c² ∈ [0, ∞) µm 日本 τ̈ \\ {} %s"
    assert printable(HOSTILE) == SHOWN
    assert json.loads(f'"{printable(HOSTILE)}"') == HOSTILE
    assert html_text(f"<b>{HOSTILE}") == f"&lt;b&gt;{SHOWN}"


def test_messages_are_one_short_paragraph_without_control_characters():
    message = str(mrts.InputError(f"{HOSTILE}\n\n", f"must not\n\nbe {HOSTILE}.", key=f"k\n{HOSTILE}", value=HOSTILE))
    assert message.isprintable()
    assert message.count(SHOWN) == 3
    assert str(mrts.CompilerError("one\ntwo\t\x1b[1m")) == "one\ntwo\\t\\u001b[1m"
    assert len(str(mrts.InputError("cell.yaml", "is wrong.", key="j" * 1_000_000))) < 400
    assert len(str(mrts.InputError("a", "b " * 1_000_000, value=10**5000))) <= LONGEST_MESSAGE


@pytest.mark.parametrize("show", [say, put, warn])
def test_what_is_printed_keeps_its_lines_only(show, capsys):
    show(f"first\nsecond {HOSTILE}")
    captured = capsys.readouterr()
    assert (captured.out + captured.err).endswith(f"first\nsecond {SHOWN}\n")


def test_names_of_files_and_arguments_are_quoted_printable(tmp_path, capsys):
    for key in ("{0}", "{key.__class__}", "%s %n", "\x1b[31m\u202e"):
        (tmp_path / "key.yaml").write_text(f"{json.dumps(key)}: 1\n", encoding="utf-8")
        assert main(["generate", str(tmp_path / "key.yaml")]) == 2
        assert f"unknown key '{printable(key)}'. The keys here are: name, gravity" in capsys.readouterr().err
    text = (DATA / "planar_arm.urdf").read_text(encoding="utf-8")
    text = text.replace('"elbow" type="continuous"', '"el&#x202e;bow&#xa;$x{" type="floating"')
    (tmp_path / "planar_arm.urdf").write_text(text, encoding="utf-8")
    (tmp_path / "cell.yaml").write_text((DATA / "cell.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    assert main(["scale", str(tmp_path / "cell.yaml"), str(DATA / "lift.yaml")]) == 2
    assert r"joint 'el\u202ebow\n$x{' type = 'floating'" in capsys.readouterr().err
    for arguments in (["sca\x1b[31mle"], ["scale", "a", "b", "--\x1b[31m"], ["scale", "a", "b", "--c2", "\x1b[31m"]):
        assert main(arguments) == 2
        assert "\x1b" not in capsys.readouterr().err


BOMB = """<?xml version="1.0"?><!DOCTYPE bomb [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;">]><robot name="&c;"><link name="base_link"/></robot>"""

GONE = object()


@pytest.fixture
def files(tmp_path):
    """A copy of the shipped cell to spoil."""
    for path in DATA.iterdir():
        shutil.copy(path, tmp_path / path.name)
    return tmp_path


def change(path, place, value):
    """Put a value at a place of a YAML file, or take away what is there."""
    data = here = yaml.safe_load(path.read_text())
    *keys, last = [int(key) if key.isdigit() else key for key in place.split(".")]
    for key in keys:
        here = here[key]
    here.pop(last, None)
    if value is not GONE:
        here[last] = value
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


MISTAKES = [
    ("cell.yaml", "masss", 1, "unknown key 'masss'. The keys here are: name, gravity"),
    ("cell.yaml", "object.mass", 1e-320, "at least 1e-100"),
    ("cell.yaml", "object.inertia", [[1, 2, 0], [2, 1, 0], [0, 0, 1]], "its principal moments are -1, 1, 3"),
    ("cell.yaml", "object.inertia", [1, 1, 3], "triangle inequality"),
    ("cell.yaml", "object.variation", {"mass": [2, 0.5]}, "object.variation: mass = [2, 0.5]: the lower value"),
    ("cell.yaml", "object.variation", {"izz": [-1, 2]}, "object.variation: izz = [-1, 2]: factors of a moment"),
    ("cell.yaml", "object.variation", {"mass": [0, 2]}, "object.variation: mass = [0, 2]: factors of the mass"),
    ("cell.yaml", "object.variation", {"mass": [float("nan"), 2]}, "object.variation.mass[0] = nan: must be a finite"),
    ("cell.yaml", "object.variation", {"masss": [0.5, 2]}, "unknown parameter 'masss'; did you mean 'mass'?"),
    ("cell.yaml", "object.variation", {"mass": [0.5]}, "object.variation.mass = [0.5]: has 1 values"),
    ("cell.yaml", "object.variation", {"mass": "heavy"}, "object.variation.mass = 'heavy': must be a list"),
    ("cell.yaml", "object.variation", {"mass": [2, 3]}, "object.variation: mass = [2, 3]: it is a factor of"),
    ("cell.yaml", "object.variation", {"mx": [0.1, 0.3]}, "object.variation: mx = [0.1, 0.3]: it is a difference"),
    ("cell.yaml", "object.variation", {}, "object.variation: needs at least one range"),
    ("cell.yaml", "robots.1.name", "left", "two robots are called 'left'"),
    ("cell.yaml", "robots.0.urdf", "t\0.urdf", "cannot be read"),
    ("cell.yaml", "robots.0.urdf", "package://no_such_thing/arm.urdf", "robots[0] (left).urdf = 'package://no_such"),
    ("cell.yaml", "robots.0.tip_link", "tool", "tip_link = 'tool': there is no such link"),
    ("cell.yaml", "robots.0.base_link", "contact", "no joint moves between 'contact' and 'contact'"),
    ("cell.yaml", "robots.0.torque", GONE, "'shoulder': its effort limit is missing or 0"),
    ("cell.yaml", "robots.0.grasp", {"xyz": [-1.1, 0, 0], "rpy": [0.5, 0, 0]}, "'contact' is tilted by 28.65°"),
    ("cell.yaml", "robots.0.base", {"xyz": [0, 0, 0.2]}, "came no nearer than 0.2 m"),
    ("lift.yaml", "start", [0, 0, 0], "start = [0, 0, 0]: must be a mapping of keys to values, of xyz, rpy, "),
    ("lift.yaml", "end", GONE, "required with 'start'"),
    ("lift.yaml", "end", {"xyz": [1.25, 3.0, 0]}, "robot 'left' cannot reach its grasp at sample 100"),
]


@pytest.mark.parametrize(("file", "place", "value", "said"), MISTAKES)
def test_mistakes_in_the_cell_and_the_motion_file(file, place, value, said, files, capsys):
    change(files / file, place, value)
    assert said in run(capsys, files)


URDF_MISTAKES = [
    ("<robot", "robot", "not well-formed XML"),
    ("</robot>", "", "not well-formed XML"),
    (None, BOMB, "document type or an entity"),
    ('<mass value="5"/>', "", "link 'upper_arm'"),
    ('ixx="0.025"', 'ixx="2.5"', "link 'upper_arm' inertia: breaks the triangle inequality"),
    ('xyz="0 0 1"', 'xyz="0 0 0"', "joint 'shoulder' axis"),
    ('"elbow" type="continuous"', '"elbow" type="floating"', "joint 'elbow' type = 'floating': a joint on the chain"),
    ('<parent link="forearm"/>', '<parent link="elsewhere"/>', "joint 'wrist': names a link 'elsewhere'"),
    ('<parent link="base_link"/>', '<parent link="hand"/>', "loop"),
    ('name="forearm">', 'name="upper_arm">', "link 'upper_arm': "),
    ('value="5"', 'value="5e-324"', "1e-100"),
    ("forearm", "\xff", "not UTF-8"),
]


@pytest.mark.parametrize(("old", "new", "said"), URDF_MISTAKES)
def test_mistakes_in_the_urdf(old, new, said, files, capsys):
    path = files / "planar_arm.urdf"
    text = new if old is None else path.read_text().replace(old, new, 1)
    path.write_text(text, encoding="latin-1" if "\xff" in text else "utf-8")
    message = run(capsys, files)
    assert "planar_arm.urdf" in message
    assert said in message


def test_a_refused_speed_still_writes_the_range(files, capsys, tmp_path):
    message = run(capsys, files, "--c2", "7", "--json", tmp_path / "range.json")
    assert "c² ∈ [0, 3.06181]" in message
    saved = yaml.safe_load((tmp_path / "range.json").read_text())
    assert saved["c2"]["upper"] == pytest.approx(3.0618125)
    assert "selected" not in saved


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


def test_a_compiler_that_takes_too_long_may_remove_its_temporary_files(monkeypatch, tmp_path):
    (tmp_path / "cc").write_text("#!/bin/sh\ntouch temporary\ntrap 'rm temporary; exit 1' TERM\nsleep 60 &\nwait\n")
    (tmp_path / "cc").chmod(0o755)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(kernel_compiler, "PATIENCE", 0.5)
    with pytest.raises(CompilerError, match=r"was not done after 0\.5 s"):
        kernel_compiler.compile_library((str(tmp_path / "cc"),), tmp_path / "source.c", tmp_path / "library.so")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cc"]


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
