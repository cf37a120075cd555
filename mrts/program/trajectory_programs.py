# SPDX-License-Identifier: MIT
"""The programs of a whole trajectory: by the compiled kernel in one call, or put together here for another solver."""

from dataclasses import replace
from functools import partial

import numpy as np

from mrts.base.arrays import Array
from mrts.base.manifest import GEOMETRY
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.programs import OPTIMAL
from mrts.program.formulation import DistributionName, FormulationName
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.range_ends import RangeEnds, intervals_below, kernel_ends, known_ends, with_caps
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
from mrts.program.solvers import check_solver
from mrts.program.torque_distribution import BLOCK, least_torques, torques_by_blocks

MOST_ROWS = 32_767
"""The compiled path keeps the rows of each sample's answer as 16-bit numbers."""


def motion_ranges(
    cell: Cell,
    motion: CoordinatedMotion,
    formulation: FormulationName,
    sharing: LoadSharing | None,
    solver: str,
    load: Array | None = None,
    high: float = np.inf,
    rows: MotionRows | None = None,
) -> SampleRanges:
    """Least and largest c² at every sample (step 1 of MMTSF).

    Args:
        cell: The cell.
        motion: Its motion.
        formulation: "wrench" or "torque".
        sharing: A fixed distribution of the load, None for a free one.
        solver: Name in the registry; "kernel" takes the compiled path where it applies.
        load: Load vector instead of the cell's, Shape (10,), or one a sample, Shape (N, 10).
        high: Of several intervals the highest is found that does not begin above this c².
        rows: From `motion_rows`, where they are at hand; None puts them together.

    Raises:
        InputError: If an argument breaks a rule.
        SolverError: If no solver answers.
    """
    rows = motion_rows(cell, motion) if rows is None else rows
    time, one_unknown = motion.object.time, sharing is not None or len(cell.robots) == 1
    of_sample = partial(_problem_of_sample, cell, motion, sharing, load)
    if not _is_for_kernel(cell, rows, formulation, solver) or (one_unknown and rows.has_speed_terms):
        problem = build_sample_problem(cell, motion, formulation=formulation, sharing=sharing, load=load, rows=rows)
        return replace(sample_ranges(problem, time, solver, high), problem=of_sample)
    ends = _kernel_ends(cell, motion, sharing, load, high, rows)
    effect = float(np.max(ends.effect, initial=0.0))
    at_rest = ends.effect <= REST_TOLERANCE * effect
    ends.upper[at_rest], ends.codes[1, at_rest] = rows.most[at_rest], 0
    suspects = np.flatnonzero((ends.status != OPTIMAL) | (at_rest & (ends.lower > 0)))
    ends, conflicts = with_caps(ends, rows.cap_share, rows.cap_code), []
    for start in range(0, len(suspects), BLOCK):
        block = suspects[start : start + BLOCK]
        problem = build_sample_problem(cell, motion, sharing=sharing, load=load, samples=block, rows=rows)
        conflicts += decide(ends, block, without_speed_at_rest(problem, effect), time, solver, high)
    found = ranges_of_ends(time, ends, conflicts, rows.given.names, (rows.given.lower, rows.given.upper))
    return found if one_unknown else replace(found, problem=of_sample)


def _problem_of_sample(
    cell: Cell,
    motion: CoordinatedMotion,
    sharing: LoadSharing | None,
    known: Array | None,
    sample: int,
    load: Array | None,
) -> SampleProblem:
    given = known if load is None else load
    return build_sample_problem(cell, motion, sharing=sharing, load=given, samples=np.array([sample]))


def _kernel_ends(
    cell: Cell,
    motion: CoordinatedMotion,
    sharing: LoadSharing | None,
    load: Array | None,
    high: float,
    rows: MotionRows,
) -> RangeEnds:
    library, inputs, most = cell.library, _inputs(cell, motion, load), rows.most
    if sharing is not None:
        return known_ends(library, "fixed_distribution", inputs | sharing.inputs(cell, motion), rows, most)
    if library.robots == 1:
        return known_ends(library, "wrench_form", inputs, rows, most)
    if rows.has_speed_terms:
        return intervals_below(partial(kernel_ends, library, inputs, rows), most, high)
    return kernel_ends(library, inputs, rows, most)


def motion_torques(
    cell: Cell,
    motion: CoordinatedMotion,
    formulation: FormulationName,
    sharing: LoadSharing | None,
    solver: str,
    c2: float,
    weights: Array,
    rows: MotionRows | None = None,
    distribute: DistributionName = "least-torque",
) -> tuple[Array, Array, int]:
    """Torques, Shape (N, m), and wrenches, Shape (N, n w), at a chosen c², and how many programs another solver solved.

    W, Shape (m, m), is in `weights`; the others are as in `motion_ranges`. By "reserve" the limits count as they are
    given, whatever reserve the cell keeps.

    Raises:
        InputError: If an argument breaks a rule.
        SolverError: If no solver answers.
    """
    if distribute == "reserve":
        cell = cell.with_reserve(0.0)
        given = cell, motion, formulation, sharing, solver, c2, weights, motion_rows(cell, motion)
        return torques_by_blocks(*given, within=lambda problem: reserved(problem, c2, solver))
    rows = motion_rows(cell, motion) if rows is None else rows
    given = cell, motion, formulation, sharing, solver, c2, weights, rows
    of_kernel = _is_for_kernel(cell, rows, formulation, solver)
    if not of_kernel or sharing is not None or len(cell.robots) == 1:
        return torques_by_blocks(*given)
    assert rows.sparse is not None  # noqa: S101 (`_is_for_kernel`)
    terms, square = rows.terms(float(np.sqrt(c2))), np.full(motion.samples, c2)
    torque, wrench, status = least_torques(
        cell.library, _inputs(cell, motion, None), rows.sparse, terms, square, weights
    )
    missing = np.flatnonzero(status != OPTIMAL)
    torque[missing], wrench[missing], fallbacks = torques_by_blocks(*given, missing)
    return torque, wrench, fallbacks


def _is_for_kernel(cell: Cell, rows: MotionRows, formulation: FormulationName, solver: str) -> bool:
    """Whether the compiled path answers: wrench form, no sides that cross."""
    check_solver(solver)
    few = len(rows.kept.names) + cell.library.unknowns <= MOST_ROWS
    return solver == "kernel" and formulation == "wrench" and rows.sparse is not None and few


def _inputs(cell: Cell, motion: CoordinatedMotion, load: Array | None) -> dict[str, Array]:
    return motion.inputs(cell.load if load is None else load) | {GEOMETRY: cell.geometry}
