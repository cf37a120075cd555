"""A cell from the cache is the cell of its files as they are now."""

import shutil
import time
from pathlib import Path

import pytest
from conftest import DATA
from mrts_codegen import content_key
from same_cells import same_cell

import mrts
from mrts.cell import generation

pytestmark = pytest.mark.quick

REACH = 2.5  # a joint limit of the URDF: it is in the manifest, and not in the C


@pytest.fixture
def copied(tmp_path):
    """Makes folders with the planar cell."""

    def copy(name):
        folder = tmp_path / name
        folder.mkdir()
        for file in ("cell.yaml", "planar_arm.urdf"):
            shutil.copy(DATA / file, folder)
        return folder / "cell.yaml"

    return copy


def limit(cell):
    """Give the first joint of a cell's URDF another limit."""
    urdf = cell.with_name("planar_arm.urdf")
    text = urdf.read_text(encoding="utf-8")
    limited = f'type="revolute"><limit lower="-{REACH}" upper="{REACH}" effort="1" velocity="1"/>'
    changed = text.replace('type="continuous">', limited, 1)
    assert changed != text
    urdf.write_text(changed, encoding="utf-8")


def reach(path):
    return mrts.load_cell(path).robots[0].position_upper[0]


def test_nothing_is_read_again_while_the_files_are_the_same(copied, planar_cell, monkeypatch):
    cell = copied("cell")
    cell.write_text(f"# {time.time_ns()}: a text that the cache has not seen\n" + cell.read_text(encoding="utf-8"))
    assert same_cell(mrts.load_cell(cell), planar_cell)

    def refuse(*_):
        raise AssertionError("the files are read again")

    monkeypatch.setattr(generation, "cell_model", refuse)
    again = mrts.load_cell(cell)
    assert same_cell(again, planar_cell)
    assert again.folder == cell.parent
    cell.write_bytes(cell.read_bytes() + b"# a remark\n")
    with pytest.raises(AssertionError, match="read again"):
        mrts.load_cell(cell)


def test_two_folders_with_one_text_and_two_urdfs_are_two_cells(copied):
    """They share a place in the cache; each takes what is there only if it is its own."""
    one, other = copied("one"), copied("other")
    limit(other)
    before = reach(one)
    assert [reach(other), reach(one), reach(other)] == [REACH, before, REACH]


def test_whatever_decides_what_a_manifest_says_is_in_its_key():
    package = Path(mrts.__file__).parent
    assert [pattern for pattern in content_key.SHAPING if not list(package.glob(pattern))] == []
