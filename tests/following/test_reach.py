"""How far arms reach, against joint positions drawn at random."""

import numpy as np
import pytest
from conftest import DATA

import mrts
from mrts.following.reach import ArmPlaces, arm_reach

DRAWN = 20_000


@pytest.mark.quick
def test_no_joint_positions_reach_further_and_some_nearly_as_far():
    cell = mrts.load_cell(DATA.parent / "dual_ur5" / "cell.yaml")
    q = np.random.default_rng(4).uniform(-np.pi, np.pi, (DRAWN, 12))
    q[: DRAWN // 2, [2, 8]] *= 0.02  # elbows nearly straight
    poses = cell.functions("kinematics", DRAWN, {"q": q, "geometry": cell.geometry})
    positions = poses["position"].reshape(DRAWN, 3, 2)
    for arm, robot in enumerate(cell.robots):
        reach = arm_reach(robot)
        places = ArmPlaces(robot.T_world_base.R, robot.T_world_base.p, np.eye(3), np.zeros(3))
        rotation = poses["rotation"][:, :, 3 * arm : 3 * arm + 3]
        distance = reach.distance(places, positions[:, :, arm], rotation)
        assert not np.any(reach.beyond(distance))
        assert np.max(distance) > 0.999 * reach.longest


def test_a_grasp_beyond_all_links_is_refused_without_a_search():
    cell = mrts.load_cell(DATA.parent / "dual_ur5" / "cell.yaml").with_values({"robots.left.base.xyz": [-3.0, 0, 0]})
    motion = mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml")
    with pytest.raises(mrts.MotionError, match=r"robot 'left' cannot reach .* its shoulder and reaches 0.918409 m"):
        mrts.scale(cell, motion)
