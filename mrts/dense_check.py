# SPDX-License-Identifier: MIT
"""How far a retimed motion oversteps limits between the samples at which they were kept."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mrts.cell import Cell
from mrts.convex_program import ConvexPrograms, require_verified, solve_programs
from mrts.load_sharing import LoadSharing
from mrts.retimed_motion import TimedPiece, between_samples
from mrts.rigid_transform import Array
from mrts.sample_problem import SampleProblem, build_sample_problem
from mrts.solvers import DEFAULT_SOLVER

PLACES = np.array([0.125, 0.375, 0.5, 0.625, 0.875])
"""Where each segment is checked; the error vanishes at its ends."""


@dataclass(frozen=True)
class Excess:
    """The worst overstepping between samples, with the best distribution of the torques there.

    Attributes:
        share: Of a limit; 0 if all are kept.
        sample: Start of the segment where it is worst.
    """

    share: float
    sample: int


def largest_excess(
    cell: Cell, pieces: Sequence[TimedPiece], sharing: LoadSharing | None, loads: Sequence[Array]
) -> Excess:
    """The least widening of all limits that admits the motion everywhere between its samples.

    Args:
        cell: The cell.
        pieces: The retimed path.
        sharing: A fixed distribution of the load, None for a free one.
        loads: Load vectors that are to be carried, each Shape (10,).

    Raises:
        SolverError: If no solver answers.
    """
    worst = Excess(0.0, 0)
    for part in pieces:
        played = between_samples(cell, part, PLACES)
        for load in loads:
            share = _widening(build_sample_problem(cell, played, sharing=sharing, load=load))
            place = int(np.argmax(share))
            if share[place] > worst.share:
                worst = Excess(float(share[place]), part.piece.first + place // len(PLACES))
    return worst


def _widening(problem: SampleProblem) -> Array:
    """Least s by which limits must move outward, in units of limits, to admit c² = 1, Shape (N,)."""
    count, rows, unknowns = problem.A.shape
    by_speed = problem.A[:, :, -1]
    lower, upper = problem.lower - by_speed, problem.upper - by_speed
    if unknowns == 1:
        return np.asarray(np.max(np.maximum(lower, -upper), axis=1, initial=0.0), dtype=np.float64)
    A = np.zeros((count, 2 * rows, unknowns))
    A[:, :rows, :-1] = A[:, rows:, :-1] = problem.A[:, :, :-1]
    A[:, :rows, -1], A[:, rows:, -1] = -1.0, 1.0
    g = np.zeros((count, unknowns))
    g[:, -1] = 1.0
    x_lower = np.full((count, unknowns), -np.inf)
    x_lower[:, -1] = 0.0
    unbounded = np.full((count, rows), np.inf)
    programs = ConvexPrograms(
        None,
        g,
        A,
        np.concatenate([-unbounded, lower], axis=1),
        np.concatenate([upper, unbounded], axis=1),
        x_lower,
        np.full((count, unknowns), np.inf),
    )
    answers = solve_programs(programs, DEFAULT_SOLVER)
    require_verified(answers, "the overstepping between samples")
    return np.asarray(answers.x[:, -1], dtype=np.float64)
