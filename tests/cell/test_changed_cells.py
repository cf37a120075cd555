"""What can be changed of a cell in Python or its files, what the cache makes of it, and what is refused."""

import shutil
import time
from dataclasses import replace

import numpy as np
import pytest
from changed_robots import with_left
from conftest import DATA
from same_cells import same_cell

import mrts
from mrts.cell import generation

pytestmark = pytest.mark.quick

SIDE = np.array([0.1, 0.0, 0.0])


def moved(T):
    return mrts.RigidTransform(T.R, T.p + SIDE)


def c2(cell, lift):
    return mrts.scale(cell, lift).range.upper.c2


OF_CHAINS = {
    "plane": lambda cell: replace(cell, plane=None),  # of six components, as its hands are not
    "name": lambda cell: replace(cell, name="other"),
    "robots": lambda cell: replace(cell, robots=cell.robots[::-1]),
    "robot 'left' T_base_tip": lambda cell: with_left(cell, T_base_tip=moved(cell.robots[0].T_base_tip)),
    "robot 'left' axes": lambda cell: with_left(cell, axes=-cell.robots[0].axes),
    "robot 'left' joints": lambda cell: with_left(cell, joints=("shoulder", "wrist", "elbow")),
    "robot 'left' held": lambda cell: with_left(cell, held={"torso": 0.1}),
}
OF_GEOMETRY = {
    "gravity": lambda cell: replace(cell, gravity=np.array([0.0, -1.6, 0.0])),
    "robot 'left' T_world_base": lambda cell: with_left(cell, T_world_base=moved(cell.robots[0].T_world_base)),
    "robot 'left' T_object_tip": lambda cell: with_left(cell, T_object_tip=moved(cell.robots[0].T_object_tip)),
}


@pytest.mark.parametrize("what", OF_CHAINS)
def test_what_the_generated_c_holds_is_refused(what, planar_cell):
    with pytest.raises(mrts.InputError, match=rf"^cell: {what}: .*Change the cell file .*mrts\.load_cell\(path\)"):
        OF_CHAINS[what](planar_cell)


@pytest.mark.parametrize("what", OF_GEOMETRY)
def test_geometry_changed_in_python_changes_the_answer(what, planar_cell, lift):
    assert c2(OF_GEOMETRY[what](planar_cell), lift) != c2(planar_cell, lift)


def test_nobody_writes_into_a_cell(planar_cell):
    mine = np.full(3, 50.0)
    cell = with_left(planar_cell, torque_upper=mine)
    mine[:] = 0
    np.testing.assert_array_equal(cell.robots[0].torque_upper, 50)
    assert isinstance(replace(cell, robots=[*cell.robots]).robots, tuple)
    for array in (cell.gravity, cell.load, cell.robots[0].torque_upper, cell.robots[0].T_world_base.p):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


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
