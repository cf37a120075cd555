# SPDX-License-Identifier: MIT
"""How far a smooth timing oversteps limits between its nodes, where wrenches are linear in time as its torques are."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.refinement.excess import Excess
from mrts.retiming.between_samples import SegmentExcess
from mrts.retiming.result import RetimingResult
from mrts.retiming.retimed_motion import retimed
from mrts.retiming.smooth_piece import SmoothPiece, smooth_pieces
from mrts.samples.sample_problem import SampleProblem, build_sample_problem
from mrts.samples.widening import widening_at
from mrts.solvers import DEFAULT_SOLVER

NEAR = 0.1
"""Share of the tolerance above which linear wrenches are not taken for the best."""


def smooth_excess(timed: RetimingResult, tolerance: float) -> SegmentExcess:
    """The largest excess inside each segment, over the limits of rows and of jerk.

    Torques are commanded linear in time between nodes, so their rates are constant there and kept; what the motion
    needs differs from that by the square of the step. It is looked at with wrenches that are linear too, and where that
    passes a limit, with wrenches that are free to do their best.

    Args:
        timed: A smooth timing.
        tolerance: Share of a limit by which it may be overstepped.
    """
    cell, motion, loads, sharing = timed.cell, timed.motion, timed.loads, timed.constant.rule.sharing
    worst, shares = Excess(0.0, tolerance), np.zeros(motion.samples - 1)
    limited = np.zeros(0, dtype=int) if timed.smooth is None else np.flatnonzero(np.isfinite(timed.smooth.rates.jerk))
    for part in smooth_pieces(timed.pieces):
        segment, share, x, u = part.between()
        path = part.piece.fine.at(part.piece.inside)
        played = retimed(path, np.sqrt(x), x, u)
        f = part.steps.profile.free.shape[1] // len(loads)
        found = _jerk_excess(part, limited, segment, x, u)
        names = np.full(len(found), None, dtype=object)
        for number, load in enumerate(loads):
            free = part.steps.profile.free[:, number * f : (number + 1) * f]
            between = free[segment] * (1 - share[:, None]) + free[segment + 1] * share[:, None]
            problem = build_sample_problem(cell, path, sharing=sharing, load=load, varying=True)
            over, rows = _row_excess(problem, np.column_stack([between, u, x]))
            doubtful = np.flatnonzero(over > NEAR * tolerance)
            if doubtful.size and f > 0:
                places = np.append(doubtful, doubtful[-1])  # a motion has two samples at least
                there = build_sample_problem(cell, played.at(places), sharing=sharing, load=load)
                least = widening_at(there, 1.0, DEFAULT_SOLVER, "the excess between nodes")[:-1]
                over[doubtful] = np.minimum(over[doubtful], least)
            names = np.where(over > found, rows, names)
            found = np.maximum(found, over)
        np.maximum.at(shares, part.piece.first + segment, found)
        most = int(np.argmax(found))
        if found[most] > worst.share:
            at = float(part.piece.given_time[part.piece.inside[most]])
            worst = Excess(float(found[most]), tolerance, at, names[most])
    return SegmentExcess(shares, worst)


def _row_excess(problem: SampleProblem, unknowns: Array) -> tuple[Array, Array]:
    """By how much rows pass their limits, and which does most, each Shape (k,)."""
    values = np.einsum("nrk,nk->nr", problem.A, unknowns)
    if problem.speed is not None:
        values += problem.speed * np.sqrt(unknowns[:, -1:])
    over, under = values - problem.upper, problem.lower - values
    beyond = np.maximum(over, under)
    most = np.argmax(beyond, axis=1)
    k = np.arange(len(values))
    rows = np.empty(len(values), dtype=object)
    for place, row in enumerate(most.tolist()):
        rows[place] = problem.active_row(row, upper=bool(over[place, row] >= under[place, row]))
    return beyond[k, most], rows


def _jerk_excess(part: SmoothPiece, limited: NDArray[np.int_], segment: NDArray[np.int_], x: Array, u: Array) -> Array:
    """By how much limits of jerk are passed between the nodes, Shape (k,)."""
    if not limited.size:
        return np.zeros(len(x))
    path = part.piece
    at, slope = path.inside, np.diff(part.rates, axis=1)[segment] / path.step[segment, None]
    first, second = path.fine.dq[at][:, limited], path.fine.ddq[at][:, limited]
    thirds = np.stack([path.third[at - 1, 1], path.third[at, 0]])[:, :, limited]
    jerk = np.abs(first * slope + 3 * second * u[:, None] + thirds * x[:, None]) * np.sqrt(x)[:, None]
    excess: Array = np.max(jerk / part.program.jerk - 1, axis=(0, 2))
    return excess
