"""Rotations as matrices, angles, vectors and quaternions, against scipy's Rotation."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mrts
from mrts.base.errors import InputError
from mrts.base.formats.record import Pose
from mrts.base.load_box import load_vector
from mrts.base.rigid_transform import (
    RigidTransform,
    in_one_place,
    is_rotation,
    quaternions_from_rotations,
    rotation_from_rpy,
    rotations_from_quaternions,
    rotations_from_rpy,
    rotations_from_vectors,
    rpy_from_rotation,
    vectors_from_rotations,
)

NORMALISED = 1e-14  # entries of rotations from quaternions of any length
DRAWS = 200


def test_quaternions_are_those_of_scipy_and_of_the_angles():
    for quaternion in np.random.default_rng(1).normal(size=(DRAWS, 4)):
        rotation = Rotation.from_quat(quaternion)
        x, y, z, w = rotation.as_quat().tolist()
        by_angles = Pose(rpy=rotation.as_euler("xyz").tolist()).rotation()
        for pose in (Pose(quaternion_xyzw=[x, y, z, w]), Pose(quaternion_wxyz=[w, x, y, z])):
            assert np.allclose(pose.rotation(), rotation.as_matrix(), rtol=0, atol=NORMALISED)
            assert np.allclose(pose.rotation(), by_angles, rtol=0, atol=NORMALISED)


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


pytestmark = pytest.mark.quick

ROUNDING = 2e-15  # a few roundings of numbers up to π
TURNS = np.array([*np.eye(3), *-np.eye(3), [1, 1, 0], [0, -1, 1], [1, 1, 1]])
ANGLES = [0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-3, 1.0, np.pi / 2, 3.0, *(np.pi - off for off in (1e-4, 1e-12, 0.0))]


def test_angles_come_back_to_rounding():
    """Also beyond half a turn, and where roll and yaw turn about one axis; two decimals as somebody typed them."""
    rng = np.random.default_rng(3)
    for _ in range(300):
        drawn = rng.uniform(-np.pi, np.pi, 3) * [1, 0.45, 1]
        pitched = [*rng.uniform(-np.pi, np.pi, 1), rng.choice([-np.pi / 2, np.pi / 2]), drawn[2]]
        nearly = pitched[0], pitched[1] + rng.choice([1e-12, 1e-9, 1e-7, 1e-5, 1e-3]), pitched[2]
        for given in (drawn, drawn * 1e-4, 2 * drawn * np.eye(3)[rng.integers(3)], np.round(drawn, 2), pitched, nearly):
            R = rotation_from_rpy(*given)
            np.testing.assert_allclose(R, Rotation.from_euler("xyz", given).as_matrix(), rtol=0, atol=ROUNDING)
            np.testing.assert_allclose(rotation_from_rpy(*rpy_from_rotation(R)), R, rtol=0, atol=ROUNDING)
        assert rpy_from_rotation(rotation_from_rpy(*np.round(drawn, 2))) == np.round(drawn, 2).tolist()
        assert rpy_from_rotation(rotation_from_rpy(*pitched))[2] == 0
        assert rotations_from_rpy(np.array([drawn]))[0].tolist() == rotation_from_rpy(*drawn).tolist()


@pytest.mark.parametrize("angle", ANGLES)
def test_rotation_vectors_are_those_of_scipy_and_come_back(angle):
    drawn = np.concatenate([np.random.default_rng(1).normal(size=(200, 3)), TURNS])
    vectors = drawn / np.linalg.norm(drawn, axis=1, keepdims=True) * angle
    R = rotations_from_vectors(vectors)
    np.testing.assert_allclose(R, Rotation.from_rotvec(vectors).as_matrix(), rtol=0, atol=ROUNDING)
    back = vectors_from_rotations(R)
    if angle <= 3.0:  # at half a turn both axes are right
        np.testing.assert_allclose(back, vectors, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(rotations_from_vectors(back), R, rtol=0, atol=2 * ROUNDING)


def test_quaternions_are_those_of_scipy_whatever_their_largest_entry_length_and_shape():
    given = Rotation.random(1000, random_state=3)
    quaternions = given.as_quat(canonical=True)
    lengths = np.random.default_rng(4).uniform(0.5, 2, (1000, 1))
    np.testing.assert_allclose(rotations_from_quaternions(quaternions * lengths), given.as_matrix(), atol=ROUNDING)
    found = quaternions_from_rotations(given.as_matrix().reshape(10, 100, 3, 3))
    np.testing.assert_allclose(found, quaternions.reshape(10, 100, 4), atol=ROUNDING)
    assert vectors_from_rotations(np.empty((0, 3, 3))).shape == (0, 3)


def test_the_inverse_undoes_a_pose_and_what_is_no_rotation_is_known():
    T = RigidTransform.from_xyz_rpy([0.3, -0.2, 0.7], [0.4, -1.1, 2.2])
    assert in_one_place(T @ T.inverse(), RigidTransform.identity())
    assert not in_one_place(T, RigidTransform(T.R, T.p + 1e-8))
    assert [is_rotation(R) for R in (T.R, -T.R, T.R + 1e-6)] == [True, False, False]
