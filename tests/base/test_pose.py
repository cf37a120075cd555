"""Poses of the files: three ways to write one rotation, and a tip that looks at a point."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mrts.base.errors import InputError
from mrts.base.formats.pose import GraspPose, Pose

ROUNDING = 1e-14
DRAWS = 200


def test_quaternions_are_those_of_scipy_and_of_the_angles():
    for quaternion in np.random.default_rng(1).normal(size=(DRAWS, 4)):
        rotation = Rotation.from_quat(quaternion)
        x, y, z, w = rotation.as_quat().tolist()
        by_angles = Pose(rpy=rotation.as_euler("xyz").tolist()).rotation()
        for pose in (Pose(quaternion_xyzw=[x, y, z, w]), Pose(quaternion_wxyz=[w, x, y, z])):
            assert np.allclose(pose.rotation(), rotation.as_matrix(), rtol=0, atol=ROUNDING)
            assert np.allclose(pose.rotation(), by_angles, rtol=0, atol=ROUNDING)


def test_a_tip_looks_at_the_point_by_the_smallest_turn():
    rng = np.random.default_rng(2)
    for xyz, point in rng.normal(size=(DRAWS, 2, 3)):
        axis, turn = rng.choice(["x", "y", "z", "-x", "-y", "-z"]), float(rng.uniform(-3, 3))
        own = np.eye(3)["xyz".index(axis[-1])] * (-1 if axis[0] == "-" else 1)
        direction = (point - xyz) / np.linalg.norm(point - xyz)
        given = {"xyz": xyz.tolist(), "look_at": point.tolist(), "axis": str(axis)}
        smallest = GraspPose(**given).rotation()
        angle = np.arccos(np.clip(own @ direction, -1, 1))
        assert np.allclose(smallest @ own, direction, rtol=0, atol=ROUNDING)
        assert Rotation.from_matrix(smallest).magnitude() == pytest.approx(angle, abs=1e-7)  # arccos of nearly 1
        turned = GraspPose(**given, turn=turn).rotation()
        assert np.allclose(turned, Rotation.from_rotvec(turn * direction).as_matrix() @ smallest, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(("axis", "about"), [("x", 2), ("y", 2), ("z", 0), ("-x", 2), ("-y", 2), ("-z", 0)])
def test_a_tip_that_looks_back_is_turned_by_half_a_turn(axis, about):
    away = np.eye(3)["xyz".index(axis[-1])] * (1 if axis[0] == "-" else -1)
    expected = Rotation.from_rotvec(np.pi * np.eye(3)[about]).as_matrix().round()
    assert np.array_equal(GraspPose(look_at=away.tolist(), axis=axis).rotation(), expected)


@pytest.mark.parametrize(
    ("given", "rule"),
    [
        ({"rpy": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}, "given once, here by rpy and quaternion_wxyz"),
        ({"quaternion_xyzw": [0, 0, 90, 1]}, "the length of quaternion_xyzw is 90.0056"),
        ({"xyz": [1, 0, 0], "look_at": [1, 0, 0]}, "it points nowhere"),
        ({"axis": "x"}, "'axis' goes with 'look_at' only"),
    ],
)
def test_mistakes_in_a_pose(given, rule):
    with pytest.raises(InputError, match=rule):
        GraspPose.read("file", given)
