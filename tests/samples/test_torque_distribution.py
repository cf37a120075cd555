"""The quadratic program against HiGHS in all wrenches, and the effect of W and of limits."""

import numpy as np
import pytest
from conftest import DATA
from reference import ReferenceCell, highs_cost

import mrts

pytestmark = pytest.mark.quick

COST_TOLERANCE = 1e-6  # HiGHS's active-set solver stops near 1e-7


@pytest.mark.parametrize("weights", [None, [1, 2, 3, 4, 5, 6]])
def test_cost_equals_highs_in_full_unknowns(planar_cell, lift, weights):
    c2 = 2.5
    result = mrts.scale(planar_cell, lift, c2, weights=None if weights is None else np.array(weights, float))
    W = np.diag(np.ones(6) if weights is None else weights).astype(float)
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


def test_a_heavier_weight_spares_its_joint(planar_cell, lift):
    free = planar_cell.without_wrench_limits()
    even = mrts.scale(free, lift, "nominal").trajectory.torque
    spared = mrts.scale(free, lift, "nominal", weights=np.array([1, 50, 1, 1, 1, 1.0])).trajectory.torque
    assert np.sum(spared[:, 1] ** 2) < 0.7 * np.sum(even[:, 1] ** 2)


def test_wrench_limits_have_an_effect(planar_cell, lift):
    limited = mrts.scale(planar_cell, lift, "nominal").wrench["left"]
    free = mrts.scale(planar_cell.without_wrench_limits(), lift, "nominal").wrench["left"]
    assert np.max(np.abs(free[:, 0])) > 2.5
    assert np.max(np.abs(limited[:, 0])) <= 2 + 1e-8


@pytest.mark.parametrize("weights", [[1, 1], [1, 1, 1, 1, 1, 0], [1, 1, 1, 1, 1, np.nan], -np.eye(6), [[1, 2], [3, 4]]])
def test_weights_must_be_positive_definite(planar_cell, lift, weights):
    with pytest.raises(mrts.InputError, match="weights"):
        mrts.scale(planar_cell, lift, weights=np.array(weights, dtype=float))
