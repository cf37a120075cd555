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
from mrts.kernel.one_unknown import KnownPlanes, KnownRanges, KnownWrenches
from mrts.kernel.programs import OPTIMAL
from mrts.kernel.sample_terms import SampleTerms
from mrts.limits.rows import Side
from mrts.program.closed_form import tied_codes, tied_sides
from mrts.program.formulation import FormulationName
from mrts.program.infeasibility import Conflict
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows, binds, motion_rows
from mrts.program.range_ends import BindingRows, kernel_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import REST_TOLERANCE, SampleRanges, sample_ranges, statuses, with_end_problem
from mrts.program.solvers import DEFAULT_SOLVER, check_solver
from mrts.program.speed_intervals import intervals_below
from mrts.program.torque_distribution import TORQUE_WIDENING, distribute_torques, known_torques

BLOCK = 4096
"""Samples whose rows are put together at a time where the kernel has not answered."""

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
    if sharing is not None:
        return found
    return with_end_problem(cell, motion, found, partial(_load_at, load))


def _load_at(load: Array | None, sample: int, _side: Side) -> Array | None:
    return load if load is None or load.ndim == 1 else load[sample]


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
    if sharing is not None or library.robots == 1:
        found = _known(cell, motion, sharing, load, rows).ranges(rows.terms(), most)
        undecided = found.lower > found.upper
    else:
        assert rows.sparse is not None  # noqa: S101 (`_is_for_kernel`)
        given = motion.samples, _inputs(cell, motion, load), rows.sparse, rows.terms()
        if rows.has_speed_terms:
            found, several = intervals_below(partial(library.ranges, *given, speeds=True), most, high)
        else:
            found = library.ranges(*given, most)
        undecided = np.any(found.status != OPTIMAL, axis=0)
    effect = float(np.max(found.effect, initial=0.0))
    at_rest = found.effect <= REST_TOLERANCE * effect
    lower, upper = found.lower + 0.0, np.where(at_rest, most, found.upper) + 0.0  # 0 has no sign
    suspects = np.flatnonzero(undecided | (at_rest & (lower > 0)))
    binding = _rows_at_ends(rows, found, (lower, upper), at_rest)
    conflicts: list[Conflict] = []
    fallbacks = 0
    for start in range(0, len(suspects), BLOCK):
        block = suspects[start : start + BLOCK]
        problem = build_sample_problem(cell, motion, sharing=sharing, load=load, samples=block, rows=rows)
        part = sample_ranges(problem, time[block], solver, high, doubtful=True, effect=effect)
        lower[block], upper[block] = part.lower, part.upper
        binding = binding.with_samples(block, part.rows.codes)
        conflicts += [replace(conflict, sample=int(block[conflict.sample])) for conflict in part.conflicts]
        fallbacks += part.fallbacks
        several |= part.several
    return SampleRanges(
        time=time,
        status=statuses(lower, upper, conflicts),
        lower=lower,
        upper=upper,
        rows=binding,
        conflicts=tuple(conflicts),
        fallbacks=fallbacks,
        several=several,
    )


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

    Args:
        cell: The cell, with its load.
        motion: Its motion.
        formulation: As in `motion_ranges`.
        sharing: Likewise.
        solver: Likewise.
        c2: Chosen c².
        weights: W, Shape (m, m).
        rows: As in `motion_ranges`.

    Raises:
        InputError: If an argument breaks a rule.
        SolverError: If no solver answers.
    """
    if formulation == "wrench" and (sharing is not None or len(cell.robots) == 1):
        check_solver(solver)
        return *known_torques(cell, motion, sharing, c2), 0
    rows = motion_rows(cell, motion) if rows is None else rows
    if not _is_for_kernel(cell, rows, formulation, solver) or rows.sparse is None:
        problem = build_sample_problem(cell, motion, formulation=formulation, sharing=sharing, rows=rows)
        x, fallbacks = distribute_torques(problem, c2, weights, solver)
        return problem.torque(x), problem.wrench(x), fallbacks
    torque, wrench, status = cell.library.torques(
        motion.samples,
        _inputs(cell, motion, None),
        rows.sparse,
        rows.terms(float(np.sqrt(c2))),
        np.full(motion.samples, c2),
        weights,
        TORQUE_WIDENING,
    )
    missing, fallbacks = np.flatnonzero(status != OPTIMAL), 0
    for start in range(0, len(missing), BLOCK):
        block = missing[start : start + BLOCK]
        problem = build_sample_problem(cell, motion, samples=block, rows=rows)
        x, by_another = distribute_torques(problem, c2, weights, solver)
        torque[block], wrench[block] = problem.torque(x), problem.wrench(x)
        fallbacks += by_another
    return torque, wrench, fallbacks


def motion_planes(
    cell: Cell,
    motion: CoordinatedMotion,
    sharing: LoadSharing | None,
    load: Array | None,
    rows: MotionRows | None = None,
) -> tuple[KnownPlanes, Array] | None:
    """The limits over u = r̈ and x = ṙ² where nothing else is unknown, and the largest x that velocities allow.

    Args:
        cell: The cell.
        motion: Its motion; its time is the path parameter r.
        sharing: A fixed distribution of the load, None for a free one.
        load: As in `motion_ranges`.
        rows: Likewise.

    Returns:
        Half-planes, and Shape (N,); None where the compiled path does not answer.
    """
    if sharing is None and len(cell.robots) > 1:
        return None
    rows = motion_rows(cell, motion) if rows is None else rows
    if rows.has_speed_terms or not _is_for_kernel(cell, rows, "wrench", DEFAULT_SOLVER):
        return None
    by_rate = SampleTerms(torque_square=None if rows.motors is None else rows.motors.rate, square=rows.kept.rate)
    planes = _known(cell, motion, sharing, load, rows).planes(rows.terms(), by_rate)
    return None if planes is None else (planes, rows.most)


def _is_for_kernel(cell: Cell, rows: MotionRows, formulation: FormulationName, solver: str) -> bool:
    """Whether the compiled path answers: wrench form, no sides that cross."""
    check_solver(solver)
    few = len(rows.kept.names) + cell.library.unknowns <= MOST_ROWS
    return solver == "kernel" and formulation == "wrench" and rows.sparse is not None and few


def _known(
    cell: Cell, motion: CoordinatedMotion, sharing: LoadSharing | None, load: Array | None, rows: MotionRows
) -> KnownWrenches:
    """The samples of a motion where c² is the only unknown."""
    assert rows.sparse is not None  # noqa: S101 (`_is_for_kernel`)
    inputs, function = _inputs(cell, motion, load), "wrench_form"
    if sharing is not None:
        inputs, function = inputs | sharing.inputs(cell, motion), "fixed_distribution"
    return KnownWrenches(cell.library, function, motion.samples, inputs, rows.sparse)


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
