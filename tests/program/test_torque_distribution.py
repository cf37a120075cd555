"""The quadratic program against HiGHS in all wrenches, the effect of W and of limits, and samples side by side."""

import numpy as np
import pytest
from changed_robots import with_left
from conftest import DATA, UR5
from random_motors import equipped
from reference import ReferenceCell, highs_cost
from shipped_cells import sampled, shipped_motion

import mrts
from mrts.base.manifest import GEOMETRY
from mrts.base.torque_weights import WEIGHT_SPREAD
from mrts.kernel.programs import OPTIMAL, STOPPED
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_ranges import motion_ranges
from mrts.program.torque_distribution import least_torques, torque_weights

pytestmark = pytest.mark.quick

COST_TOLERANCE = 1e-6  # HiGHS's active-set solver stops near 1e-7

SAME = 1e-8
"""Of the largest torque: at the end of a range the programs' widening of 1e-9 is all that is left to choose from."""

SAMPLES = 261
"""Two chunks, and a last group of four that is not full."""


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
        mrts.scale(dual_ur5, turning, "nominal", weights=weights).trajectory.torque
        for weights in (None, 1, np.ones(12))
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


def with_given_force(cell):
    """The cell with a force of the first arm that both limits fix, which is then active at every sample."""
    robot = cell.robots[0]
    lower, upper = robot.wrench_lower.copy(), robot.wrench_upper.copy()
    lower[0] = upper[0] = 5.0
    return with_left(cell, wrench_lower=lower, wrench_upper=upper)


CELLS = {
    "as it is": lambda cell: cell,
    "with motors": lambda cell: equipped(cell, armature=0.3, coulomb=2.0),
    "with a given force": with_given_force,
}


@pytest.mark.parametrize("kind", CELLS)
def test_least_torques_do_not_depend_on_the_samples_beside_them(kind, dual_ur5):
    """Alone a sample starts cold; beside others it has the rows of the one before. Some of these cannot be played."""
    rng = np.random.default_rng([19, list(CELLS).index(kind)])
    cell = CELLS[kind](dual_ur5).without_velocity_limits()
    motion = mrts.follow_object(cell, sampled(shipped_motion("dual_ur5", samples=SAMPLES)))
    rows, inputs = motion_rows(cell, motion), motion.inputs(cell.load)
    ends = motion_ranges(motion_rows(cell, motion), "kernel")
    share = rng.choice([0.9, 1.0, 1.2], p=[0.8, 0.1, 0.1], size=SAMPLES)
    c2 = ends.lower + share * (np.minimum(ends.upper, 10 * np.median(ends.upper)) - ends.lower)
    no_number = rng.choice(SAMPLES, size=6, replace=False)
    inputs["ddq"] = inputs["ddq"].copy()
    inputs["ddq"][no_number, 3] = np.nan
    G = rng.normal(size=(12, 12))
    W = G @ G.T + np.eye(12)

    def least(samples):
        some = {name: value[samples] if value.ndim > 1 else value for name, value in inputs.items()}
        here = some | {GEOMETRY: cell.geometry}
        terms = rows.terms(1.0).at(samples)
        return least_torques(cell.library, here, rows.sparse, terms, c2[samples], W)

    every = np.arange(SAMPLES)
    torque, wrench, status = least(every)
    alone = [np.concatenate(parts) for parts in zip(*(least(every[[n]]) for n in every), strict=True)]
    np.testing.assert_array_equal(status, alone[2])
    assert np.all(status[no_number] == STOPPED)
    assert 10 < np.count_nonzero(status != OPTIMAL) < SAMPLES / 3
    found = status == OPTIMAL
    for ours, theirs in ((torque, alone[0]), (wrench, alone[1])):
        np.testing.assert_allclose(ours[found], theirs[found], rtol=0, atol=SAME * np.max(np.abs(theirs[found])))
    for count in (1, 2, 3, 5, 257):
        for part, whole in zip(least(every[:count]), (torque, wrench, status), strict=True):
            np.testing.assert_array_equal(part[status[:count] == OPTIMAL], whole[:count][status[:count] == OPTIMAL])
