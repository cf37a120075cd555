# SPDX-License-Identifier: MIT
"""Torques at a speed that the limits do not admit: the limits moved outward as little as possible, sample by sample."""

from dataclasses import replace

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.motion_rows import motion_rows
from mrts.program.reserve import reserved
from mrts.program.sample_problem import SampleProblem
from mrts.program.torque_distribution import torque_weights, torques_by_blocks
from mrts.program.widening import widening_at
from mrts.scaling.options import Options

INTERIOR = 1e-6
"""A widened limit is widened by this share more: at the least widening the feasible set is a point."""


def widened_torques(cell: Cell, motion: CoordinatedMotion, options: Options, c2: float) -> tuple[Array, Array]:
    """Torques, Shape (N, m), and wrenches, Shape (N, n w), at any c² > 0.

    At a sample that keeps its limits at this c² they are those of `distributed_torques`. At any other, all limits are
    first moved outward by the least share of their size that leaves a solution, so that what is beyond its limit is
    what forbids the speed. A fixed distribution asks no limits.

    Raises:
        InputError: If an option breaks a rule.
        SolverError: If no solver answers.
    """
    solver, by_reserve = options.solver, options.distribute == "reserve"
    cell = cell.with_reserve(0.0) if by_reserve else cell  # it is of the limits as they are given
    W = torque_weights(options.weights, cell)

    def widened(problem: SampleProblem) -> tuple[SampleProblem, int]:
        problem = problem.only(np.flatnonzero(~problem.is_cap))  # no torques change what the speed alone moves
        widening = _least_widening(problem, c2, solver)[:, None]
        problem = replace(problem, lower=problem.lower - widening, upper=problem.upper + widening)
        return reserved(problem, c2, solver) if by_reserve else (problem, 0)

    rows = motion_rows(cell, motion, options.sharing, options.formulation)
    return torques_by_blocks(rows, solver, c2, W, within=widened)[:2]


def _least_widening(problem: SampleProblem, c2: float, solver: str) -> Array:
    """The share by which all limits of a sample must move outward, Shape (N,)."""
    if problem.unknowns == 1:
        return np.zeros(problem.samples)
    share = widening_at(problem, c2, solver, f"how far limits are passed at c² = {c2:g}")
    return np.where(share > INTERIOR, share * (1 + INTERIOR), share)
