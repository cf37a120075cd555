"""The quadratic program against HiGHS in all wrenches, the effect of W and of limits, and samples side by side."""

import numpy as np
import pytest
from changed_robots import with_left
from conftest import DATA, UR5
from reference import ReferenceCell, highs_cost

import mrts
from mrts.program.torque_distribution import WEIGHT_SPREAD, torque_weights

pytestmark = pytest.mark.quick

COST_TOLERANCE = 1e-6  # HiGHS's active-set solver stops near 1e-7


@pytest.mark.parametrize("weights", [None, [1, 2, 3, 4, 5, 6]])
def test_cost_equals_highs_in_full_unknowns(planar_cell, lift, weights):
    c2 = 2.5
    result = mrts.scale(planar_cell, lift, c2, weights=None if weights is None else np.array(weights, float))
    limits = np.concatenate([robot.torque_upper for robot in planar_cell.robots])  # 100, 80, 50 N m, both sides alike
    W = np.diag(100**2 / limits**2 if weights is None else weights).astype(float)  # small ones it never ends
    reference = ReferenceCell(DATA / "cell.yaml")
    _, samples = reference.object_motion(DATA / "lift.yaml")
    joints = reference.joint_motion(samples)
    for k in range(0, len(samples), 20):
        terms = reference.terms(samples[k], [arm[k] for arm in joints])
        A, lower, upper, x_lower, x_upper = reference.program(terms, even=False)
        given = A[:, -1] * c2
        T = np.zeros((6, 6))
        T[:3, :3], T[3:, 3:] = terms.J[0].T, terms.J[1].T
        offset = np.concatenate(terms.E) * c2 + np.concatenate(terms.G)
        cost = highs_cost(
            A[:, :-1], lower - given, upper - given, x_lower[:-1], x_upper[:-1], 2 * T.T @ W @ T, 2 * T.T @ W @ offset
        )
        tau = result.trajectory.torque[k]
        assert tau @ W @ tau == pytest.approx(cost + offset @ W @ offset, rel=COST_TOLERANCE)


def test_weak_joints_are_spared_unless_all_weigh_alike(dual_ur5):
    """The wrists of 28 N m beside shoulders of 150 N m."""
    turning = mrts.load_motion(UR5 / "lift_and_turn.yaml")
    limits = np.concatenate([robot.torque_upper for robot in dual_ur5.robots])
    by_limits, alike, ones = (
        mrts.scale(dual_ur5, turning, 1.0, weights=weights).trajectory.torque for weights in (None, 1, np.ones(12))
    )
    np.testing.assert_array_equal(alike, ones)
    used = [np.max(np.abs(torque) / limits, axis=0) for torque in (by_limits, alike)]
    assert np.max(used[0][limits < 100]) < 0.5 * np.max(used[1][limits < 100])


def test_a_joint_without_a_limit_is_not_spared(planar_cell):
    """It weighs as little as digits allow; one whose limit is next to nothing, as much: the others as ever."""
    most = np.array([np.inf, 80, 1e-9])
    W = np.diag(torque_weights(None, with_left(planar_cell, torque_lower=-most, torque_upper=most)))
    most = WEIGHT_SPREAD**0.25
    np.testing.assert_allclose(W, 1 / np.array([80 * most, 80, 80 / most, 100, 80, 50]) ** 2, rtol=1e-12)
