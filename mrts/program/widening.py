# SPDX-License-Identifier: MIT
"""By how much limits must move outward before some unknowns, or a given c², keep them all."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.manifest import GEOMETRY
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.cell_library import SparseLimits
from mrts.kernel.programs import OPTIMAL, STOPPED
from mrts.program.convex_program import ConvexPrograms
from mrts.program.formulation import FormulationName
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.solvers import DEFAULT_SOLVER, require_verified, solve_programs


def least_widening(
    A: Array,
    lower: Array,
    upper: Array,
    is_limit: NDArray[np.bool_],
    x_lower: Array,
    solver: str,
    what: str,
    *,
    sizes: tuple[Array, Array] | None = None,
    least: float = 0.0,
) -> tuple[Array, Array, int]:
    """Solve min s, lower - s l <= A x <= upper + s u for limits, lower <= A x <= upper for laws; it has a solution.

    Args:
        A: Shape (N, r, k).
        lower: Shape (N, r).
        upper: Shape (N, r).
        is_limit: False for laws, which do not move, Shape (r,).
        x_lower: Lower bounds of the unknowns, Shape (k,).
        solver: Name in the registry.
        what: What is found, for the message.
        sizes: l and u, how far s = 1 moves each side, each Shape (r,); None is 1.
        least: Least s: below 0 limits move inward.

    Returns:
        Least s, in sizes of limits, Shape (N,); multipliers of the rows, positive at an upper limit, Shape (N, r); and
        how many programs another solver solved.

    Raises:
        SolverError: If no solver answers.
    """
    count, rows, unknowns = A.shape
    below, above = (np.ones(rows), np.ones(rows)) if sizes is None else sizes
    limits, laws = np.flatnonzero(is_limit), np.flatnonzero(~is_limit)
    # each limit twice, once a side, as s moves them in opposite senses; laws once, as they are
    order = np.concatenate([limits, limits, laws])
    sense = np.repeat([-1.0, 1.0, 0.0], [len(limits), len(limits), len(laws)])
    moved = sense * np.concatenate([above[limits], below[limits], np.ones(len(laws))])
    moved = np.broadcast_to(moved[:, None], (count, len(order), 1))
    g = np.zeros((count, unknowns + 1))
    g[:, -1] = 1
    bounds = np.tile(np.append(x_lower, least), (count, 1))
    programs = ConvexPrograms(
        H=None,
        g=g,
        A=np.concatenate([A[:, order], moved], axis=2),
        lower=np.where(sense < 0, -np.inf, lower[:, order]),
        upper=np.where(sense > 0, np.inf, upper[:, order]),
        x_lower=bounds,
        x_upper=np.full_like(bounds, np.inf),
    )
    answers = solve_programs(programs, solver)
    require_verified(answers, what)
    row_dual = np.zeros((count, rows))
    for column, row in enumerate(order):
        row_dual[:, row] += answers.row_dual[:, column]
    return answers.x[:, -1], row_dual, answers.fallbacks


def widening_at(problem: SampleProblem, c2: float | Array, solver: str, what: str) -> Array:
    """Least s that admits a given c², Shape (N,); where c² is the only unknown, the largest excess.

    Args:
        problem: Rows of some samples.
        c2: c², one for all samples, or one a sample, Shape (N, 1).
        solver: Name in the registry.
        what: What is found, for the message.

    Raises:
        SolverError: If no solver answers.
    """
    lower, upper = problem.limits_at(c2)
    if problem.unknowns == 1:
        return np.asarray(np.max(np.maximum(lower, -upper), axis=1, initial=0.0), dtype=np.float64)
    free = np.full(problem.unknowns - 1, -np.inf)
    return least_widening(problem.free, lower, upper, problem.is_limit, free, solver, what)[0]


WHAT = "the excess between samples"
"""What is found, for messages."""


def motion_widening(
    cell: Cell,
    motion: CoordinatedMotion,
    c2: Array,
    *,
    formulation: FormulationName = "wrench",
    sharing: LoadSharing | None = None,
    load: Array | None = None,
    samples: NDArray[np.intp] | None = None,
    rows: MotionRows | None = None,
) -> Array:
    """By how much all limits must move outward before a motion keeps them, in shares of each: Shape (k,).

    Args:
        cell: The cell.
        motion: Its motion, N samples.
        c2: c² at each sample asked for, Shape (k,).
        formulation: "wrench" or "torque".
        sharing: A fixed distribution of the load, None for a free one.
        load: Load vector instead of the cell's, Shape (10,), or one a sample asked for, Shape (k, 10).
        samples: Indices of those that are asked for, Shape (k,); None takes all N.
        rows: From `motion_rows`, where they are at hand.

    Raises:
        InputError: If an argument breaks a rule.
        SolverError: If no solver answers.
    """
    places = np.arange(motion.samples) if samples is None else samples
    if not len(places):
        return np.zeros(0)
    rows = motion_rows(cell, motion) if rows is None else rows
    share, missing = np.zeros(len(places)), np.ones(len(places), dtype=bool)
    if sharing is None and formulation == "wrench" and rows.sparse is not None:
        share, missing = _kernel_widening(cell, motion, rows, rows.sparse, c2, load, places)
    left = np.flatnonzero(missing)
    if left.size:
        carried = load if load is None or load.ndim == 1 else _of_samples(load[left], places[left], motion.samples)
        problem = build_sample_problem(
            cell, motion, formulation=formulation, sharing=sharing, load=carried, samples=places[left], rows=rows
        )
        share[left] = widening_at(problem, c2[left, None], DEFAULT_SOLVER, WHAT)
    return share


def _of_samples(values: Array, places: NDArray[np.intp], count: int) -> Array:
    """Values of some of N samples among all, zero elsewhere."""
    whole = np.zeros((count, *values.shape[1:]))
    whole[places] = values
    return whole


def _kernel_widening(
    cell: Cell,
    motion: CoordinatedMotion,
    rows: MotionRows,
    sparse: SparseLimits,
    c2: Array,
    load: Array | None,
    places: NDArray[np.intp],
) -> tuple[Array, NDArray[np.bool_]]:
    """The widening by the kernel, and where it has no answer."""
    terms = rows.terms(np.sqrt(_of_samples(c2[:, None], places, motion.samples)) if rows.has_speed_terms else 1.0)
    inputs = motion.inputs(cell.load)
    if len(places) < motion.samples:
        inputs = {name: value if value.ndim == 1 else value[places] for name, value in inputs.items()}
        terms = terms.at(places)
    inputs |= {GEOMETRY: cell.geometry, "load": cell.load if load is None else load}
    share, status = np.zeros(len(places)), np.full(len(places), STOPPED, dtype=np.uint8)
    units = np.ascontiguousarray(rows.size[~rows.is_cap])
    cell.library.over_samples("mrts_widenings", len(places), inputs, sparse, terms, [c2], [share, status], (units,))
    return np.maximum(share, _passed_caps(rows, c2, places)), status != OPTIMAL


def _passed_caps(form: MotionRows, c2: Array, samples: NDArray[np.intp]) -> Array:
    """By how much rows that only bound c² are passed at some samples, in shares of each, Shape (k,)."""
    if form.rows.square is None or not np.any(form.is_cap):
        return np.zeros(len(samples))
    lower, upper, size = form.rows.lower[form.is_cap], form.rows.upper[form.is_cap], form.size[form.is_cap]
    value = form.rows.square[np.ix_(samples, form.is_cap)] * c2[:, None]
    return np.asarray(np.max(np.maximum(value - upper, lower - value) / size, axis=1, initial=0.0))
