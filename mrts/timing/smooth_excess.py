# SPDX-License-Identifier: MIT
"""How far a smooth timing oversteps limits between its nodes, where wrenches are linear in time as its torques are."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.limits.rows import ActiveRow
from mrts.program.excess import Excess
from mrts.program.rate_limits import rate_names
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.timing.between_samples import SegmentExcess
from mrts.timing.result import RetimingResult
from mrts.timing.smooth_piece import SmoothPiece, smooth_pieces


def smooth_excess(timed: RetimingResult, tolerance: float) -> SegmentExcess:
    """The largest excess inside each segment, over the limits of rows and of jerk.

    Torques are commanded linear in time between nodes, so their rates are constant there and kept; what the motion
    needs differs from that by the square of the step. So it is looked at with wrenches that are linear too: those of
    the plan, and where the load varies those that carry each of its corners.

    Args:
        timed: A smooth timing with its plan.
        tolerance: Share of a limit by which it may be overstepped.
    """
    cell, motion, sharing = timed.cell, timed.motion, timed.options.sharing
    worst, shares = Excess(0.0, tolerance), np.zeros(motion.samples - 1)
    limited = np.zeros(0, dtype=int) if timed.smooth is None else np.flatnonzero(np.isfinite(timed.smooth.rates.jerk))
    for part in smooth_pieces(timed.pieces):
        segment, share, x, u = part.between()
        path = part.piece.fine.at(part.piece.inside)
        found, names = _jerk_excess(timed, part, limited, segment, x, u)
        for load, free in _carried(timed, part):
            between = free[segment] * (1 - share[:, None]) + free[segment + 1] * share[:, None]
            problem = build_sample_problem(cell, path, sharing=sharing, load=load, varying=True)
            over, rows = _row_excess(problem, np.column_stack([between, u, x]))
            names = np.where(over > found, rows, names)
            found = np.maximum(found, over)
        np.maximum.at(shares, part.piece.first + segment, found)
        most = int(np.argmax(found))
        if found[most] > worst.share:
            at = float(part.piece.given_time[part.piece.inside[most]])
            worst = Excess(float(found[most]), tolerance, at, names[most])
    return SegmentExcess(shares, worst)


def _carried(timed: RetimingResult, part: SmoothPiece) -> list[tuple[Array, Array]]:
    """Loads with the free wrenches that carry them at the nodes: the plan's, and those of the corners of a box."""
    carried = [(timed.cell.load, part.plan)]
    if len(timed.loads) > 1:
        carried += zip(timed.loads, np.split(part.steps.profile.free, len(timed.loads), axis=1), strict=True)
    return carried


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


def _jerk_excess(
    timed: RetimingResult, part: SmoothPiece, limited: NDArray[np.int_], segment: NDArray[np.int_], x: Array, u: Array
) -> tuple[Array, NDArray[np.object_]]:
    """By how much limits of jerk are passed between the nodes, 0 at least, and which most, each Shape (k,)."""
    rows = np.full(len(x), None, dtype=object)
    if not limited.size or not len(x):
        return np.zeros(len(x)), rows
    path = part.piece
    at, slope = path.inside, np.diff(part.rates, axis=1)[segment] / path.step[segment, None]
    first, second = path.fine.dq[at][:, limited], path.fine.ddq[at][:, limited]
    thirds = np.stack([path.third[at - 1, 1], path.third[at, 0]])[:, :, limited]
    jerk = np.max(np.abs(first * slope + 3 * second * u[:, None] + thirds * x[:, None]), axis=0) * np.sqrt(x)[:, None]
    over = jerk / part.program.jerk - 1
    most, names = np.argmax(over, axis=1), rate_names(timed.cell)[2]
    for place, joint in enumerate(most.tolist()):
        rows[place] = ActiveRow(names[limited[joint]], "upper", float(part.program.jerk[joint]))
    return np.maximum(over[np.arange(len(rows)), most], 0.0), rows
