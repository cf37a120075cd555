# SPDX-License-Identifier: MIT
"""The torques at a chosen c²: where they are redundant a strictly convex quadratic program at every sample."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, as_array
from mrts.cell.cell import Cell
from mrts.kernel.programs import OPTIMAL, STOPPED
from mrts.program.formulation import DistributionName
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.reserve import reserved
from mrts.program.sample_problem import BLOCK, SampleProblem, build_sample_problem
from mrts.program.solvers import DEFAULT_SOLVER, ConvexPrograms, require_verified, solve_programs

TORQUE_WIDENING = 1e-9
"""Share of itself by which each limit is widened: at c = √c²⁺ the feasible set is a point, which rounding may miss."""

WEIGHT_SPREAD = 1e6
"""Largest ratio of weights: the programs are solved to 1e-9, and the lightest torque must still be felt."""


def torque_weights(weights: Array | float | None, cell: Cell) -> Array:
    """W as a matrix, Shape (m, m): None weighs each torque by its limit, a number all alike, else diagonal or matrix.

    By limits it is diag(1 / τ̂²), τ̂ the larger side of each limit, within `WEIGHT_SPREAD` about the middle limit:
    neither a placeholder nor a joint that may do nothing makes all others weigh alike.

    Raises:
        InputError: Unless W is symmetric and positive definite.
    """
    joints = len(cell.joint_names)
    if weights is None:
        limit = np.maximum(np.abs(cell.stacked("torque_lower")), np.abs(cell.stacked("torque_upper")))
        known = np.sort(limit[np.isfinite(limit) & (limit > 0)])
        middle, most = (known[len(known) // 2] if len(known) else 1.0), WEIGHT_SPREAD**0.25
        return np.diag(1 / np.clip(limit, middle / most, middle * most) ** 2)
    given = as_array("weights", weights)
    if given.shape not in {(), (joints,), (joints, joints)} or not np.all(np.isfinite(given)):
        rule = f"must be finite: one number, {joints} of them, or a matrix of Shape ({joints}, {joints})."
        raise InputError("weights", rule, value=weights)
    W = given if given.ndim == 2 else np.diag(np.broadcast_to(given, joints))  # noqa: PLR2004 (a matrix)
    spread = np.linalg.eigvalsh(W)
    if not np.array_equal(W, W.T) or spread[0] <= 0:
        raise InputError("weights", "must be > 0; of a matrix, symmetric and positive definite.", value=weights)
    if spread[-1] > WEIGHT_SPREAD * spread[0]:
        raise InputError(
            "weights",
            f"its eigenvalues (a diagonal: its values) spread over a factor of {spread[-1] / spread[0]:.3g}; at most "
            f"{WEIGHT_SPREAD:.0e} leaves digits for the torques.",
        )
    return W


def motion_torques(
    rows: MotionRows,
    c2: float,
    weights: Array,
    distribute: DistributionName = "least-torque",
    samples: NDArray[np.intp] | None = None,
) -> tuple[Array, Array]:
    """Torques, Shape (k, m), and wrenches, Shape (k, n w), at a chosen c², of all samples or k of them.

    The weights are W, Shape (m, m). By "reserve" the limits count as they are given, whatever reserve the cell keeps.
    """
    places = np.arange(rows.motion.samples) if samples is None else samples
    if distribute == "reserve":
        cell, whole = rows.cell, rows
        if cell.reserve:
            whole = motion_rows(cell.with_reserve(0.0), rows.motion, rows.sharing, rows.formulation, rows.solver)
        return torques_by_blocks(whole, c2, weights, samples, lambda problem: reserved(problem, c2))
    if rows.solver != DEFAULT_SOLVER or not rows.compiled:
        return torques_by_blocks(rows, c2, weights, samples)
    count, library = len(places), rows.cell.library
    torque, wrench = np.zeros((count, library.joints)), np.zeros((count, library.wrenches))
    status = np.full(count, STOPPED, dtype=np.uint8)
    asked, outputs, for_all = [np.full(count, c2)], (torque, wrench, status), (1, weights, TORQUE_WIDENING)
    rows.over_samples("mrts_torques", asked, outputs, for_all, speed=float(np.sqrt(c2)), samples=samples)
    missing = (status != OPTIMAL).nonzero()[0]
    if missing.size:
        torque[missing], wrench[missing] = torques_by_blocks(rows, c2, weights, places[missing])
    return torque, wrench


def distribute_torques(problem: SampleProblem, c2: float | Array, weights: Array) -> Array:
    """Eqs. (31), (32), (33), (34): minimise Φ = τᵀ W τ subject to the object's balance and every limit, at c².

    c² is one for all samples, or Shape (N,); W has Shape (m, m) and is positive definite.

    Returns:
        Unknowns x with c² last, Shape (N, k).

    Raises:
        SolverError: If no solver answers.
    """
    count, unknowns = problem.samples, problem.unknowns
    speed = np.broadcast_to(np.reshape(c2, (-1, 1)), (count, 1))
    if unknowns == 1:
        return speed
    free = problem.torque_map[:, :, :-1]
    others = problem.torque(np.concatenate([np.zeros((count, unknowns - 1)), speed], axis=1))
    H = np.einsum("nij,ik,nkl->njl", free, weights, free)
    g = np.einsum("nij,ik,nk->nj", free, weights, others)
    lower, upper = problem.limits_at(speed)
    widening = TORQUE_WIDENING * (problem.limit_lower < problem.limit_upper)
    unlimited = np.full((count, unknowns - 1), np.inf)
    programs = ConvexPrograms(
        H=H,
        g=g,
        A=problem.free,
        lower=np.hstack([lower - widening, -unlimited]),
        upper=np.hstack([upper + widening, unlimited]),
    )
    answers = solve_programs(programs, problem.solver)
    require_verified(answers)
    return np.concatenate([answers.x, speed], axis=1)


def torques_by_blocks(
    rows: MotionRows,
    c2: float,
    weights: Array,
    samples: NDArray[np.intp] | None = None,
    within: Callable[[SampleProblem], SampleProblem] = lambda problem: problem,
) -> tuple[Array, Array]:
    """`distribute_torques` for k samples of a motion, all or some, as from `motion_torques`.

    `within` moves the limits of some samples.
    """
    places, library = np.arange(rows.motion.samples) if samples is None else samples, rows.cell.library
    torque, wrench = (np.zeros((len(places), size)) for size in (library.joints, library.wrenches))
    for start in range(0, len(places), BLOCK):
        block = slice(start, start + BLOCK)
        problem = build_sample_problem(rows, samples=places[block])
        x = distribute_torques(within(problem), c2, weights)
        torque[block], wrench[block] = problem.torque(x), problem.wrench(x)
    return torque, wrench
