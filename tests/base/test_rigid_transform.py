"""Rotations as matrices, angles, vectors and quaternions, against scipy's Rotation."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mrts.base.rigid_transform import (
    RigidTransform,
    angles_of_rotations,
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
    np.testing.assert_allclose(angles_of_rotations(R), angle, rtol=0, atol=ROUNDING)


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
