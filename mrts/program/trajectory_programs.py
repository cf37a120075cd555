# SPDX-License-Identifier: MIT
"""The programs of a whole trajectory: by the compiled kernel in one call, or put together here for another solver."""

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.manifest import GEOMETRY
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.cell_library import KernelRanges
from mrts.kernel.one_unknown import KnownRanges, known_ranges
from mrts.kernel.programs import OPTIMAL
from mrts.program.formulation import FormulationName
from mrts.program.infeasibility import Conflict
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows, binds, motion_rows
from mrts.program.range_ends import BindingRows, RangeEnds, intervals_below, kernel_rows, tied_codes, tied_sides
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.sample_ranges import REST_TOLERANCE, SampleRanges, decided_ends, ranges_of_ends, sample_ranges
from mrts.program.solvers import check_solver
from mrts.program.torque_distribution import BLOCK, TORQUE_WIDENING, torques_by_blocks

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
    one_unknown = sharing is not None or len(cell.robots) == 1
    if _is_for_kernel(cell, rows, formulation, solver) and not (one_unknown and rows.has_speed_terms):
        found = _kernel_ranges(cell, motion, sharing, solver, load, high, rows)
    else:
        problem = build_sample_problem(cell, motion, formulation=formulation, sharing=sharing, load=load, rows=rows)
        found = sample_ranges(problem, motion.object.time, solver, high)
    return found if one_unknown else replace(found, problem=partial(_problem_of_sample, cell, motion, load))


def _problem_of_sample(
    cell: Cell, motion: CoordinatedMotion, known: Array | None, sample: int, load: Array | None
) -> SampleProblem:
    return build_sample_problem(cell, motion, load=known if load is None else load, samples=np.array([sample]))


def _kernel_ranges(
    cell: Cell,
    motion: CoordinatedMotion,
    sharing: LoadSharing | None,
    solver: str,
    load: Array | None,
    high: float,
    rows: MotionRows,
) -> SampleRanges:
    """The ranges by the kernel; what it does not settle is left to the solvers."""
    most, several, time, library = rows.most, False, motion.object.time, cell.library
    found: KnownRanges | KernelRanges
    assert rows.sparse is not None  # noqa: S101 (`_is_for_kernel`)
    function, inputs = "wrench_form", _inputs(cell, motion, load)
    if sharing is not None:
        function, inputs = "fixed_distribution", inputs | sharing.inputs(cell, motion)
    given = motion.samples, inputs, rows.sparse, rows.terms()
    if sharing is not None or library.robots == 1:
        found = known_ranges(library, function, *given, most)
        undecided = found.lower > found.upper
    else:
        if rows.has_speed_terms:
            found, several = intervals_below(partial(library.ranges, *given, speeds=True), most, high)
        else:
            found = library.ranges(*given, most)
        undecided = np.any(found.status != OPTIMAL, axis=0)
    effect = float(np.max(found.effect, initial=0.0))
    at_rest = found.effect <= REST_TOLERANCE * effect
    lower, upper = found.lower + 0.0, np.where(at_rest, most, found.upper) + 0.0  # 0 has no sign
    suspects = np.flatnonzero(undecided | (at_rest & (lower > 0)))
    ends = RangeEnds(lower, upper, _rows_at_ends(rows, found, (lower, upper), at_rest), undecided, several=several)
    conflicts: list[Conflict] = []
    for start in range(0, len(suspects), BLOCK):
        block = suspects[start : start + BLOCK]
        problem = build_sample_problem(cell, motion, sharing=sharing, load=load, samples=block, rows=rows)
        part, own = decided_ends(problem, time[block], solver, high, effect)
        ends.replace(block, part)
        conflicts += [replace(conflict, sample=int(block[conflict.sample])) for conflict in own]
    return ranges_of_ends(time, ends, conflicts)


def motion_torques(
    cell: Cell,
    motion: CoordinatedMotion,
    formulation: FormulationName,
    sharing: LoadSharing | None,
    solver: str,
    c2: float,
    weights: Array,
    rows: MotionRows | None = None,
) -> tuple[Array, Array, int]:
    """Torques, Shape (N, m), and wrenches, Shape (N, n w), at a chosen c², and how many programs another solver solved.

    W, Shape (m, m), is in `weights`; the others are as in `motion_ranges`.

    Raises:
        InputError: If an argument breaks a rule.
        SolverError: If no solver answers.
    """
    rows = motion_rows(cell, motion) if rows is None else rows
    given = cell, motion, formulation, sharing, solver, c2, weights, rows
    of_kernel = _is_for_kernel(cell, rows, formulation, solver)
    if not of_kernel or sharing is not None or len(cell.robots) == 1:
        return torques_by_blocks(*given)
    assert rows.sparse is not None  # noqa: S101 (`_is_for_kernel`)
    torque, wrench, status = cell.library.torques(
        motion.samples,
        _inputs(cell, motion, None),
        rows.sparse,
        rows.terms(float(np.sqrt(c2))),
        np.full(motion.samples, c2),
        weights,
        TORQUE_WIDENING,
    )
    missing = np.flatnonzero(status != OPTIMAL)
    torque[missing], wrench[missing], fallbacks = torques_by_blocks(*given, missing)
    return torque, wrench, fallbacks


def _is_for_kernel(cell: Cell, rows: MotionRows, formulation: FormulationName, solver: str) -> bool:
    """Whether the compiled path answers: wrench form, no sides that cross."""
    check_solver(solver)
    few = len(rows.kept.names) + cell.library.unknowns <= MOST_ROWS
    return solver == "kernel" and formulation == "wrench" and rows.sparse is not None and few


def _rows_at_ends(
    rows: MotionRows, found: KnownRanges | KernelRanges, ends: tuple[Array, Array], at_rest: NDArray[np.bool_]
) -> BindingRows:
    """The rows of both ends.

    Args:
        rows: All.
        found: What the kernel found.
        ends: Lower and upper end of every sample, each Shape (N,).
        at_rest: Samples at which c² moves nothing but caps, Shape (N,).
    """
    given = rows.given
    if isinstance(found, KnownRanges):
        sides = np.zeros((2, len(at_rest), len(given.names)), dtype=np.int8)
        sides[:, :, ~rows.is_cap] = found.tied
        sides[1, at_rest] = 0
        with np.errstate(divide="ignore"):
            sides[1][:, rows.is_cap] = tied_sides(1 / rows.cap_share, ends[1], rows.cap_code > 0)
        return BindingRows(given.names, np.stack([given.lower, given.upper]), tied_codes(sides, ends[0]))
    binding = kernel_rows(rows, found.basis, found.dual)
    still, caps = np.flatnonzero(at_rest & np.isfinite(ends[1])), rows.cap_code.shape[1]
    binding.codes[1, still] = 0
    binding.codes[1, still, :caps] = np.where(binds(rows.cap_share), rows.cap_code, 0)[still]
    return binding


def _inputs(cell: Cell, motion: CoordinatedMotion, load: Array | None) -> dict[str, Array]:
    return motion.inputs(cell.load if load is None else load) | {GEOMETRY: cell.geometry}
