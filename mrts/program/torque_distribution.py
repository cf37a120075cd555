# SPDX-License-Identifier: MIT
"""The torques at a chosen c²: where they are redundant a strictly convex quadratic program at every sample."""

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, as_array
from mrts.base.manifest import GEOMETRY
from mrts.base.torque_weights import WEIGHT_SPREAD, weights_by_limits
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.one_unknown import known_values
from mrts.program.convex_program import ConvexPrograms
from mrts.program.load_sharing import LoadSharing
from mrts.program.motor_terms import motor_terms
from mrts.program.sample_problem import SampleProblem
from mrts.program.solvers import require_verified, solve_programs

TORQUE_WIDENING = 1e-9
"""Of each limit, as a share of it: at c = √c²⁺ the feasible set is a point, which rounding may miss."""


def torque_weights(weights: Array | float | None, cell: Cell) -> Array:
    """W as a matrix, Shape (m, m).

    Args:
        weights: None weighs each torque by its limit (`weights_by_limits`), a number all alike, else the diagonal,
            Shape (m,), or the matrix, Shape (m, m).
        cell: With m joints.

    Raises:
        InputError: Unless W is symmetric and positive definite.
    """
    joints = sum(len(robot.joints) for robot in cell.robots)
    if weights is None:
        lower, upper = np.concatenate([[robot.torque_lower, robot.torque_upper] for robot in cell.robots], axis=1)
        return np.diag(weights_by_limits(lower, upper))
    given = as_array("weights", weights)
    if given.shape not in {(), (joints,), (joints, joints)} or not np.all(np.isfinite(given)):
        rule = f"must be finite: a number, or of Shape ({joints},) or ({joints}, {joints})."
        raise InputError("weights", rule, value=weights)
    W = given if given.ndim == 2 else np.diag(np.broadcast_to(given, joints))  # noqa: PLR2004 (a matrix)
    spread = np.linalg.eigvalsh(W)
    if not np.array_equal(W, W.T) or spread[0] <= 0:
        raise InputError("weights", "must be symmetric and positive definite (a diagonal: all > 0).", value=weights)
    if spread[-1] > WEIGHT_SPREAD * spread[0]:
        raise InputError(
            "weights",
            f"its eigenvalues (a diagonal: its values) spread over a factor of {spread[-1] / spread[0]:.3g}; at most "
            f"{WEIGHT_SPREAD:.0e} leaves digits for the torques.",
        )
    return W


def distribute_torques(problem: SampleProblem, c2: float | Array, weights: Array, solver: str) -> tuple[Array, int]:
    """Eqs. (31), (32), (33), (34): minimise Φ = τᵀ W τ subject to the object's balance and every limit, at c².

    Args:
        problem: Rows along the motion, in any formulation.
        c2: Chosen c², inside the range; one for all samples, or one a sample, Shape (N,).
        weights: W, Shape (m, m), positive definite.
        solver: Name in the registry.

    Returns:
        Unknowns x with c² last, Shape (N, k), and the programs that a fallback had to solve.

    Raises:
        InputError: If there is no such solver.
        SolverError: If no solver answers.
    """
    count, unknowns = problem.samples, problem.unknowns
    speed = np.broadcast_to(np.reshape(c2, (-1, 1)), (count, 1))
    if unknowns == 1:
        return speed, 0
    free, at_rest = problem.torque_map[:, :, :-1], problem.torque_without_free(speed)
    H = np.einsum("nij,ik,nkl->njl", free, weights, free)
    g = np.einsum("nij,ik,nk->nj", free, weights, at_rest)
    lower, upper = problem.limits_at(speed)
    widening = np.where(problem.is_limit & (problem.limit_lower < problem.limit_upper), TORQUE_WIDENING, 0.0)
    programs = ConvexPrograms(
        H=H,
        g=g,
        A=problem.free,
        lower=lower - widening,
        upper=upper + widening,
        x_lower=np.full((count, unknowns - 1), -np.inf),
        x_upper=np.full((count, unknowns - 1), np.inf),
    )
    answers = solve_programs(programs, solver)
    require_verified(answers, f"torques for c² = {np.min(c2):g}")
    return np.concatenate([answers.x, speed], axis=1), answers.fallbacks


def known_torques(cell: Cell, motion: CoordinatedMotion, sharing: LoadSharing | None, c2: float) -> tuple[Array, Array]:
    """Torques, Shape (N, m), and wrenches, Shape (N, n w), where the object's balance or a sharing leaves nothing free.

    Args:
        cell: The cell, with its load.
        motion: Its motion.
        sharing: A fixed distribution of the load; None with one arm.
        c2: Chosen c².

    Raises:
        InputError: If the sharing does not fit the cell.
    """
    inputs, name = motion.inputs(cell.load), "wrench_form"
    if sharing is not None:
        inputs, name = inputs | sharing.inputs(cell, motion), "fixed_distribution"
    motors = motor_terms(cell, motion)
    torque, wrench = known_values(cell.library, name, motion.samples, inputs | {GEOMETRY: cell.geometry}, c2)
    return torque if motors is None else torque + motors.torque(float(np.sqrt(c2))), wrench
