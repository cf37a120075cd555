"""Poses of the files: three ways to write one rotation; principal axes of loads."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mrts
from mrts.base.errors import InputError
from mrts.base.formats.record import Pose
from mrts.base.load_box import load_vector

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


@pytest.mark.parametrize(
    ("given", "rule"),
    [
        ({"rpy": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}, "given once, here by rpy and quaternion_wxyz"),
        ({"quaternion_xyzw": [0, 0, 90, 1]}, "the length of quaternion_xyzw is 90.0056"),
    ],
)
def test_mistakes_in_a_pose(given, rule):
    with pytest.raises(InputError, match=rule):
        Pose.read("file", given)


def test_factors_are_about_the_principal_axes_nearest_to_the_object():
    rng = np.random.default_rng(0)
    for _ in range(100):
        R = Rotation.from_rotvec(rng.normal(size=3) * 0.15).as_matrix()
        moments = rng.uniform(1, 1.9, 3)
        box = mrts.LoadBox(2.0, R * moments @ R.T, {"iyy": (0.5, 3.0)})
        assert np.linalg.det(box.principal_axes) == pytest.approx(1)
        np.testing.assert_allclose(np.sum(box.principal_axes * R, axis=0), 1, atol=1e-6)
        x, y, z = box.principal_moments
        wanted = box.principal_axes @ np.diag([x, 3 * y, z]) @ box.principal_axes.T
        np.testing.assert_allclose(box.load_at({"iyy": 3.0}), load_vector(2.0, np.zeros(3), wanted), atol=1e-12)


def test_equal_moments_take_the_nearest_of_all_axes():
    rng = np.random.default_rng(6)
    for _ in range(300):
        R = Rotation.random(rng=rng).as_matrix()
        moments = np.array([1.0, 2.0, 2.0])
        axes = mrts.LoadBox(1.0, R * moments @ R.T, {"ixx": (0.5, 2)}).principal_axes
        best = 0.0
        for place in range(3):  # which axis of the object is nearest to the single one
            others = [axis for axis in range(3) if axis != place]
            best = max(best, abs(R[place, 0]) + np.linalg.svd(R[np.ix_(others, [1, 2])], compute_uv=False).sum())
        assert np.sum(np.abs(np.diag(axes))) == pytest.approx(best, abs=1e-9)
    for equal in ([1, 1, 1], [1, 1, 1.5], [1, 1.5, 1]):
        assert mrts.LoadBox(1.0, np.diag(np.array(equal, float)), {"ixx": (0.5, 2)}).axes_are_the_objects
