# SPDX-License-Identifier: MIT
"""The rows of every sample where the speed along the path may vary: unknowns are wrenches, u = r̈ and x = ṙ²."""

from dataclasses import replace

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits import cell_rows
from mrts.samples.load_sharing import LoadSharing
from mrts.samples.sample_problem import SampleProblem, build_sample_problem


def build_path_problem(
    cell: Cell, motion: CoordinatedMotion, sharing: LoadSharing | None = None, load: Array | None = None
) -> SampleProblem:
    """Eqs. (11) to (18) with r̈: τ = A u + E x + G + JᵀF and Σ B F = S u + P x + Q, as rows of [F_1 … F_{n-1}, u, x].

    The column of u is that of c² for the motion with velocities as accelerations: at q' = 0 and q'' → q' the terms E
    and P are A and S, as no term quadratic in velocities is left.

    Args:
        cell: The cell.
        motion: The given motion; its time is the path parameter r.
        sharing: A fixed distribution of the load, which leaves u and x as the only unknowns.
        load: Load vector instead of the cell's, Shape (10,).

    Raises:
        InputError: If the sharing does not fit the cell.
    """
    problem = build_sample_problem(cell, motion, sharing=sharing, load=load)
    given = motion.object
    inputs = motion.inputs(cell.load if load is None else load) | {
        "dq": np.zeros_like(motion.dq),
        "ddq": motion.dq,
        "object_twist": np.zeros_like(given.twist),
        "object_acceleration": given.twist,
    }
    if sharing is not None:
        inputs |= sharing.inputs(cell, motion)
    maps = cell.functions("fixed_distribution" if sharing else "wrench_form", motion.samples, inputs)
    torque, wrench = (
        maps[name].reshape(motion.samples, -1, problem.unknowns)[:, :, -1] for name in ("torque_map", "wrench_map")
    )
    rows = cell_rows(cell)
    by_u = (torque @ rows.torque_matrix.T + wrench @ rows.wrench_matrix.T) / rows.units()
    in_rows = np.zeros(problem.A.shape[:2])
    in_rows[:, : by_u.shape[1]] = by_u
    return replace(
        problem,
        torque_map=_before_last(problem.torque_map, torque),
        wrench_map=_before_last(problem.wrench_map, wrench),
        A=_before_last(problem.A, in_rows),
    )


def _before_last(matrix: Array, column: Array) -> Array:
    """A matrix, Shape (N, r, k), with one more column before its last."""
    return np.concatenate([matrix[:, :, :-1], column[:, :, None], matrix[:, :, -1:]], axis=2)
