# SPDX-License-Identifier: MIT
"""How far a retimed motion oversteps limits between the samples at which they were kept."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.retiming.retimed_motion import TimedPiece, between_samples
from mrts.samples.load_sharing import LoadSharing
from mrts.samples.sample_problem import build_sample_problem
from mrts.samples.widening import widening_at
from mrts.solvers import DEFAULT_SOLVER

PLACES = np.array([0.125, 0.375, 0.5, 0.625, 0.875])
"""Where each segment is checked; the error vanishes at its ends."""


@dataclass(frozen=True)
class Excess:
    """The worst excess over a limit between samples, with the best distribution of the torques there.

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
            problem = build_sample_problem(cell, played, sharing=sharing, load=load)
            share = widening_at(problem, 1.0, DEFAULT_SOLVER, "the excess between samples")
            place = int(np.argmax(share))
            if share[place] > worst.share:
                worst = Excess(float(share[place]), part.piece.first + place // len(PLACES))
    return worst
