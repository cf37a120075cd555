"""The verbs of the Makefile: what each installs, and that none uses or changes the environment of another folder."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import venv
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


@pytest.fixture
def clone(tmp_path):
    """A folder with what make reads, as in a fresh clone."""
    folder = tmp_path / "a clone"
    folder.mkdir()
    for name in INPUTS:
        shutil.copy(ROOT / name, folder)
    return folder


@pytest.fixture
def installed(clone):
    """A clone whose .venv has all that the verbs need, as far as make can tell."""
    # venv as a command writes down in pyvenv.cfg where it made an environment; `venv.create` does not
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", ".venv"], cwd=clone, check=True)
    for name in STAMPS:
        (clone / ".venv" / name).touch()
    return clone


def contents(folder):
    return sorted((path, path.lstat().st_mtime_ns) for path in folder.rglob("*"))


def test_the_demo_installs_what_it_needs_and_no_more(clone):
    commands = plan(clone, "demo")
    assert "-e '.[plot]'" in commands
    assert commands.count("pip install") == 1
    assert commands.rstrip().endswith(".venv/bin/mrts demo -o build/demo")


@pytest.mark.parametrize("verb", ["quick", "test", "test-slow", "check", "docs", "fuzz", "instructions", "generate"])
def test_the_other_verbs_install_everything_at_once(clone, verb):
    commands = plan(clone, verb)
    assert "-e '.[plot,test,check]'" in commands
    assert commands.count("pip install") == 1


def test_the_two_suites_are_all_tests(installed):
    chosen = [re.search(r"pytest .* -m (.+)$", plan(installed, verb).strip())[1] for verb in ("test", "test-slow")]
    assert chosen == ['"not slow"', "slow"]


def test_what_is_installed_stays(installed):
    commands = plan(installed, "demo", "test", "check", "docs")
    assert "pip" not in commands
    assert "rm -rf .venv" not in commands


@pytest.mark.parametrize("name", INPUTS[1:])
def test_a_changed_input_installs_again(installed, name):
    later = (installed / ".venv" / "installed").stat().st_mtime + 10
    os.utime(installed / name, (later, later))
    assert plan(installed, "demo").count("pip install") == 1
    assert plan(installed, "test").count("pip install") == 1
    assert "rm -rf .venv" not in plan(installed, "demo", "test")


def test_a_moved_environment_is_made_anew_before_anything_runs(installed):
    moved = installed.rename(installed.with_name("moved"))
    assert plan(moved, "test").startswith("rm -rf .venv\n")
    code, text = make(moved, "demo", "PYTHON=false")  # the first command after the removal
    assert code != 0
    assert "mrts demo" not in text
    assert not (moved / ".venv").exists()


def test_a_copied_environment_is_made_anew_and_the_first_one_stays(installed):
    copy = shutil.copytree(installed, installed.with_name("copy"), symlinks=True)
    before = contents(installed)
    make(copy, "demo", "PYTHON=false")
    assert not (copy / ".venv").exists()
    assert contents(installed) == before


def test_an_environment_whose_python_is_gone_is_made_anew(installed):
    for path in (installed / ".venv" / "bin").glob("python*"):
        path.unlink()
    assert plan(installed, "demo").startswith("rm -rf .venv\n")


@pytest.mark.parametrize("verb", ["demo", "test", "check"])
def test_a_link_to_another_environment_is_refused(clone, tmp_path, verb):
    other = tmp_path / "other"
    venv.create(other)
    (other / "installed").touch()
    (clone / ".venv").symlink_to(other)
    before = contents(other)
    code, text = make(clone, verb)
    assert code != 0
    assert ".venv is a link, or was not made by make in this folder" in text
    assert contents(other) == before
    make(clone, "clean")
    assert contents(other) == before


def test_an_environment_that_make_did_not_make_is_refused(clone):
    (clone / ".venv").mkdir()
    (clone / ".venv" / "pyvenv.cfg").write_text("home = /usr/bin\n", encoding="utf-8")
    before = contents(clone / ".venv")
    code, text = make(clone, "demo")
    assert code != 0
    assert "was not made by make in this folder" in text
    assert contents(clone / ".venv") == before


def test_another_environment_cannot_be_named(installed, tmp_path):
    other = tmp_path / "other"
    code, text = make(installed, "-n", "demo", "clean", f"VENV={other}", f"BIN={other}/bin")
    assert code == 0
    assert str(other) not in text


def test_variables_that_point_elsewhere_do_not_reach_the_commands(clone, tmp_path):
    pip = ("TARGET", "PREFIX", "ROOT", "USER", "PYTHON", "EDITABLE", "REQUIREMENT", "DRY_RUN")
    python = ("PYTHONPATH", "PYTHONHOME", "PYTHONUSERBASE", "MYPYPATH")
    elsewhere = dict.fromkeys([*(f"PIP_{name}" for name in pip), *python], str(tmp_path))
    sources = {"PIP_INDEX_URL": "https://packages.example/simple", "PIP_CERT": "/certificate.pem"}
    (clone / "shown.mk").write_text("shown:\n\t@env\n", encoding="utf-8")
    code, text = make(clone, "-f", "Makefile", "-f", "shown.mk", "shown", **elsewhere, **sources)
    assert code == 0, text
    seen = dict(line.split("=", 1) for line in text.splitlines() if "=" in line)
    assert not elsewhere.keys() & seen.keys()
    assert sources.items() <= seen.items()


def test_types_are_not_checked_in_a_build_folder_of_another_clone(installed, tmp_path):
    (tmp_path / "scratch").mkdir()
    (installed / "build").symlink_to(tmp_path / "scratch")
    code, text = make(installed, "check")
    assert code != 0
    assert "build is not this folder's own" in text


def test_this_environment_runs_this_folder():
    for package in (mrts, mrts_codegen):
        assert Path(package.__file__).resolve().is_relative_to(ROOT), package.__file__


def shipped_files(folder):
    return [path for path in (ROOT / folder).rglob("*") if path.is_file() and path.parent.name != "__pycache__"]


@pytest.mark.parametrize("folder", ["mrts", "codegen"])
def test_every_module_lies_in_a_package(folder):
    """setup.py finds a package by the __init__.py in its folder and in all folders above."""
    for path in shipped_files(folder):
        if path.suffix == ".py":
            inside = path.relative_to(ROOT).parents
            assert all((ROOT / above / "__init__.py").exists() for above in inside if above != Path()), path


@pytest.mark.parametrize(("package", "folder"), [("mrts", "mrts"), ("mrts_codegen", "codegen")])
def test_every_other_file_is_package_data(package, folder):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    patterns = project["tool"]["setuptools"]["package-data"][package]
    found = {path for pattern in patterns for path in (ROOT / folder).glob(pattern)}
    assert found == {path for path in shipped_files(folder) if path.suffix != ".py"}


def test_one_extra_brings_all_that_users_may_want():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    (whole,) = extras["all"]
    name, _, named = whole.removesuffix("]").partition("[")
    of_developers = {"bench", "docs", "test", "check"}
    assert (name, set(named.split(","))) == ("mrts", {*extras} - of_developers - {"all"})
