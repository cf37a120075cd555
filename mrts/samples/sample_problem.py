# SPDX-License-Identifier: MIT
"""From a cell and its motion to the linear rows of every sample, in any formulation."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply
from mrts.base.errors import InputError, MotionError
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits import cell_rows
from mrts.limits.rows import ActiveRow, RowName
from mrts.limits.velocity_limits import VelocityLimits, velocity_limits
from mrts.samples import FORMULATIONS, FormulationName
from mrts.samples.load_sharing import LoadSharing

TORQUE_FORM_CONDITION_LIMIT = 1e6
"""J^-T is formed explicitly by the torque form: at this condition number ten digits are left."""


@dataclass(frozen=True)
class SampleProblem:
    """Torques and wrenches as affine functions of the unknowns x, c² last, at N samples.

    τ = torque_map x + torque_offset, F = wrench_map x + wrench_offset, and rows lower <= A x <= upper, each divided by
    its unit, so that a limit has the size 1 whatever its unit and magnitude.

    Attributes:
        torque_map: Shape (N, m, k).
        torque_offset: Shape (N, m) [N m].
        wrench_map: Shape (N, n w, k).
        wrench_offset: Shape (N, n w) [N, N m].
        names: One a row.
        unit: What 100 % of a row's limit is; 1 for the object's balance, which is no limit, Shape (r,).
        is_limit: False for the object's balance, Shape (r,).
        A: Shape (N, r, k).
        lower: Shape (N, r).
        upper: Shape (N, r).
        limit_lower: The limits as given, before offsets, Shape (r,).
        limit_upper: Likewise, Shape (r,).
    """

    torque_map: Array
    torque_offset: Array
    wrench_map: Array
    wrench_offset: Array
    names: tuple[RowName, ...]
    unit: Array
    is_limit: NDArray[np.bool_]
    A: Array
    lower: Array
    upper: Array
    limit_lower: Array
    limit_upper: Array

    @property
    def samples(self) -> int:
        """Number of samples N."""
        return len(self.A)

    @property
    def unknowns(self) -> int:
        """Number of unknowns k, c² included."""
        return int(self.A.shape[2])

    @property
    def is_velocity(self) -> NDArray[np.bool_]:
        """Rows that bound c² (or x) alone: velocity limits, Shape (r,)."""
        return np.array([name.kind == "velocity" for name in self.names], dtype=bool)

    def velocity_cap(self) -> Array:
        """Largest value of the last unknown that velocities allow, infinity where they do not bound it, Shape (N,)."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.min(1 / self.A[:, self.is_velocity, -1], axis=1, initial=np.inf), dtype=np.float64)

    def torque(self, x: Array) -> Array:
        """Torques of unknowns x, Shape (N, k), as Shape (N, m) [N m]."""
        return apply(self.torque_map, x) + self.torque_offset

    def wrench(self, x: Array) -> Array:
        """Wrenches of unknowns x, Shape (N, k), as Shape (N, n w) [N, N m], base axes."""
        return apply(self.wrench_map, x) + self.wrench_offset

    def active_row(self, row: int, *, upper: bool) -> ActiveRow:
        """One row at one of its limits, in its own unit."""
        limit = self.limit_upper[row] if upper else self.limit_lower[row]
        return ActiveRow(self.names[row], "upper" if upper else "lower", float(limit))

    def at(self, samples: NDArray[np.int_]) -> "SampleProblem":
        """The same problem at some samples only (indices or a mask)."""
        return replace(
            self,
            torque_map=self.torque_map[samples],
            torque_offset=self.torque_offset[samples],
            wrench_map=self.wrench_map[samples],
            wrench_offset=self.wrench_offset[samples],
            A=self.A[samples],
            lower=self.lower[samples],
            upper=self.upper[samples],
        )


def build_sample_problem(
    cell: Cell,
    motion: CoordinatedMotion,
    formulation: FormulationName = "wrench",
    sharing: LoadSharing | None = None,
    load: Array | None = None,
    samples: NDArray[np.int_] | None = None,
) -> SampleProblem:
    """Evaluate the generated formulation along the motion and put every limit into rows.

    Args:
        cell: The cell.
        motion: Its motion.
        formulation: "wrench" (unknowns F_1 … F_{n-1}, c²) or "torque" (unknowns τ, c²).
        sharing: A fixed distribution of the load: the only unknown is c², whatever the formulation.
        load: Load vector instead of the cell's, Shape (10,), or one a sample, Shape (N, 10).
        samples: Indices of the samples to take; None takes all.

    Raises:
        InputError: If the formulation does not exist, or the sharing does not fit the cell.
        MotionError: If the torque form meets a Jacobian that is not square or not well-conditioned.
    """
    inputs = motion.inputs(cell.load if load is None else load)
    if formulation not in FORMULATIONS:
        raise InputError("formulation", f"must be {' or '.join(map(repr, FORMULATIONS))}.", value=formulation)
    if sharing is not None:
        inputs |= sharing.inputs(cell, motion)
    elif formulation == "torque":
        _check_invertible(cell, motion)
    count = motion.samples
    if samples is not None:
        one_for_all = {name for name, value in inputs.items() if value.ndim == 1}
        inputs = {name: value if name in one_for_all else value[samples] for name, value in inputs.items()}
        count = len(samples)
    maps = cell.functions("fixed_distribution" if sharing else f"{formulation}_form", count, inputs)
    unknowns = maps["torque_map"].shape[2] if maps["torque_map"].ndim == 3 else 1  # noqa: PLR2004 (N, m, k)
    torque_map = maps["torque_map"].reshape(count, -1, unknowns)
    wrench_map = maps["wrench_map"].reshape(count, -1, unknowns)

    rows = cell_rows(cell)
    offset = maps["torque_offset"] @ rows.torque_matrix.T + maps["wrench_offset"] @ rows.wrench_matrix.T
    A = rows.torque_matrix @ torque_map + rows.wrench_matrix @ wrench_map
    lower, upper = rows.lower - offset, rows.upper - offset
    names, limit_lower, limit_upper, unit = rows.names, rows.lower, rows.upper, rows.units()
    if "equality_map" in maps:
        names = (*names, *(RowName("balance", element=part) for part in cell.wrench_components))
        A = np.concatenate([A, maps["equality_map"]], axis=1)
        lower = np.concatenate([lower, maps["equality_rhs"]], axis=1)
        upper = np.concatenate([upper, maps["equality_rhs"]], axis=1)
        nothing = np.zeros(len(cell.wrench_components))
        limit_lower = np.concatenate([limit_lower, nothing])
        limit_upper = np.concatenate([limit_upper, nothing])
        unit = np.concatenate([unit, nothing + 1])
    problem = SampleProblem(
        torque_map,
        maps["torque_offset"],
        wrench_map,
        maps["wrench_offset"],
        names,
        unit,
        np.array([name.kind != "balance" for name in names], dtype=bool),
        A / unit[:, None],
        lower / unit,
        upper / unit,
        limit_lower,
        limit_upper,
    )
    return _with_velocity_limits(problem, velocity_limits(cell, motion), samples)


def _with_velocity_limits(
    problem: SampleProblem, limits: VelocityLimits, samples: NDArray[np.int_] | None
) -> SampleProblem:
    """Add a row a velocity limit: (velocity / limit)² <= 1, linear in c²; 1 % of it are 0.5 % of the velocity."""
    share = limits.share if samples is None else limits.share[samples]
    shape = share.shape
    rows = np.zeros((*shape, problem.unknowns))
    rows[:, :, -1] = share**2
    none = np.full(shape, -np.inf)
    return replace(
        problem,
        names=(*problem.names, *limits.names),
        unit=np.concatenate([problem.unit, limits.limit / 2]),
        is_limit=np.concatenate([problem.is_limit, np.ones(shape[1], dtype=bool)]),
        A=np.concatenate([problem.A, rows], axis=1),
        lower=np.concatenate([problem.lower, none], axis=1),
        upper=np.concatenate([problem.upper, np.ones(shape)], axis=1),
        limit_lower=np.concatenate([problem.limit_lower, -limits.limit]),
        limit_upper=np.concatenate([problem.limit_upper, limits.limit]),
    )


def _check_invertible(cell: Cell, motion: CoordinatedMotion) -> None:
    size = len(cell.wrench_components)
    for robot in cell.robots:
        if len(robot.joints) != size:
            raise MotionError(
                f"the torque form needs a square Jacobian: robot '{robot.name}' has {len(robot.joints)} joints and "
                f"{size} wrench components. Use the wrench form."
            )
    J = cell.functions("kinematics", motion.samples, {"q": motion.q})["jacobian"]
    for robot in cell.robots:
        condition = np.linalg.cond(J[:, :, cell.joint_slices[robot.name]])
        worst = int(np.argmax(condition))
        if not condition[worst] <= TORQUE_FORM_CONDITION_LIMIT:
            raise MotionError(
                f"the torque form inverts Jacobians: at sample {worst} (t = {motion.object.time[worst]:.6g} s) that of "
                f"robot '{robot.name}' has the condition number {condition[worst]:.3g}, the limit is "
                f"{TORQUE_FORM_CONDITION_LIMIT:.0e}. Use the wrench form."
            )
