# SPDX-License-Identifier: MIT
"""How far a smooth timing oversteps limits between its nodes, where wrenches are linear in time as its torques are."""

import numpy as np

from mrts.base.arrays import Array
from mrts.refinement.excess import Excess
from mrts.retiming.between_samples import PLACES, SegmentExcess
from mrts.retiming.result import RetimingResult
from mrts.retiming.retimed_motion import path_between, retimed
from mrts.retiming.smooth_piece import SmoothPiece, smooth_pieces
from mrts.samples.sample_problem import SampleProblem, build_sample_problem
from mrts.samples.widening import widening_at
from mrts.smooth.path_program import third_derivatives
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
    worst, shares, time = Excess(0.0, tolerance), np.zeros(motion.samples - 1), motion.object.time
    for part in smooth_pieces(timed.pieces):
        path, n = path_between(cell, part, PLACES), len(part.piece.step)
        x, u = part.inside(PLACES)
        played = retimed(path, np.sqrt(x), x, u)
        segment = np.repeat(np.arange(n), len(PLACES))
        share = np.tile(PLACES, n)[:, None]
        f = part.steps.profile.free.shape[1] // len(loads)
        found = _jerk_excess(part, x, u)
        names = np.full(len(found), None, dtype=object)
        for number, load in enumerate(loads):
            free = part.steps.profile.free[:, number * f : (number + 1) * f]
            between = free[segment] * (1 - share) + free[segment + 1] * share
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
        segments = slice(part.piece.first, part.piece.first + n)
        shares[segments] = np.max(found.reshape(n, -1), axis=1)
        most = int(np.argmax(found))
        if found[most] > worst.share:
            start, end = time[part.piece.first + segment[most] :][:2]
            at = float(start + PLACES[most % len(PLACES)] * (end - start))
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


def _jerk_excess(part: SmoothPiece, x: Array, u: Array) -> Array:
    """By how much limits of jerk are passed inside the segments, Shape (k,)."""
    program = part.program
    if not len(program.jerk):
        return np.zeros(len(x))
    h, n = program.step[:, None], len(program.step)
    q3 = third_derivatives(program.step, program.q1, program.q2)
    p = PLACES[:, None]
    third = q3[:, :1] + (q3[:, 1:] - q3[:, :1]) * p
    second = program.q2[:-1, None] + h[:, None] * (q3[:, :1] * p + (q3[:, 1:] - q3[:, :1]) * p**2 / 2)
    first = program.q1[:-1, None] + h[:, None] * (
        program.q2[:-1, None] * p + h[:, None] * (q3[:, :1] * p**2 / 2 + (q3[:, 1:] - q3[:, :1]) * p**3 / 6)
    )
    slope = (np.diff(part.rates, axis=1) / h)[:, :, None]
    x, u = x.reshape(n, -1, 1), u.reshape(n, -1, 1)
    jerk = np.abs(first * slope + 3 * second * u + third * x) * np.sqrt(x)
    excess: Array = np.max((jerk / program.jerk - 1).reshape(len(x) * len(PLACES), -1), axis=1)
    return excess
