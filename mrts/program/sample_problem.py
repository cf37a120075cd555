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
from mrts.kernel.binding import filled
from mrts.kernel.cell_library import pointers
from mrts.limits.rows import ActiveRow, RowName, counted_sizes
from mrts.program.formulation import FORMULATIONS
from mrts.program.motion_rows import TERMS, MotionRows, added_terms, largest_square, side_share
from mrts.program.solvers import DEFAULT_SOLVER

TORQUE_FORM_CONDITION_LIMIT = 1e6
"""J^-T is formed explicitly by the torque form: at this condition number ten digits are left."""


BLOCK = 4096
"""Samples whose terms and rows are evaluated at a time: they are many numbers a sample."""

NO_EFFECT = 1e-300
"""What moves no row by more than this share of a limit moves none: its scale is infinite. As in numbers.h."""

MOVED = 1e-12
"""A row whose free unknowns have coefficients below this share of the sample's largest is moved by no distribution."""

FORM = ("torque_map", "torque_offset", "wrench_map", "wrench_offset")
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
        """What each cap is of its limit where the last unknown is 1, as from `side_share`, Shape (N, s)."""
        caps = self.is_cap
        return side_share(self.square[:, caps], self.lower[:, caps], self.upper[:, caps])

    @property
    def most(self) -> Array:
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
        return with_part(self, (*FORM, "torque_speed", *OF_SAMPLES), samples)

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
    cell, motion, formulation, size = rows.cell, rows.motion, rows.formulation, rows.given.limits.units
    inputs = rows.inputs(load, samples)
    if formulation not in FORMULATIONS:
        raise InputError("formulation", f"must be {' or '.join(map(repr, FORMULATIONS))}.", value=formulation)
    if rows.sharing is None and formulation == "torque":
        _check_invertible(cell, motion, np.arange(motion.samples) if samples is None else samples)
    given, motors = rows.rows, rows.motors
    if samples is not None:
        given, motors = given.at(samples), None if motors is None else motors.at(samples)
    name = "fixed_distribution" if rows.sharing else f"{formulation}_form"
    maps = cell.library.map(name, motion.samples if samples is None else len(samples), inputs, varying=varying)
    maps = {key: _by_columns(value) if key.endswith("_map") else value for key, value in maps.items()}
    if "equality_map" in maps:
        maps = _balanced(maps)
    (count, k, _), r = maps["torque_map"].shape, len(size)
    A, (lower, upper) = np.empty((count, r, k)), np.empty((2, count, r))
    speed = np.empty((count, r)) if rows.has_speed_terms else None
    rate = {"torque_square": motors and motors.rate, "square": given.rate} if varying else {}
    form, limits = pointers([maps[name] for name in FORM]), given.limits.in_c
    cell.library.opened.mrts_form_rows(
        *(count, k, form, inputs["object_rotation"], limits, added_terms(given, motors), filled(TERMS, **rate)),
        *(size, np.arange(r, dtype=np.int32), A, lower, upper, speed, np.empty((k + 1) * (1 + cell.library.wrenches))),
    )
    return SampleProblem(
        torque_map=maps["torque_map"].transpose(0, 2, 1),
        torque_offset=maps["torque_offset"],
        wrench_map=maps["wrench_map"].transpose(0, 2, 1),
        wrench_offset=maps["wrench_offset"],
        torque_speed=None if motors is None else motors.speed,
        names=rows.given.names,
        unit=rows.unit,
        is_limit=np.ones(r, dtype=bool),
        is_cap=rows.is_cap,
        A=A,
        lower=lower,
        upper=upper,
        speed=speed,
        limit_lower=rows.given.limits.lower,
        limit_upper=rows.given.limits.upper,
        solver=rows.solver,
    )


def _by_columns(value: Array) -> Array:
    """A map, Shape (N, rows, k), or of one unknown (N, rows), as Shape (N, k, rows)."""
    return value[:, None] if value.ndim == 2 else value.transpose(0, 2, 1)  # noqa: PLR2004 (N, rows)


def _balanced(maps: dict[str, Array]) -> dict[str, Array]:
    """The torque form over what the balance of the object, equality_map x = equality_rhs, leaves free of τ."""
    balance, rhs = maps["equality_map"].transpose(0, 2, 1), maps["equality_rhs"]
    (count, laws, unknowns), torques = balance.shape, maps["torque_map"].shape[2]
    *_, directions = np.linalg.svd(balance[:, :, :torques])
    inverse, free = np.linalg.pinv(balance[:, :, :torques]), torques - laws
    turn = np.zeros((count, unknowns - laws, unknowns))  # x = turnᵀ [y, those of the speed] + shift
    turn[:, :free, :torques] = directions[:, laws:]
    turn[:, free:, :torques] = -(inverse @ balance[:, :, torques:]).transpose(0, 2, 1)
    turn[:, free:, torques:] = np.eye(unknowns - torques)
    shift = np.zeros((count, unknowns))
    shift[:, :torques] = apply(inverse, rhs)
    for of in ("torque", "wrench"):
        its = maps[f"{of}_map"]
        maps |= {f"{of}_map": turn @ its, f"{of}_offset": maps[f"{of}_offset"] + (shift[:, None] @ its)[:, 0]}
    return maps


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
