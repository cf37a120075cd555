# SPDX-License-Identifier: MIT
"""The programs of a whole trajectory: by the compiled kernel in one call, or put together here for another solver."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.manifest import GEOMETRY
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.cell_library import CellLibrary, KernelRanges, SparseLimits
from mrts.kernel.one_unknown import KnownPlanes, KnownRanges, KnownWrenches
from mrts.kernel.programs import OPTIMAL
from mrts.kernel.sample_terms import SampleTerms
from mrts.limits import squared_limits
from mrts.limits.rows import LimitRows, Side
from mrts.limits.squared_rows import SquaredRows, binds
from mrts.program.closed_form import tied_codes, tied_sides
from mrts.program.formulation import FormulationName
from mrts.program.infeasibility import Conflict
from mrts.program.load_sharing import LoadSharing
from mrts.program.motor_terms import MotorTerms, motor_terms
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
    rows: SquaredRows | None = None,
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
        rows: From `squared_limits`, where they are at hand; None puts them together.

    Raises:
        InputError: If an argument breaks a rule.
        SolverError: If no solver answers.
    """
    fast = compiled_trajectory(cell, motion, formulation, sharing, solver, rows)
    if fast is not None and not (fast.one_unknown and fast.has_speed_terms):
        found = _compiled_ranges(cell, motion, fast, solver, load, high)
    else:
        problem = build_sample_problem(cell, motion, formulation=formulation, sharing=sharing, load=load, rows=rows)
        found = sample_ranges(problem, motion.object.time, solver, high)
    if sharing is not None:
        return found
    return with_end_problem(cell, motion, found, partial(_load_at, load))


def _load_at(load: Array | None, sample: int, _side: Side) -> Array | None:
    return load if load is None or load.ndim == 1 else load[sample]


def _compiled_ranges(
    cell: Cell, motion: CoordinatedMotion, fast: "CompiledTrajectory", solver: str, load: Array | None, high: float
) -> SampleRanges:
    """The ranges by the kernel; what it does not settle is left to the solvers."""
    most, several, time = fast.form.most, False, motion.object.time
    found: KnownRanges | KernelRanges
    if fast.one_unknown:
        found = fast.known(cell, motion, load).ranges(fast.terms(), most)
        undecided = found.lower > found.upper
    else:
        given = motion.samples, _inputs(cell, motion, load), fast.limits, fast.terms()
        if fast.has_speed_terms:
            found, several = intervals_below(partial(fast.compiled.speed_ranges, *given), most, high)
        else:
            found = fast.compiled.ranges(*given, most)
        undecided = np.any(found.status != OPTIMAL, axis=0)
    effect = float(np.max(found.effect, initial=0.0))
    at_rest = found.effect <= REST_TOLERANCE * effect
    lower, upper = found.lower + 0.0, np.where(at_rest, most, found.upper) + 0.0  # 0 has no sign
    suspects = np.flatnonzero(undecided | (at_rest & (lower > 0)))
    rows = fast.rows_at_ends(found, (lower, upper), at_rest)
    conflicts: list[Conflict] = []
    fallbacks = 0
    for start in range(0, len(suspects), BLOCK):
        block = suspects[start : start + BLOCK]
        problem = build_sample_problem(cell, motion, sharing=fast.sharing, load=load, samples=block, rows=fast.form)
        part = sample_ranges(problem, time[block], solver, high, doubtful=True, effect=effect)
        lower[block], upper[block] = part.lower, part.upper
        rows = rows.with_samples(block, part.rows.codes)
        conflicts += [replace(conflict, sample=int(block[conflict.sample])) for conflict in part.conflicts]
        fallbacks += part.fallbacks
        several |= part.several
    return SampleRanges(
        time=time,
        status=statuses(lower, upper, conflicts),
        lower=lower,
        upper=upper,
        rows=rows,
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

    Raises:
        InputError: If an argument breaks a rule.
        SolverError: If no solver answers.
    """
    if formulation == "wrench" and (sharing is not None or len(cell.robots) == 1):
        check_solver(solver)
        return *known_torques(cell, motion, sharing, c2), 0
    fast = compiled_trajectory(cell, motion, formulation, sharing, solver)
    if fast is None:
        problem = build_sample_problem(cell, motion, formulation=formulation, sharing=sharing)
        x, fallbacks = distribute_torques(problem, c2, weights, solver)
        return problem.torque(x), problem.wrench(x), fallbacks
    torque, wrench, status = fast.compiled.torques(
        motion.samples,
        _inputs(cell, motion, None),
        fast.limits,
        fast.terms(float(np.sqrt(c2))),
        np.full(motion.samples, c2),
        weights,
        TORQUE_WIDENING,
    )
    missing, fallbacks = np.flatnonzero(status != OPTIMAL), 0
    for start in range(0, len(missing), BLOCK):
        block = missing[start : start + BLOCK]
        problem = build_sample_problem(cell, motion, samples=block)
        x, by_another = distribute_torques(problem, c2, weights, solver)
        torque[block], wrench[block] = problem.torque(x), problem.wrench(x)
        fallbacks += by_another
    return torque, wrench, fallbacks


def motion_planes(
    cell: Cell, motion: CoordinatedMotion, sharing: LoadSharing | None, load: Array | None
) -> tuple[KnownPlanes, Array] | None:
    """The limits over u = r̈ and x = ṙ² where nothing else is unknown, and the largest x that velocities allow.

    Args:
        cell: The cell.
        motion: Its motion; its time is the path parameter r.
        sharing: A fixed distribution of the load, None for a free one.
        load: As in `motion_ranges`.

    Returns:
        Half-planes, and Shape (N,); None where the compiled path does not answer.
    """
    fast = compiled_trajectory(cell, motion, "wrench", sharing, DEFAULT_SOLVER)
    if fast is None or not fast.one_unknown or fast.has_speed_terms:
        return None
    motors = fast.motors
    by_rate = SampleTerms(torque_square=None if motors is None else motors.rate, square=fast.rows.rate)
    planes = fast.known(cell, motion, load).planes(fast.terms(), by_rate)
    return None if planes is None else (planes, fast.form.most)


@dataclass(frozen=True, kw_only=True)
class CompiledTrajectory:
    """What the compiled path takes.

    Attributes:
        compiled: The cell's library.
        form: All rows.
        rows: Those that are no caps.
        limits: The same as C reads them.
        motors: What motors add.
        sharing: A fixed distribution of the load.
        one_unknown: Whether c² is the only unknown.
        has_speed_terms: Whether a row has a term in ṙ beside others.
    """

    compiled: CellLibrary
    form: SquaredRows
    rows: LimitRows
    limits: SparseLimits
    motors: MotorTerms | None
    sharing: LoadSharing | None
    one_unknown: bool
    has_speed_terms: bool

    def known(self, cell: Cell, motion: CoordinatedMotion, load: Array | None) -> KnownWrenches:
        """The samples of a motion where c² is the only unknown."""
        inputs, function = _inputs(cell, motion, load), "wrench_form"
        if self.sharing is not None:
            inputs, function = inputs | self.sharing.inputs(cell, motion), "fixed_distribution"
        return KnownWrenches(self.compiled, function, motion.samples, inputs, self.limits)

    def rows_at_ends(
        self, found: KnownRanges | KernelRanges, ends: tuple[Array, Array], at_rest: NDArray[np.bool_]
    ) -> BindingRows:
        """The rows of both ends.

        Args:
            found: What the kernel found.
            ends: Lower and upper end of every sample, each Shape (N,).
            at_rest: Samples at which c² moves nothing but caps, Shape (N,).
        """
        form, given = self.form, self.form.given
        if isinstance(found, KnownRanges):
            sides = np.zeros((2, len(at_rest), len(given.names)), dtype=np.int8)
            sides[:, :, ~form.is_cap] = found.tied
            sides[1, at_rest] = 0
            with np.errstate(divide="ignore"):
                sides[1][:, form.is_cap] = tied_sides(1 / form.cap_share, ends[1], form.cap_code > 0)
            return BindingRows(given.names, np.stack([given.lower, given.upper]), tied_codes(sides, ends[0]))
        rows = kernel_rows(form, found.basis, found.dual)
        still, caps = np.flatnonzero(at_rest & np.isfinite(ends[1])), form.cap_code.shape[1]
        rows.codes[1, still] = 0
        rows.codes[1, still, :caps] = np.where(binds(form.cap_share), form.cap_code, 0)[still]
        return rows

    def terms(self, speed: float | Array | None = None) -> SampleTerms:
        """What is added at every sample, those in ṙ at a speed, or by themselves where it is to be found.

        Args:
            speed: ṙ, one for all samples, or Shape (N, 1).
        """
        rows, motors = self.rows, self.motors
        if rows.speed is None or speed is None:
            of_rows = SampleTerms(square=rows.square, speed=rows.speed)
        else:
            of_rows = SampleTerms(square=rows.square, offset=rows.speed * speed)
        if motors is None:
            return of_rows
        return replace(
            of_rows,
            torque_square=motors.square,
            torque_offset=motors.friction(0.0 if speed is None else speed),
            torque_speed=motors.speed if speed is None else None,
            margin=motors.margin(rows),
        )


def compiled_trajectory(
    cell: Cell,
    motion: CoordinatedMotion,
    formulation: FormulationName,
    sharing: LoadSharing | None,
    solver: str,
    rows: SquaredRows | None = None,
) -> CompiledTrajectory | None:
    """The compiled path where it answers: wrench form, no sides that cross.

    Raises:
        InputError: If there is no such solver.
    """
    check_solver(solver)
    compiled = cell.library
    if solver != "kernel" or formulation != "wrench":
        return None
    form, motors = squared_limits(cell, motion) if rows is None else rows, motor_terms(cell, motion)
    kept = form.rows.only(~form.is_cap)
    if len(kept.names) + compiled.unknowns > MOST_ROWS or form.crosses:
        return None
    return CompiledTrajectory(
        compiled=compiled,
        form=form,
        rows=kept,
        limits=kept.sparse(),
        motors=motors,
        sharing=sharing,
        one_unknown=sharing is not None or compiled.robots == 1,
        has_speed_terms=kept.speed is not None or (motors is not None and motors.speed is not None),
    )


def _inputs(cell: Cell, motion: CoordinatedMotion, load: Array | None) -> dict[str, Array]:
    return motion.inputs(cell.load if load is None else load) | {GEOMETRY: cell.geometry}
