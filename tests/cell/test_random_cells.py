"""The random cells of other tests are what their files say, although those are not generated."""

from dataclasses import fields

import numpy as np
import pytest
from casadi_cells import casadi_cell
from cell_bank import random_planar_cell, random_spatial_cell

import mrts


@pytest.mark.parametrize("make", [random_planar_cell, random_spatial_cell])
def test_a_random_cell_is_what_its_file_says(make, tmp_path):
    case = make(np.random.default_rng(1), tmp_path, 2)
    loaded = casadi_cell(case.cell_file)
    np.testing.assert_array_equal(loaded.load, case.cell.load)
    np.testing.assert_array_equal(loaded.gravity, case.cell.gravity)
    for ours, theirs in zip(case.cell.robots, loaded.robots, strict=True):
        for field in fields(theirs):
            if field.name == "source":  # the file gives the limits that the URDF gives the other
                continue
            one, other = getattr(ours, field.name), getattr(theirs, field.name)
            if isinstance(one, mrts.RigidTransform):
                one, other = np.column_stack([one.R, one.p]), np.column_stack([other.R, other.p])
            if isinstance(one, mrts.JointMotors):
                one, other = ([getattr(each, own.name) for own in fields(each)] for each in (one, other))
            np.testing.assert_equal(one, other)
