"""The documentation: pages are done as they stand; reference, site and package are whole."""

import contextlib
import importlib
import io
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import mrts_codegen
import pytest
from conftest import ROOT

import mrts
from mrts.cli import COMMANDS

BLOCK = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
FAILURES = ("mrts: error", "infeasible")
"""What a page shows where a command may end with another exit code than 0."""


@dataclass
class Page:
    """One run of a page.

    A `python` block is executed, all in one namespace; `sh` is given to bash, all in one folder; a block with a title
    is written to the file of that name; `text` is the whole output of the block before it, but for … which stands for
    anything; `console` shows what only another machine can run.
    """

    path: Path
    folder: Path
    names: dict = field(default_factory=dict)
    ran: int = 0

    def run(self):
        blocks = BLOCK.findall(self.path.read_text(encoding="utf-8"))
        printed = None
        for index, (kind, title, code) in enumerate(blocks):
            after = blocks[index + 1] if index + 1 < len(blocks) else ("", "", "")
            expected = after[2] if after[0] == "text" else ""
            if title:
                (self.folder / title).parent.mkdir(parents=True, exist_ok=True)
                (self.folder / title).write_text(code, encoding="utf-8")
            elif kind == "python":
                printed = self.python(code)
            elif kind == "sh":
                printed = self.shell(code, may_fail=any(word in expected for word in FAILURES))
            elif kind == "text":
                assert printed is not None, f"{self.path.name}: nothing was run before\n{code}"
                assert matches(code, printed), f"{self.path.name} says\n{code}\nbut this is printed:\n{printed}"
            else:
                assert kind in {"console", "yaml", "xml"}, (kind, code)
        return self

    def python(self, code):
        self.ran += 1
        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.chdir(self.folder):
            exec(compile(code, str(self.path), "exec"), self.names)  # noqa: S102
        return output.getvalue()

    def shell(self, code, *, may_fail):
        self.ran += 1
        environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
        command = ["bash", "-eu", "-c", code]
        done = subprocess.run(
            command, cwd=self.folder, env=environment, text=True, check=False, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        assert done.returncode == 0 or may_fail, f"{self.path.name}: {code}{done.stdout}"
        return done.stdout


def matches(expected, printed):
    """Whether a text is another one but for the places marked … and the white space."""
    pattern = ".*".join(re.escape(part) for part in " ".join(expected.split()).split("…"))
    return re.fullmatch(pattern, " ".join(printed.split())) is not None


DOCS = ROOT / "docs"


@pytest.mark.parametrize(
    ("name", "blocks"),
    [
        ("tutorial", 7),
        pytest.param("gallery", 1, marks=pytest.mark.slow),
        pytest.param("own_cell", 6, marks=pytest.mark.slow),
        pytest.param("own_robot", 3, marks=pytest.mark.slow),
        pytest.param("check", 3, marks=pytest.mark.slow),
        pytest.param("command_line", 4, marks=pytest.mark.slow),
        pytest.param("ros2", 2, marks=pytest.mark.slow),
        pytest.param("optimal_profile", 2, marks=pytest.mark.slow),
        pytest.param("smooth", 2, marks=pytest.mark.slow),
        pytest.param("simulate", 3, marks=pytest.mark.slow),
        pytest.param("override", 2, marks=pytest.mark.slow),
        pytest.param("real_cell", 5, marks=pytest.mark.slow),
        pytest.param("studies", 7, marks=pytest.mark.slow),
        pytest.param("limits", 1, marks=pytest.mark.slow),
        pytest.param("what_if", 2, marks=pytest.mark.slow),
        ("extending", 1),
    ],
)
def test_a_page_does_what_it_shows_and_prints_what_it_says(name, blocks, tmp_path):
    assert Page(DOCS / f"{name}.md", tmp_path).run().ran >= blocks


def test_every_public_name_is_in_the_reference():
    text = "".join(page.read_text(encoding="utf-8") for page in (DOCS / "reference").glob("*.md"))
    shown = re.findall(r"^::: mrts\.(\w+)$", text, re.MULTILINE)
    assert set(mrts.__all__) <= set(shown)
    assert len(shown) == len(set(shown))


def test_every_verb_is_on_the_page_of_the_command_line():
    page = (DOCS / "command_line.md").read_text(encoding="utf-8")
    for verb in COMMANDS:
        assert f"| `mrts {verb}" in page, verb


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path):
    """As `make docs` does, with the reference of every public class and function in it."""
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path / "site")]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=False, env={"NO_MKDOCS_2_WARNING": "1"}
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    text = "".join(page.read_text(encoding="utf-8") for page in (tmp_path / "site" / "reference").glob("*.html"))
    for name in mrts.__all__:
        assert f'id="mrts.{name}"' in text, name
    assert not re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="https?:', text)  # nothing is fetched to read it


def test_users_import_from_mrts_or_a_package_of_it():
    """Never from a file: those may move. What contributors read, and the reference, name files."""
    for page in {*DOCS.glob("*.md"), ROOT / "README.md"} - {DOCS / "extending.md", DOCS / "notation.md"}:
        text = page.read_text(encoding="utf-8")
        for name in re.findall(r"(?<![\w./@-])(mrts(?:\.[A-Za-z_]\w*)+)", text):
            assert name.count(".") == 1 or name.startswith("mrts.plots.") or name.split(".")[1] in mrts.__all__, name
        for package in re.findall(r"^from (mrts\.\w[\w.]*) import", text, re.MULTILINE):
            assert hasattr(importlib.import_module(package), "__all__"), package


def test_this_environment_runs_this_folder():
    for package in (mrts, mrts_codegen):
        assert Path(package.__file__).resolve().is_relative_to(ROOT), package.__file__


@pytest.mark.parametrize(("package", "folder"), [("mrts", "mrts"), ("mrts_codegen", "codegen")])
def test_every_other_file_is_package_data(package, folder):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    patterns = project["tool"]["setuptools"]["package-data"][package]
    found = {path for pattern in patterns for path in (ROOT / folder).glob(pattern)}
    files = {path for path in (ROOT / folder).rglob("*") if path.is_file() and path.parent.name != "__pycache__"}
    assert found == {path for path in files if path.suffix != ".py"}
