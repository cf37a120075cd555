# SPDX-License-Identifier: MIT
"""From a cell and its motion to the linear rows of every sample: any formulation, constant and varying speed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply, with_part
from mrts.base.errors import InputError, MotionError
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import ActiveRow, LimitRows, RowName, counted_sizes, turned
from mrts.program.formulation import FORMULATIONS
from mrts.program.motion_rows import MotionRows, MotorTerms, largest_square, side_share
from mrts.program.solvers import DEFAULT_SOLVER

TORQUE_FORM_CONDITION_LIMIT = 1e6
"""J^-T is formed explicitly by the torque form: at this condition number ten digits are left."""


BLOCK = 4096
"""Samples whose terms and rows are evaluated at a time: they are many numbers a sample."""

NO_EFFECT = 1e-300
"""What moves no row by more than this share of a limit moves none: its scale is infinite. As in numbers.h."""

MOVED = 1e-12
"""A row whose free unknowns have coefficients below this share of the sample's largest is moved by no distribution."""

MAPS = ("torque_map", "torque_offset", "torque_speed", "wrench_map", "wrench_offset")
OF_ROWS = ("unit", "is_limit", "is_cap", "limit_lower", "limit_upper")
OF_SAMPLES = ("A", "lower", "upper", "speed")
"""Attributes with samples, with rows, and with rows of each sample."""


@dataclass(frozen=True, kw_only=True)
class SampleProblem:
    """Torques and wrenches as affine functions of the unknowns x at N samples, and the rows that limit them.

    The last unknown is c², or ṙ² where the speed varies, and then the one before it is r̈; those before are free.
    τ = torque_map x + torque_speed ṙ + torque_offset is what the motors give, F = wrench_map x + wrench_offset, and
    rows are lower <= A x + speed ṙ <= upper, each divided by its unit, so that a limit has the size 1 whatever its unit
    and magnitude.

    Attributes:
        torque_map: Shape (N, m, k).
        torque_offset: Shape (N, m) [N m].
        wrench_map: Shape (N, n w, k).
        wrench_offset: Shape (N, n w) [N, N m].
        names: One a row.
        unit: What 100 % of a row's limit is, Shape (r,).
        is_limit: False for what is given of the speed and cannot move outward, Shape (r,).
        is_cap: Rows that do nothing but bound the last unknown from above, Shape (r,).
        A: Shape (N, r, k).
        lower: Shape (N, r).
        upper: Shape (N, r).
        limit_lower: The limits as given, before offsets, Shape (r,).
        limit_upper: Likewise, Shape (r,).
        torque_speed: What ṙ adds to the torques, Shape (N, m); None where it adds nothing.
        speed: Shape (N, r); None where no row has a term in ṙ.
        solver: Name in the registry of what solves programs of these rows.
    """

    torque_map: Array
    torque_offset: Array
    wrench_map: Array
    wrench_offset: Array
    names: tuple[RowName, ...]
    unit: Array
    is_limit: NDArray[np.bool_]
    is_cap: NDArray[np.bool_]
    A: Array
    lower: Array
    upper: Array
    limit_lower: Array
    limit_upper: Array
    torque_speed: Array | None = None
    speed: Array | None = None
    solver: str = DEFAULT_SOLVER

    @property
    def samples(self) -> int:
        """Number of samples N."""
        return len(self.A)

    @property
    def unknowns(self) -> int:
        """Number of unknowns k, those of the speed included."""
        return int(self.A.shape[2])

    @property
    def free(self) -> Array:
        """The columns of A of all unknowns but the last, Shape (N, r, k - 1)."""
        return self.A[:, :, :-1]

    @property
    def square(self) -> Array:
        """The column of A of the last unknown, c² or ṙ², Shape (N, r)."""
        return self.A[:, :, -1]

    @property
    def rate(self) -> Array:
        """The column of A of r̈ where the speed varies, Shape (N, r)."""
        return self.A[:, :, -2]

    @property
    def counted(self) -> Array:
        """`counted_sizes` of the limits, Shape (2, r)."""
        return counted_sizes(self.limit_lower, self.limit_upper, self.unit)

    @property
    def moved(self) -> NDArray[np.bool_]:
        """Rows that some distribution moves, at each sample, Shape (N, r)."""
        return moved_by(self.free)

    def limits_at(self, c2: float | Array) -> tuple[Array, Array]:
        """The limits that are left for the other unknowns at a value of the last, one for all or each, Shape (N, r)."""
        given = self.square * c2
        if self.speed is not None:
            given = given + self.speed * np.sqrt(c2)
        return self.lower - given, self.upper - given

    @property
    def cap_share(self) -> Array:
        """What each cap is of its limit where the last unknown is 1, Shape (N, s)."""
        caps = self.is_cap
        return side_share(self.square[:, caps], self.lower[:, caps], self.upper[:, caps])

    def cap(self) -> Array:
        """Largest value of the last unknown that the caps allow, infinity where they do not bound it, Shape (N,)."""
        return largest_square(self.cap_share)

    def effect(self, *, caps: bool) -> Array:
        """Largest effect of c² = 1 on a row, by its term in c² or the square of its term in c, Shape (N,).

        Args:
            caps: True counts all rows, so that c² has a scale where caps alone limit it. False counts those of torques
                and wrenches alone, as the kernel does: whether these depend on c² at all.
        """
        rows = slice(None) if caps else ~self.is_cap
        effect: Array = np.max(np.abs(self.square[:, rows]), axis=1, initial=0.0)
        if self.speed is not None:
            effect = np.maximum(effect, np.max(np.abs(self.speed[:, rows]), axis=1, initial=0.0) ** 2)
        return np.where(effect > NO_EFFECT, effect, 0.0)

    def torque(self, x: Array) -> Array:
        """Torques of unknowns x, Shape (N, k), as Shape (N, m) [N m]."""
        torque = apply(self.torque_map, x) + self.torque_offset
        return torque if self.torque_speed is None else torque + self.torque_speed * np.sqrt(x[:, -1:])

    def wrench(self, x: Array) -> Array:
        """Wrenches of unknowns x, Shape (N, k), as Shape (N, n w) [N, N m], base axes."""
        return apply(self.wrench_map, x) + self.wrench_offset

    def active_row(self, row: int, *, upper: bool) -> ActiveRow:
        """One row at one of its limits, in its own unit."""
        limits = float(self.limit_lower[row]), float(self.limit_upper[row])
        return ActiveRow.of(self.names[row], *limits, at_upper=upper)

    def at(self, samples: NDArray[np.int_]) -> "SampleProblem":
        """The same problem at some samples only (indices or a mask)."""
        return with_part(self, (*MAPS, *OF_SAMPLES), samples)

    def with_rows(self, names: Sequence[RowName], **columns: Any) -> "SampleProblem":
        """The same problem with s more rows, which have no term in ṙ; columns are their attributes."""
        more: dict[str, Any] = {
            name: np.concatenate([getattr(self, name), part], axis=1 if np.ndim(part) > 1 else 0)
            for name, part in columns.items()
        }
        if self.speed is not None:
            more["speed"] = np.concatenate([self.speed, np.zeros((self.samples, len(names)))], axis=1)
        return replace(self, names=(*self.names, *names), **more)

    def only(self, rows: NDArray[np.int_]) -> "SampleProblem":
        """The same problem with some of the rows, in this order."""
        some = with_part(self, OF_ROWS, rows, names=tuple([self.names[row] for row in rows.tolist()]))
        return with_part(some, OF_SAMPLES, (slice(None), rows))


def moved_by(free: Array) -> NDArray[np.bool_]:
    """Rows that some distribution moves, at each sample, Shape (N, r); their free columns have Shape (N, r, f)."""
    size = np.max(np.abs(free), axis=2, initial=0.0)
    return np.asarray(size > MOVED * np.max(size, axis=1, keepdims=True, initial=0.0))


def build_sample_problem(
    rows: MotionRows, *, load: Array | None = None, samples: NDArray[np.int_] | None = None, varying: bool = False
) -> SampleProblem:
    """Evaluate the generated formulation along the motion and put every limit into rows.

    Where the speed varies these are eqs. (11) to (18) with r̈: τ = A r̈ + E ṙ² + G + JᵀF and Σ B F = S r̈ + P ṙ² + Q. Free
    unknowns are F_1 … F_{n-1}, in the torque form those τ that balance the object, none of a fixed distribution.

    Args:
        rows: Rows of a cell along its motion; where the speed varies, its time is the path parameter r.
        load: Load vector instead of the cell's, Shape (10,), or one for each of these samples, Shape (k, 10).
        samples: Indices of the k samples to take; None takes all.
        varying: Whether the speed varies.

    Raises:
        InputError: If the formulation does not exist, or the sharing does not fit the cell.
        MotionError: If the torque form meets a Jacobian that is not square or not well-conditioned.
    """
    cell, motion, formulation = rows.cell, rows.motion, rows.formulation
    inputs = rows.inputs(load, samples)
    if formulation not in FORMULATIONS:
        raise InputError("formulation", f"must be {' or '.join(map(repr, FORMULATIONS))}.", value=formulation)
    if rows.sharing is None and formulation == "torque":
        _check_invertible(cell, motion, np.arange(motion.samples) if samples is None else samples)
    count, limits, motors = motion.samples, rows.rows, rows.motors
    if samples is not None:
        count, limits, motors = len(samples), limits.at(samples), None if motors is None else motors.at(samples)
    found = _maps(cell, "fixed_distribution" if rows.sharing else f"{formulation}_form", count, inputs, varying=varying)
    if "equality_map" in found:
        found = _balanced(found)
    size = rows.given.units
    found |= _rows_of_maps(limits, size, found, motors, varying=varying)
    torque_speed, speed = None if motors is None else motors.speed, limits.speed
    if torque_speed is not None:
        speed = torque_speed @ limits.torque_matrix.T + (0.0 if speed is None else speed)
    return SampleProblem(
        **found,
        torque_speed=torque_speed,
        names=rows.given.names,
        unit=rows.unit,
        is_limit=np.ones(len(size), dtype=bool),
        is_cap=rows.is_cap,
        speed=None if speed is None else speed / size,
        limit_lower=rows.given.lower,
        limit_upper=rows.given.upper,
        solver=rows.solver,
    )


def _maps(cell: Cell, name: str, count: int, inputs: dict[str, Array], *, varying: bool) -> dict[str, Array]:
    """What a generated formulation gives; maps have Shape (count, rows, k), with the column of r̈ where speed varies.

    That column is the one of c² for the motion with velocities as accelerations: at q' = 0 and q'' → q' the terms E and
    P are A and S, as no term quadratic in velocities is left.
    """
    found = cell.functions(name, count, inputs)
    unknowns = found["torque_map"].shape[2] if found["torque_map"].ndim == 3 else 1  # noqa: PLR2004 (N, m, k)
    by_rate = None
    if varying:
        dq, twist = inputs["dq"], inputs["object_twist"]
        still = {"dq": np.zeros(dq.shape[1]), "object_twist": np.zeros(6), "ddq": dq, "object_acceleration": twist}
        by_rate = _maps(cell, name, count, inputs | still, varying=False)
    for key, value in found.items():
        if key.endswith("_map"):
            found[key] = value.reshape(count, -1, unknowns)
            if by_rate is not None:  # maps lie in memory by columns
                ours, theirs = found[key].transpose(0, 2, 1), by_rate[key].transpose(0, 2, 1)
                found[key] = np.concatenate([ours[:, :-1], theirs[:, -1:], ours[:, -1:]], axis=1).transpose(0, 2, 1)
    return found


def _balanced(maps: dict[str, Array]) -> dict[str, Array]:
    """The torque form over what the balance of the object, equality_map x = equality_rhs, leaves free of τ."""
    balance, rhs = maps["equality_map"], maps["equality_rhs"]
    (count, laws, unknowns), torques = balance.shape, maps["torque_map"].shape[1]
    *_, directions = np.linalg.svd(balance[:, :, :torques])
    inverse, free = np.linalg.pinv(balance[:, :, :torques]), torques - laws
    turn = np.zeros((count, unknowns, unknowns - laws))  # x = turn [y, those of the speed] + shift
    turn[:, :torques, :free] = directions[:, laws:].transpose(0, 2, 1)
    turn[:, :torques, free:] = -inverse @ balance[:, :, torques:]
    turn[:, torques:, free:] = np.eye(unknowns - torques)
    shift = np.zeros((count, unknowns))
    shift[:, :torques] = apply(inverse, rhs)
    return {
        "torque_map": maps["torque_map"] @ turn,
        "torque_offset": maps["torque_offset"] + apply(maps["torque_map"], shift),
        "wrench_map": maps["wrench_map"] @ turn,
        "wrench_offset": maps["wrench_offset"] + apply(maps["wrench_map"], shift),
    }


def _rows_of_maps(
    rows: LimitRows, size: Array, maps: dict[str, Array], motors: MotorTerms | None, *, varying: bool
) -> dict[str, Array]:
    """The limits over the unknowns, each row divided by its size; what motors add to c² and r̈ is added to the maps."""
    if motors is not None:
        maps["torque_offset"] = maps["torque_offset"] + motors.dry
        maps["torque_map"][:, :, -1] += motors.square
        if varying:
            maps["torque_map"][:, :, -2] += motors.rate
    moves = rows.of_forces
    count, _, unknowns = maps["torque_map"].shape
    A, offset = np.zeros((count, len(size), unknowns)), np.zeros((count, len(size)))
    M_torque, M_wrench = rows.torque_matrix[moves], rows.wrench_matrix[moves]
    moved_by_forces, given = _over_samples(M_torque, maps["torque_map"]), maps["torque_offset"] @ M_torque.T
    if M_wrench.any():
        moved_by_forces = moved_by_forces + _over_samples(M_wrench, maps["wrench_map"])
        given = given + maps["wrench_offset"] @ M_wrench.T
    A[:, moves], offset[:, moves] = moved_by_forces, given
    if rows.object_matrix is not None and rows.object_axes is not None:
        moved = rows.object_matrix.any(axis=1)
        A[:, moved] += rows.object_matrix[moved] @ turned(rows.object_axes, maps["wrench_map"])
        offset[:, moved] += turned(rows.object_axes, maps["wrench_offset"]) @ rows.object_matrix[moved].T
    if rows.square is not None:
        A[:, :, -1] += rows.square
    if rows.offset is not None:
        offset += rows.offset
    if rows.rate is not None and varying:
        A[:, :, -2] += rows.rate
    inward = None if motors is None else motors.margin(rows)
    margin = np.zeros(1) if inward is None else inward
    lower, upper = (rows.lower + margin - offset) / size, (rows.upper - margin - offset) / size
    A /= size[:, None]
    return {"A": A, "lower": lower, "upper": upper}


def _over_samples(matrix: Array, maps: Array) -> Array:
    """A matrix, Shape (r, s), times the maps of all samples, Shape (N, s, k), which lie by columns: one product."""
    by_column = maps.transpose(0, 2, 1)
    found: Array = (by_column.reshape(-1, by_column.shape[2]) @ matrix.T).reshape(*by_column.shape[:2], -1)
    return found.transpose(0, 2, 1)


def _check_invertible(cell: Cell, motion: CoordinatedMotion, samples: NDArray[np.int_]) -> None:
    J = cell.functions("kinematics", len(samples), {"q": motion.q[samples]})["jacobian"]
    for robot in cell.robots:
        if len(robot.joints) != J.shape[1]:
            raise MotionError(
                f"the torque form needs a square Jacobian: robot '{robot.name}' has {len(robot.joints)} joints and "
                f"{J.shape[1]} wrench components. Use the wrench form."
            )
        condition = np.linalg.cond(J[:, :, cell.joint_slices[robot.name]])
        worst = samples[int(np.argmax(condition))]
        if not np.max(condition) <= TORQUE_FORM_CONDITION_LIMIT:
            raise MotionError(
                f"the torque form inverts Jacobians: at sample {worst} (t = {motion.object.time[worst]:.6g} s) that of "
                f"robot '{robot.name}' has the condition number {np.max(condition):.3g}, the limit is "
                f"{TORQUE_FORM_CONDITION_LIMIT:.0e}. Use the wrench form."
            )
