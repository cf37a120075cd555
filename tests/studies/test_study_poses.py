"""Studies of cells whose poses are given by quaternions, or by what a tip looks at."""

import numpy as np
import pytest
import yaml
from shipped_cells import shipped
from study_files import planar_study

import mrts
from mrts.studies.layout.layout_numbers import LayoutNumbers
from mrts.studies.variant_numbers import base_numbers, varied_entries

HALF = [0.0, 0.0, 0.0, 1.0]  # half a turn about z, the right arm's


@pytest.fixture
def study(tmp_path):
    """Makes a study of the planar cell; the left tip looks at the bar's middle, the right one is turned by half."""

    def read(vary):
        given = shipped("planar_dual_arm")
        given["robots"][0]["grasp"] = {"xyz": [-1.1, 0, 0], "look_at": [0, 0, 0], "axis": "x"}
        given["robots"][1]["grasp"] = {"xyz": [1.1, 0, 0], "quaternion_wxyz": HALF}
        motion = {
            "duration": 1.0,
            "profile": "quintic",
            "start": {"xyz": [1.25, 1.0, 0], "quaternion_wxyz": [1, 0, 0, 0]},
            "end": {"xyz": [1.25, 1.5, 0]},
        }
        return planar_study(tmp_path, yaml.safe_dump({"vary": vary}), cell=given, motion=motion)

    return read


def test_variants_all_at_once_stand_where_their_files_say(study, planar_cell):
    one = study({"robots.right.grasp.rpy[2]": [3.0, 3.2], "motion.start.rpy[2]": [0.0]})
    assert len(varied_entries(one, planar_cell)) == 2
    base = base_numbers(one, planar_cell)
    np.testing.assert_allclose(base["grasp_rpy"][0], [[0, 0, 0], [0, 0, np.pi]], rtol=0, atol=1e-15)
    cell = mrts.Cell.from_description(one.descriptions(one.points(0, 1)[0])[0], folder=one.folder)
    np.testing.assert_allclose(cell.robots[1].T_object_tip.R[0, :2], [np.cos(3), -np.sin(3)], rtol=1e-12)


def test_a_tip_goes_on_looking_where_its_hand_moves(study, planar_cell):
    one = study({"robots.left.grasp.xyz[1]": {"from": -0.5, "to": 1.1, "steps": 2}})
    assert varied_entries(one, planar_cell) is None
    cell = mrts.Cell.from_description(one.descriptions(np.array([1.1]))[0], folder=one.folder)
    np.testing.assert_allclose(cell.robots[0].T_object_tip.R[:, 0], [0.5**0.5, -(0.5**0.5), 0], rtol=1e-12)
    with pytest.raises(mrts.InputError, match="poses by xyz and rpy"):
        LayoutNumbers.of(one, planar_cell)
