# SPDX-License-Identifier: MIT
"""How far a smooth timing oversteps limits between its nodes, where wrenches are linear in time as its torques are."""

import numpy as np

from mrts.base.arrays import Array
from mrts.limits.rows import ActiveRow
from mrts.refinement.excess import Excess
from mrts.retiming.between_samples import PLACES, SegmentExcess
from mrts.retiming.result import RetimingResult
from mrts.retiming.retimed_motion import path_between
from mrts.retiming.smooth_piece import SmoothPiece, smooth_pieces
from mrts.samples.sample_problem import SampleProblem, build_sample_problem
from mrts.smooth.path_program import third_derivatives
from mrts.smooth.rate_limits import rate_names


def smooth_excess(timed: RetimingResult, tolerance: float) -> SegmentExcess:
    """The largest excess inside each segment, over the limits of rows and of jerk.

    Torques are commanded linear in time between nodes, so their rates are constant there and kept. What the motion
    needs differs from that by the square of the step; so it is looked at with wrenches that are linear too: those of
    the plan, and where the load varies those that carry each of its corners.

    Args:
        timed: A smooth timing with its plan.
        tolerance: Share of a limit by which it may be overstepped.
    """
    cell, motion, sharing = timed.cell, timed.motion, timed.constant.rule.sharing
    worst, shares, time = Excess(0.0, tolerance), np.zeros(motion.samples - 1), motion.object.time
    for part in smooth_pieces(timed.pieces):
        path, n = path_between(cell, part, PLACES), len(part.piece.step)
        x, u = part.inside(PLACES)
        segment = np.repeat(np.arange(n), len(PLACES))
        share = np.tile(PLACES, n)[:, None]
        found, rows = _jerk_excess(timed, part, x, u)
        for load, free in _carried(timed, part):
            between = free[segment] * (1 - share) + free[segment + 1] * share
            problem = build_sample_problem(cell, path, sharing=sharing, load=load, varying=True)
            over, of = _row_excess(problem, np.column_stack([between, u, x]))
            rows = np.where(over > found, of, rows)
            found = np.maximum(found, over)
        places = slice(part.piece.first, part.piece.first + n)
        shares[places] = np.max(found.reshape(n, -1), axis=1)
        most = int(np.argmax(found))
        if found[most] > worst.share:
            start, end = time[part.piece.first + segment[most] :][:2]
            at = float(start + PLACES[most % len(PLACES)] * (end - start))
            worst = Excess(float(found[most]), tolerance, at, rows[most])
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


def _jerk_excess(timed: RetimingResult, part: SmoothPiece, x: Array, u: Array) -> tuple[Array, Array]:
    """By how much limits of jerk are passed inside the segments, 0 at least, and which most, each Shape (k,)."""
    program = part.program
    rows = np.full(len(x), None, dtype=object)
    if not len(program.jerk):
        return np.zeros(len(x)), rows
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
    jerk = ((first * slope + 3 * second * u + third * x) * np.sqrt(x)).reshape(len(rows), -1)
    over = np.abs(jerk) / program.jerk - 1
    most = np.argmax(over, axis=1)
    names = [name for name in rate_names(timed.cell)[2] if f"{name.robot}/{name.element}" in program.joints]
    for place, joint in enumerate(most.tolist()):
        rises, limit = bool(jerk[place, joint] > 0), float(program.jerk[joint])
        rows[place] = ActiveRow(names[joint], "upper" if rises else "lower", limit if rises else -limit)
    return np.maximum(over[np.arange(len(rows)), most], 0.0), rows
