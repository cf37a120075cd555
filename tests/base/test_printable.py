"""What a user's files hold reaches terminals, messages and pages escaped."""

import json

import pytest
from conftest import DATA

import mrts
from mrts.base.errors import LONGEST_MESSAGE, html_text, printable
from mrts.cli import main
from mrts.commands.console import put, say, warn

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
