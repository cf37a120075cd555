"""How far arms reach, against joint positions drawn at random."""

import numpy as np
import pytest
from conftest import UR5
from published_robots import CASES, urdf_path

import mrts
from mrts.cell.source_files import arm_of_urdf, read_urdf
from mrts.following.reach import ArmPlaces, arm_reach
from mrts.starting.arm import Arm

DRAWN = 20_000

NEARLY = {6: 0.999, 7: 0.9}
"""Share of the bound that the furthest of the drawn positions reaches, by joints: seven are seldom all stretched."""


@pytest.mark.quick
@pytest.mark.parametrize("name", CASES)
def test_no_joint_positions_reach_further_and_some_nearly_as_far(name):
    urdf, tip = CASES[name]
    path = urdf_path(urdf)
    arm = Arm(*arm_of_urdf(path, read_urdf(path, path.parent, str(path), {}).urdf, None, tip))
    reach, state = (
        arm_reach(arm.robot),
        arm.at(np.random.default_rng(4).uniform(-np.pi, np.pi, (DRAWN, arm.com.shape[0]))),
    )
    distance = reach.distance(ArmPlaces(np.eye(3), np.zeros(3), np.eye(3), np.zeros(3)), state.p, state.R)
    assert not np.any(reach.beyond(distance))
    assert np.max(distance) > NEARLY[len(arm.com)] * reach.longest


def test_a_grasp_beyond_all_links_is_refused_without_a_search():
    cell = mrts.load_cell(UR5 / "cell.yaml").with_values({"robots.left.base.xyz": [-3.0, 0, 0]})
    motion = mrts.load_motion(UR5 / "lift_and_turn.yaml")
    with pytest.raises(mrts.MotionError, match=r"robot 'left' cannot reach .* its shoulder and reaches 0.918409 m"):
        mrts.scale(cell, motion)
