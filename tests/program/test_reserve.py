"""The least largest share of any limit, and the torques that keep it, against Pinocchio and HiGHS."""

from dataclasses import replace

import numpy as np
import pytest
from cell_bank import random_planar_cell, random_spatial_cell
from draws import seeds
from reference import ReferenceCell, highs_cost
from scipy.optimize import linprog

import mrts
from mrts.limits import limit_rows
from mrts.program.motion_rows import motion_rows
from mrts.program.reserve import least_shares
from mrts.program.sample_problem import build_sample_problem
from mrts.program.torque_distribution import motion_torques

SHARE_TOLERANCE = 1e-8  # of a limit; HiGHS is asked for 1e-10
COST_TOLERANCE = 1e-5  # HiGHS's active-set solver stops near 1e-7 of a limit, where the cost falls by 20 per limit
DRAWS = 12


def random_case(seed, folder):
    """A random cell of two to four arms without velocity limits, its reference, and a c²; some wrenches must press."""
    rng = np.random.default_rng([15, seed])
    draw = random_planar_cell if seed % 5 < 3 else random_spatial_cell
    case = draw(rng, folder, arms=2 + seed % 3 if draw is random_planar_cell else 2 + seed % 2)
    reference, robots = ReferenceCell(case.cell_file), []
    for arm, robot in zip(reference.arms, case.cell.robots, strict=True):
        press = np.isfinite(robot.wrench_upper) & (rng.random(len(robot.wrench_upper)) < 0.2)
        lower = np.where(press, 0.3 * robot.wrench_upper, robot.wrench_lower)
        robots.append(replace(robot, wrench_lower=lower))
        arm.wrench[0] = lower
    return replace(case.cell, robots=tuple(robots)).without_velocity_limits(), case, reference, float(rng.uniform(0, 2))


def highs_share(reference, terms, c2):
    """The least largest share at one sample, over all wrenches and the share, the balance as equations."""
    A, lower, upper, x_lower, x_upper = reference.program(terms, even=False)
    given, free = A[:, -1] * c2, A[:, :-1]
    wrenches = free.shape[1]
    torques = sum(len(arm.torque[0]) for arm in reference.arms)
    size = np.concatenate([arm.torque[1] for arm in reference.arms])
    rows, limits, sizes = (
        [free[:torques], -free[:torques]],
        [(upper - given)[:torques], -(lower - given)[:torques]],
        [size] * 2,
    )
    for sign, bound in ((1, x_upper[:-1]), (-1, x_lower[:-1])):
        finite = np.isfinite(bound)
        rows.append(sign * np.eye(wrenches)[finite])
        limits.append(sign * bound[finite])
        sizes.append(np.abs(bound[finite]))
    size = np.concatenate(sizes)
    found = linprog(
        np.append(np.zeros(wrenches), 1.0),
        A_ub=np.column_stack([np.concatenate(rows), -size]),
        b_ub=np.concatenate(limits) - size,
        A_eq=np.column_stack([free[torques:], np.zeros(len(free) - torques)]),
        b_eq=(lower - given)[torques:],
        bounds=[(None, None)] * wrenches + [(0, None)],
        method="highs-ds",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10, "presolve": False},
    )
    assert found.status == 0, found.message
    return found.fun


def highs_torque_cost(reference, terms, c2, share):
    """The least τᵀτ with every limit at a share of it."""
    A, lower, upper, x_lower, x_upper = reference.program(terms, even=False)
    given, torques = A[:, -1] * c2, sum(len(arm.torque[0]) for arm in reference.arms)
    inward = np.zeros(len(A))
    inward[:torques] = (1 - share) * np.concatenate([arm.torque[1] for arm in reference.arms])
    bounds = [bound[:-1].copy() for bound in (x_lower, x_upper)]
    for bound, sign in zip(bounds, (1, -1), strict=True):
        finite = np.isfinite(bound)
        bound[finite] += sign * (1 - share) * np.abs(bound[finite])
    T, offset = A[:torques, :-1], given[:torques] + np.concatenate(terms.G)
    cost = highs_cost(A[:, :-1], lower - given + inward, upper - given - inward, *bounds, 2 * T.T @ T, 2 * T.T @ offset)
    return cost + offset @ offset


@pytest.mark.parametrize("seed", seeds(4, DRAWS - 4))
def test_both_stages_equal_highs(seed, tmp_path):
    cell, case, reference, c2 = random_case(seed, tmp_path)
    motion = mrts.follow_object(cell, case.motion)
    shares = 1 + least_shares(build_sample_problem(motion_rows(cell, motion)), c2)[0]
    torque, wrench = motion_torques(motion_rows(cell, motion), c2, np.eye(motion.q.shape[1]), distribute="reserve")
    rows = limit_rows(cell, motion)
    used = np.max(rows.share(rows.value(torque, wrench, 0.0, np.sqrt(c2))), axis=1)
    _, samples = reference.object_motion(case.motion_file)
    joints = reference.joint_motion(samples)
    for k, sample in enumerate(samples):
        terms = reference.terms(sample, [arm[k] for arm in joints])
        assert shares[k] == pytest.approx(highs_share(reference, terms, c2), abs=SHARE_TOLERANCE * max(1, shares[k]))
        assert used[k] == pytest.approx(max(shares[k], 0.01), abs=SHARE_TOLERANCE * max(1, shares[k]))
        if k % 5 == 0:
            cost = highs_torque_cost(reference, terms, c2, max(shares[k], 0.01))
            assert torque[k] @ torque[k] == pytest.approx(cost, rel=COST_TOLERANCE)
