"""All files are shipped, and this environment runs this folder."""

import tomllib
from pathlib import Path

import mrts_codegen
import pytest
from conftest import ROOT

import mrts


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
