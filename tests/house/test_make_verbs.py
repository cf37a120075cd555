"""The verbs of the Makefile: what each installs and runs, and that all files are shipped."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import mrts_codegen
import pytest
from conftest import ROOT

import mrts

INPUTS = ("Makefile", "constraints.txt", "pyproject.toml", "setup.py")
STAMPS = ("demo", "installed")


def make(folder, *arguments, **environment):
    """Run make in a folder, with the caller's environment and some more; its exit code and what it wrote."""
    inherited = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    command = ["make", *arguments]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, env=inherited | environment, timeout=60
    )
    return done.returncode, done.stdout + done.stderr


def plan(folder, *verbs):
    """The commands that make would run."""
    code, text = make(folder, "-n", *verbs)
    assert code == 0, text
    return text


def fresh(folder):
    """A folder with what make reads, as in a fresh clone."""
    folder.mkdir()
    for name in INPUTS:
        shutil.copy(ROOT / name, folder)
    return folder


@pytest.fixture
def clone(tmp_path):
    return fresh(tmp_path / "a clone")


@pytest.fixture
def installed(tmp_path):
    """A clone whose .venv has all that the verbs need, as far as make can tell."""
    clone = fresh(tmp_path / "an installed clone")
    # venv as a command writes down in pyvenv.cfg where it made an environment; `venv.create` does not
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", ".venv"], cwd=clone, check=True)
    for name in STAMPS:
        (clone / ".venv" / name).touch()
    return clone


def test_each_verb_installs_what_it_needs_once_and_again_when_an_input_changes(clone, installed):
    assert plan(clone, "demo").count("-e '.[plot]'") == plan(clone, "demo").count("pip install") == 1
    assert plan(clone, "demo").rstrip().endswith(".venv/bin/mrts demo -o build/demo")
    for verb in ("quick", "test", "test-slow", "check", "docs", "fuzz", "instructions", "generate"):
        assert plan(clone, verb).count("-e '.[plot,test,check]'") == plan(clone, verb).count("pip install") == 1
    assert "pip" not in plan(installed, "demo", "test", "check", "docs")
    later = (installed / ".venv" / "installed").stat().st_mtime + 10
    os.utime(installed / "constraints.txt", (later, later))
    assert [plan(installed, verb).count("pip install") for verb in ("demo", "test")] == [1, 1]
    assert "rm -rf .venv" not in plan(installed, "demo", "test")


def test_the_two_suites_are_all_tests(installed):
    chosen = [re.search(r"pytest .* -m (.+)$", plan(installed, verb).strip())[1] for verb in ("test", "test-slow")]
    assert chosen == ['"not slow"', "slow"]


def test_this_environment_runs_this_folder():
    for package in (mrts, mrts_codegen):
        assert Path(package.__file__).resolve().is_relative_to(ROOT), package.__file__


def shipped_files(folder):
    return [path for path in (ROOT / folder).rglob("*") if path.is_file() and path.parent.name != "__pycache__"]


@pytest.mark.parametrize(("package", "folder"), [("mrts", "mrts"), ("mrts_codegen", "codegen")])
def test_every_other_file_is_package_data(package, folder):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    patterns = project["tool"]["setuptools"]["package-data"][package]
    found = {path for pattern in patterns for path in (ROOT / folder).glob(pattern)}
    assert found == {path for path in shipped_files(folder) if path.suffix != ".py"}
