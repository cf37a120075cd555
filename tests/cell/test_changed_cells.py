"""What can be changed of a cell in Python, and what is refused because the generated C would not know of it."""

from dataclasses import replace

import numpy as np
import pytest
from cell_bank import random_planar_cell
from changed_robots import with_left

import mrts

pytestmark = pytest.mark.quick

SIDE = np.array([0.1, 0.0, 0.0])


def moved(T):
    return mrts.RigidTransform(T.R, T.p + SIDE)


def c2(cell, lift):
    return mrts.scale(cell, lift).range.upper.c2


OF_CHAINS = {
    "plane": lambda cell: replace(cell, plane="xz"),
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


def test_functions_of_another_cell_are_refused(planar_cell, tmp_path):
    other = random_planar_cell(np.random.default_rng(1), tmp_path, 2).cell
    with pytest.raises(mrts.InputError, match=r"^cell: name"):
        replace(planar_cell, functions=other.functions)


def test_nobody_writes_into_a_cell(planar_cell):
    mine = np.full(3, 50.0)
    cell = with_left(planar_cell, torque_upper=mine)
    mine[:] = 0
    np.testing.assert_array_equal(cell.robots[0].torque_upper, 50)
    assert isinstance(replace(cell, robots=[*cell.robots]).robots, tuple)
    for array in (cell.gravity, cell.load, cell.robots[0].torque_upper, cell.robots[0].T_world_base.p):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
