# SPDX-License-Identifier: MIT
"""Torques at a speed that the limits do not admit: the limits stretched as little as possible, sample by sample."""

from dataclasses import replace

import numpy as np

from mrts.cell import Cell
from mrts.convex_program import ConvexPrograms, require_verified, solve_programs
from mrts.coordinated_motion import CoordinatedMotion
from mrts.result import BLOCK, DistributionRule
from mrts.rigid_transform import Array
from mrts.sample_problem import SampleProblem, build_sample_problem
from mrts.torque_distribution import distribute_torques, torque_weights

INTERIOR = 1e-6
"""A stretched limit is stretched by this share more: at the least stretch the feasible set is a point."""


def stretched_torques(
    cell: Cell, motion: CoordinatedMotion, rule: DistributionRule, c2: float, solver: str
) -> tuple[Array, Array]:
    """Torques, Shape (N, m), and wrenches, Shape (N, n w), at any c² > 0.

    At a sample that keeps its limits at this c² they are those of `motion_torques`. At any other, all limits are first
    moved outward by the least share of their size that leaves a solution, so that what is beyond its limit is what
    forbids the speed. A fixed distribution asks no limits.

    Args:
        cell: The cell, with its load.
        motion: Its motion.
        rule: How torques are distributed.
        c2: Chosen c².
        solver: Name in the registry.

    Raises:
        InputError: If an argument breaks a rule.
        SolverError: If no solver answers.
    """
    W = torque_weights(rule.weights, motion.q.shape[1])
    torques, wrenches = [], []
    for start in range(0, motion.samples, BLOCK):
        block = np.arange(start, min(start + BLOCK, motion.samples))
        free = cell.without_velocity_limits()  # no torques change a velocity
        problem = build_sample_problem(free, motion, rule.formulation, rule.sharing, samples=block)
        room = _least_stretch(problem, c2, solver)[:, None] * problem.is_limit
        problem = replace(problem, lower=problem.lower - room, upper=problem.upper + room)
        x, _ = distribute_torques(problem, c2, W, solver)
        torques.append(problem.torque(x))
        wrenches.append(problem.wrench(x))
    return np.concatenate(torques), np.concatenate(wrenches)


def _least_stretch(problem: SampleProblem, c2: float, solver: str) -> Array:
    """The share by which all limits of a sample must move outward, Shape (N,): min s, lower - s <= A x <= upper + s."""
    count, _, unknowns = problem.A.shape
    if unknowns == 1:
        return np.zeros(count)
    given = problem.A[:, :, -1] * c2
    limits, laws = np.flatnonzero(problem.is_limit), np.flatnonzero(~problem.is_limit)
    # each limit twice, once a side, as s moves them in opposite senses; laws once, as they are
    order = np.concatenate([limits, limits, laws])
    outward = np.repeat([1.0, -1.0, 0.0], [len(limits), len(limits), len(laws)])
    moved = np.broadcast_to(outward[:, None], (count, len(order), 1))
    g = np.zeros((count, unknowns))
    g[:, -1] = 1
    x_lower = np.full((count, unknowns), -np.inf)
    x_lower[:, -1] = 0
    programs = ConvexPrograms(
        None,
        g,
        np.concatenate([problem.A[:, order, :-1], moved], axis=2),
        np.where(outward < 0, -np.inf, (problem.lower - given)[:, order]),
        np.where(outward > 0, np.inf, (problem.upper - given)[:, order]),
        x_lower,
        np.full_like(x_lower, np.inf),
    )
    answers = solve_programs(programs, solver)
    require_verified(answers, f"how far limits are passed at c² = {c2:g}")
    stretch = answers.x[:, -1]
    return np.where(stretch > INTERIOR, stretch * (1 + INTERIOR), stretch)
