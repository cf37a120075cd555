"""Hands of published URDFs, found by name; chains between them and their bases."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from published_robots import ROBOTS

from mrts.cell.generation import arm_of_urdf, read_urdf
from mrts.starting.arm import Arm
from mrts.starting.tips import first_link, hands

EXACT = 1e-12
"""Two ways to add up the same few numbers."""

FOUND = {
    "panda_description/urdf/panda.urdf": ("panda_link0", ["panda_hand_tcp"]),
    "kinova_description/robots/kinova.urdf": ("base", ["j2s6s200_end_effector"]),
    "z1_description/urdf/z1.urdf": ("world", ["gripperStator"]),
    "baxter_description/urdf/baxter.urdf": ("base", ["left_gripper", "right_gripper"]),
    "tiago_description/robots/tiago_dual.urdf": (
        "torso_lift_link",
        ["hand_left_grasping_frame", "hand_right_grasping_frame"],
    ),
    "talos_data/robots/talos_reduced.urdf": ("torso_2_link", ["wrist_left_ft_tool_link", "wrist_right_ft_tool_link"]),
    "romeo_description/urdf/romeo.urdf": ("torso", ["l_gripper", "r_gripper"]),
    "centauro_description/urdf/centauro.urdf": ("torso_2", ["ball1", "ball2"]),
    "alex_description/urdf/alex_sake_hands.urdf": ("Torso", ["LeftSakePalmLink", "RightSakePalmLink"]),
}
"""Where the chains begin, and the hands: with fingers, cameras and feet in the same file."""


def tree_of(path):
    return read_urdf(Path("here"), Path("/"), str(path))[1]


def arm_of(path, tip):
    return Arm(*arm_of_urdf(path, tree_of(path), None, tip), path)


@pytest.mark.parametrize("urdf", FOUND)
def test_hands_are_found_among_fingers_cameras_and_feet(urdf):
    tree = tree_of(ROBOTS / urdf)
    tips = sorted(hands(tree))
    assert (first_link(tree, tips), tips) == FOUND[urdf]


@pytest.mark.parametrize(
    ("urdf", "tip"),
    [
        ("panda_description/urdf/panda.urdf", "panda_hand_tcp"),
        ("tiago_description/robots/tiago.urdf", "hand_grasping_frame"),
    ],
)
def test_places_jacobians_and_torques_at_rest_are_those_of_pinocchio(urdf, tip):
    """Also of a chain with a joint that slides."""
    path = ROBOTS / urdf
    arm = arm_of(path, tip)
    model = pin.buildModelFromUrdf(str(path))
    data, frame = model.createData(), model.getFrameId(tip)
    places = [model.joints[model.getJointId(name)].idx_v for name in arm.robot.joints]
    q = np.random.default_rng(3).uniform(-1, 1, (3, len(places)))
    state = arm.at(q)
    force = np.array([3.0, -2.0, 5.0])
    torque = arm.torque(state, np.array([0, 0, -9.81]), force)
    for sample, joints in enumerate(q):
        whole = pin.neutral(model)
        for name, position in zip(arm.robot.joints, joints, strict=True):
            whole[model.joints[model.getJointId(name)].idx_q] = position
        pin.framesForwardKinematics(model, data, whole)
        jacobian = pin.computeFrameJacobian(model, data, whole, frame, pin.LOCAL_WORLD_ALIGNED)[:, places]
        wanted = pin.computeGeneralizedGravity(model, data, whole)[places] + jacobian[:3].T @ force
        assert state.p[sample] == pytest.approx(data.oMf[frame].translation, abs=EXACT)
        assert state.R[sample] == pytest.approx(data.oMf[frame].rotation, abs=EXACT)
        assert state.jacobian[sample] == pytest.approx(jacobian, abs=EXACT)
        assert torque[sample] == pytest.approx(wanted, abs=1e3 * EXACT)
