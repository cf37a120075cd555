"""Rotation vectors, quaternions and matrices, against scipy's Rotation."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mrts.base.rigid_transform import (
    angles_of_rotations,
    quaternions_from_rotations,
    rotations_from_quaternions,
    rotations_from_rpy,
    rotations_from_vectors,
    vectors_from_rotations,
)

pytestmark = pytest.mark.quick

ROUNDING = 2e-15  # a few roundings of numbers up to π
TURNS = np.array([[0, 0, 0], *np.eye(3), *-np.eye(3), [1, 1, 0], [0, -1, 1], [1, 1, 1]])
ANGLES = [0.0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-4, 1e-3, 0.01, 1.0, np.pi / 2, 2.0, 3.0]
NEAR_PI = [np.pi - off for off in (1e-2, 1e-4, 1e-8, 1e-12, 1e-15, 0.0)]


def axes(count, seed):
    """Unit vectors: random ones, and those along coordinate axes and their diagonals."""
    drawn = np.random.default_rng(seed).normal(size=(count, 3))
    given = np.concatenate([drawn, TURNS[1:]])
    return given / np.linalg.norm(given, axis=1, keepdims=True)


@pytest.mark.parametrize("angle", [*ANGLES, *NEAR_PI])
def test_a_rotation_vector_gives_the_rotation_of_scipy_and_comes_back(angle):
    vectors = axes(200, 1) * angle
    R = rotations_from_vectors(vectors)
    np.testing.assert_allclose(R, Rotation.from_rotvec(vectors).as_matrix(), rtol=0, atol=ROUNDING)
    back = vectors_from_rotations(R)
    np.testing.assert_allclose(np.linalg.norm(back, axis=1), min(angle, np.pi), rtol=0, atol=ROUNDING)
    if angle <= 3.0:  # at half a turn both axes are right
        np.testing.assert_allclose(back, vectors, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(back, Rotation.from_matrix(R).as_rotvec(), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(rotations_from_vectors(back), R, rtol=0, atol=2 * ROUNDING)


def test_more_than_half_a_turn_comes_back_as_the_shorter_one():
    vectors = axes(50, 2) * 4.0
    back = vectors_from_rotations(rotations_from_vectors(vectors))
    np.testing.assert_allclose(back, vectors * (1 - 2 * np.pi / 4.0), rtol=0, atol=2 * ROUNDING)


def test_quaternions_are_those_of_scipy_whatever_their_largest_entry_and_length():
    given = Rotation.random(1000, random_state=3)
    quaternions = given.as_quat(canonical=True)
    assert set(np.argmax(np.abs(quaternions), axis=1)) == {0, 1, 2, 3}
    lengths = np.random.default_rng(4).uniform(0.5, 2, (1000, 1))
    np.testing.assert_allclose(rotations_from_quaternions(quaternions * lengths), given.as_matrix(), atol=ROUNDING)
    np.testing.assert_allclose(quaternions_from_rotations(given.as_matrix()), quaternions, atol=ROUNDING)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-9])
def test_pitch_of_a_right_angle(pitch):
    rpy = np.random.default_rng(5).uniform(-np.pi, np.pi, (100, 3))
    rpy[:, 1] = pitch
    R = rotations_from_rpy(rpy)
    np.testing.assert_allclose(R, Rotation.from_euler("xyz", rpy).as_matrix(), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(rotations_from_vectors(vectors_from_rotations(R)), R, rtol=0, atol=2 * ROUNDING)


def test_leading_axes_are_kept():
    R = Rotation.random(6, random_state=6).as_matrix()
    for shape in ((), (6,), (2, 3), (1, 6, 1)):
        part = R[0] if shape == () else R.reshape(*shape, 3, 3)
        vectors = vectors_from_rotations(part)
        assert vectors.shape == (*shape, 3)
        assert quaternions_from_rotations(part).shape == (*shape, 4)
        np.testing.assert_allclose(rotations_from_vectors(vectors), part, rtol=0, atol=2 * ROUNDING)
    assert vectors_from_rotations(np.empty((0, 3, 3))).shape == (0, 3)


def test_a_rotation_vector_that_follows_a_path_turns_by_its_velocity():
    """d/dt R = ω× R by central differences, ω by the left Jacobian of rotation vectors."""
    rng = np.random.default_rng(7)
    step = 1e-6
    for _ in range(50):
        v, dv = rng.normal(size=3), rng.normal(size=3)
        t, across = np.linalg.norm(v), np.cross(np.eye(3), v)
        jacobian = np.eye(3) + (1 - np.cos(t)) / t**2 * across + (t - np.sin(t)) / t**3 * across @ across
        after, before = rotations_from_vectors(np.array([v + step * dv, v - step * dv]))
        turned = vectors_from_rotations(after @ before.T) / (2 * step)
        np.testing.assert_allclose(turned, jacobian @ dv, rtol=0, atol=1e-8)


def test_angles_are_the_lengths_of_rotation_vectors():
    """Scipy's, from nothing to half a turn."""
    rng = np.random.default_rng(7)
    axes = rng.standard_normal((200, 3))
    angles = np.concatenate([[0.0, 1e-12, 1e-6, np.pi - 1e-6], rng.uniform(0, np.pi, 196)])
    R = Rotation.from_rotvec(axes / np.linalg.norm(axes, axis=1)[:, None] * angles[:, None]).as_matrix()
    np.testing.assert_allclose(angles_of_rotations(R), angles, rtol=0, atol=ROUNDING)
