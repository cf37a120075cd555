# SPDX-License-Identifier: MIT
"""By how much limits must move outward along a motion before it keeps them: by the kernel, or by a solver."""

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.manifest import GEOMETRY
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.cell_library import SparseLimits
from mrts.kernel.motion_rows import widenings
from mrts.kernel.programs import OPTIMAL
from mrts.program.formulation import FormulationName
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.program.widening import widening_at

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
        formulation: As in `mrts.program.trajectory_programs.motion_ranges`.
        sharing: Likewise.
        load: Load vector instead of the cell's, Shape (10,), or one a sample asked for, Shape (k, 10).
        samples: Indices of those that are asked for, Shape (k,); None takes all N.
        rows: As in `motion_ranges`.

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
    units = rows.size[~rows.is_cap]
    share, status = widenings(cell.library, len(places), inputs, sparse, units, terms, c2)
    return np.maximum(share, _passed_caps(rows, c2, places)), status != OPTIMAL


def _passed_caps(form: MotionRows, c2: Array, samples: NDArray[np.intp]) -> Array:
    """By how much rows that only bound c² are passed at some samples, in shares of each, Shape (k,)."""
    if form.rows.square is None or not np.any(form.is_cap):
        return np.zeros(len(samples))
    lower, upper, size = form.rows.lower[form.is_cap], form.rows.upper[form.is_cap], form.size[form.is_cap]
    value = form.rows.square[np.ix_(samples, form.is_cap)] * c2[:, None]
    return np.asarray(np.max(np.maximum(value - upper, lower - value) / size, axis=1, initial=0.0))
