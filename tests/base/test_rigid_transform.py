"""Roll, pitch and yaw come back from the rotation that they gave."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mrts.base.rigid_transform import RigidTransform, in_one_place, is_rotation, rotation_from_rpy, rpy_from_rotation

pytestmark = pytest.mark.quick

ROUNDING = 1e-15

KINDS = ("any", "two decimals", "whole degrees", "small", "about one axis", "more than half a turn", "a right angle")


def angles(kind, rng):
    """Angles as people and programs write them."""
    drawn = rng.uniform(-np.pi, np.pi, 3) * [1, 0.45, 1]
    return {
        "any": drawn,
        "two decimals": np.round(drawn, 2),
        "whole degrees": np.radians(np.round(np.degrees(drawn))),
        "small": drawn * 1e-4,
        "about one axis": drawn * np.eye(3)[rng.integers(3)],
        "more than half a turn": drawn * np.eye(3)[rng.integers(3)] * 2,
        "a right angle": drawn * [1, 1, 0] + [0, 0, np.pi / 2],
    }[kind]


@pytest.mark.parametrize("kind", KINDS)
def test_a_rotation_comes_back(kind):
    rng = np.random.default_rng(3)
    for _ in range(100):
        given = angles(kind, rng)
        R = rotation_from_rpy(*given)
        found = rpy_from_rotation(R)
        np.testing.assert_allclose(rotation_from_rpy(*found), R, rtol=0, atol=ROUNDING)
        if kind == "two decimals":
            assert found == given.tolist()  # as somebody typed them


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_where_roll_and_yaw_turn_about_one_axis_it_comes_back_to_rounding(pitch):
    rng = np.random.default_rng(4)
    for _ in range(100):
        roll, yaw = rng.uniform(-np.pi, np.pi, 2)
        R = rotation_from_rpy(roll, pitch, yaw)
        found = rpy_from_rotation(R)
        assert found[2] == 0
        np.testing.assert_allclose(rotation_from_rpy(*found), R, rtol=0, atol=ROUNDING)


def test_any_rotation_has_angles():
    """Those of scipy, whose 'xyz' is URDF's convention."""
    for rotation in Rotation.random(50, random_state=5):
        R = rotation.as_matrix()
        np.testing.assert_allclose(Rotation.from_euler("xyz", rpy_from_rotation(R)).as_matrix(), R, rtol=0, atol=1e-14)
        assert is_rotation(R)
        assert not is_rotation(-R)
        assert not is_rotation(R + 1e-6)


def test_the_inverse_undoes_a_pose():
    T = RigidTransform.from_xyz_rpy([0.3, -0.2, 0.7], [0.4, -1.1, 2.2])
    assert in_one_place(T @ T.inverse(), RigidTransform.identity())
    assert not in_one_place(T, RigidTransform(T.R, T.p + 1e-8))
