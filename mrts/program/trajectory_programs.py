# SPDX-License-Identifier: MIT
"""The programs of a whole trajectory: by the compiled kernel in one call, or put together here for another solver."""

from dataclasses import replace
from functools import partial

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.programs import OPTIMAL
from mrts.program.formulation import DistributionName
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.range_ends import intervals_below, kernel_ends, with_caps
from mrts.program.reserve import reserved
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.sample_ranges import (
    REST_TOLERANCE,
    SampleRanges,
    decide,
    ranges_of_ends,
    sample_ranges,
    without_speed_at_rest,
)
from mrts.program.solvers import DEFAULT_SOLVER, check_solver
from mrts.program.torque_distribution import BLOCK, least_torques, torques_by_blocks

MOST_ROWS = 32_767
"""The compiled path keeps the rows of each sample's answer as 16-bit numbers."""


def motion_ranges(
    rows: MotionRows, solver: str = DEFAULT_SOLVER, load: Array | None = None, high: float = np.inf
) -> SampleRanges:
    """Least and largest c² at every sample (step 1 of MMTSF).

    Args:
        rows: Of a cell along its motion.
        solver: Name in the registry; "kernel" takes the compiled path where it applies.
        load: Load vector instead of the cell's, Shape (10,), or one a sample, Shape (N, 10).
        high: Of several intervals the highest is found that does not begin above this c².
    """
    time, of_sample = rows.motion.object.time, partial(_problem_of_sample, rows.cell, rows.motion, rows.sharing, load)
    if not _is_for_kernel(rows, solver) or rows.one_unknown:
        problem = build_sample_problem(rows, load=load)
        found = sample_ranges(problem, time, solver, high)
        return replace(found, problem=None if problem.unknowns == 1 and problem.speed is None else of_sample)
    find = partial(kernel_ends, rows.cell.library, rows.inputs(load), rows)
    ends = intervals_below(find, rows.most, high) if rows.has_speed_terms else find(rows.most)
    ends.lower, ends.upper = ends.lower + 0.0, ends.upper + 0.0  # 0 has no sign
    effect = float(np.max(ends.effect, initial=0.0))
    at_rest = ends.effect <= REST_TOLERANCE * effect
    ends.upper[at_rest], ends.codes[1, at_rest] = rows.most[at_rest], 0
    suspects = np.flatnonzero((ends.status != OPTIMAL) | (at_rest & (ends.lower > 0)))
    ends, conflicts = with_caps(ends, rows.cap_share, rows.cap_code), []
    for start in range(0, len(suspects), BLOCK):
        block = suspects[start : start + BLOCK]
        problem = without_speed_at_rest(build_sample_problem(rows, load=load, samples=block), effect)
        conflicts += decide(ends, block, problem, time, solver, high)
    found = ranges_of_ends(time, ends, conflicts, rows.given.names, (rows.given.lower, rows.given.upper))
    return replace(found, problem=of_sample)


def _problem_of_sample(
    cell: Cell,
    motion: CoordinatedMotion,
    sharing: LoadSharing | None,
    known: Array | None,
    sample: int,
    load: Array | None,
) -> SampleProblem:
    """It holds no rows: those of C stay in their process, where results may leave it."""
    given = known if load is None else load
    return build_sample_problem(motion_rows(cell, motion, sharing), load=given, samples=np.array([sample]))


def motion_torques(
    rows: MotionRows, solver: str, c2: float, weights: Array, distribute: DistributionName = "least-torque"
) -> tuple[Array, Array, int]:
    """Torques, Shape (N, m), and wrenches, Shape (N, n w), at a chosen c², and how many programs another solver solved.

    The weights are W, Shape (m, m). By "reserve" the limits count as they are given, whatever reserve the cell keeps.
    """
    if distribute == "reserve":
        whole = motion_rows(rows.cell.with_reserve(0.0), rows.motion, rows.sharing, rows.formulation)
        return torques_by_blocks(whole, solver, c2, weights, within=lambda problem: reserved(problem, c2, solver))
    if rows.sparse is None or not _is_for_kernel(rows, solver) or rows.sharing is not None:
        return torques_by_blocks(rows, solver, c2, weights)
    terms, square = rows.terms(float(np.sqrt(c2))), np.full(rows.motion.samples, c2)
    torque, wrench, status = least_torques(rows.cell.library, rows.inputs(None), rows.sparse, terms, square, weights)
    missing = np.flatnonzero(status != OPTIMAL)
    torque[missing], wrench[missing], fallbacks = torques_by_blocks(rows, solver, c2, weights, missing)
    return torque, wrench, fallbacks


def _is_for_kernel(rows: MotionRows, solver: str) -> bool:
    check_solver(solver)
    few = len(rows.kept.names) + rows.cell.library.unknowns <= MOST_ROWS
    return solver == "kernel" and rows.formulation == "wrench" and rows.sparse is not None and few
