# SPDX-License-Identifier: MIT
"""The limits of a cell file: torques, wrenches, what hands can exert, velocities, torque-speed curves."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import KNOWN_CELLS, Cell
from mrts.cell.hands import in_object_axes
from mrts.cell.robot import torque_speed_lines
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import TORQUE_SPEED, LimitRows, RowLimits, RowName, joint_rows, object_axes, wrench_rows


def torque_limits(cell: Cell, _motion: CoordinatedMotion | None = None) -> LimitRows:
    """Eq. (8): τ⁻ <= τ <= τ⁺, one row a joint."""
    return _fixed_limits(cell)[0]


def wrench_limits(cell: Cell, _motion: CoordinatedMotion | None = None) -> LimitRows:
    """Eq. (24): F_min <= F_i <= F_max in the axes of robot i's base, one row a component."""
    return _fixed_limits(cell)[1]


@lru_cache(maxsize=KNOWN_CELLS)
def _fixed_limits(cell: Cell) -> tuple[LimitRows, LimitRows]:
    of_joints, of_hands = joint_rows(cell, "torque", "torque_units"), wrench_rows(cell, "wrench")
    torque, wrench = ([cell.stacked(f"{kind}_{side}") for side in ("lower", "upper")] for kind in ("torque", "wrench"))
    return (
        LimitRows.of(cell, of_joints, *torque, torque_matrix=np.eye(len(of_joints))),
        LimitRows.of(cell, of_hands, *wrench, wrench_matrix=np.eye(len(of_hands))),
    )


def contact_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows | None:
    """Rows lower <= A F_i <= upper of every contact of every robot, in base axes or in those of the object."""
    if not any(robot.contacts for robot in cell.robots):
        return None
    limits = _contact_sides(cell)
    return LimitRows(limits=limits, object_axes=None if limits.object_matrix is None else object_axes(cell, motion))


@lru_cache(maxsize=KNOWN_CELLS)
def _contact_sides(cell: Cell) -> RowLimits:
    contacts = [(robot, contact) for robot in cell.robots for contact in robot.contacts]
    names = tuple(
        RowName("contact", robot.name, f"{contact.name} {row}", unit)
        for robot, contact in contacts
        for row, unit in zip(contact.rows, contact.units, strict=True)
    )
    in_base, in_object = np.zeros((2, len(names), len(cell.robots) * len(cell.wrench_components)))
    start = 0
    for robot, contact in contacts:
        rows = slice(start, start + len(contact.rows)), cell.wrench_slices[robot.name]
        if contact.frame == "base":
            in_base[rows] = contact.A
        else:
            turn = np.eye(3) if contact.frame == "object" else robot.T_object_tip.R
            in_object[rows] = in_object_axes(contact.A, turn, cell.wrench_components)
        start += len(contact.rows)
    lower, upper = (np.concatenate([getattr(contact, side) for _, contact in contacts]) for side in ("lower", "upper"))
    turned = in_object if np.any(in_object) else None
    return RowLimits.of(cell, names, lower, upper, wrench_matrix=in_base, object_matrix=turned)


def velocity_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows | None:
    """`velocity_rows` where they are enforced."""
    return velocity_rows(cell, motion) if cell.enforces_velocity_limits else None


def velocity_rows(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """-v <= q' ṙ <= v, one row a joint, and the sizes of the object's velocity."""
    x, y, z = motion.object.twist.reshape(-1, 2, 3).transpose(2, 0, 1)
    speed = np.concatenate([motion.dq, np.sqrt(x**2 + y**2 + z**2)], axis=1)
    return LimitRows(limits=_velocity_sides(cell), speed=speed)


@lru_cache(maxsize=KNOWN_CELLS)
def _velocity_sides(cell: Cell) -> RowLimits:
    names = joint_rows(cell, "velocity", "position_units", "/s")
    of_object = RowName("velocity", "object", "linear", "m/s"), RowName("velocity", "object", "angular", "rad/s")
    limit = np.append(cell.stacked("velocity_limit"), cell.object_velocity_limit)
    least = np.append(-limit[:-2], [-np.inf, -np.inf])  # the object's are sizes
    return RowLimits.of(cell, names + of_object, least, limit, ["speed"])


@lru_cache(maxsize=KNOWN_CELLS)
def curve_rows(cell: Cell) -> tuple[list[RowName], NDArray[np.intp], Array, Array]:
    """The rows of all torque-speed curves of a cell, joint by joint: |τ| <= limit - slope |q̇|, then |q̇| <= limit.

    Returns:
        Names; places among all joints; limits; slopes, NaN at the end of a curve, each Shape (r,).
    """
    names, rows = list[RowName](), list[tuple[int, float, float]]()
    for robot, part in zip(cell.robots, cell.joint_slices.values(), strict=True):
        for j, curve in enumerate(robot.motors.torque_speed):
            if curve is not None:
                lines = torque_speed_lines(curve)
                names += [RowName(TORQUE_SPEED, robot.name, robot.joints[j], robot.torque_units[j])] * len(lines)
                names.append(RowName("motor speed", robot.name, robot.joints[j], f"{robot.position_units[j]}/s"))
                rows += [(part.start + j, *line) for line in (*lines, (float(curve[-1, 0]), np.nan))]
    joint, limit, slope = np.reshape(rows, (-1, 3)).T
    return names, joint.astype(np.intp), limit, slope


def motor_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows | None:
    """|τ| <= a - m |q̇| for each falling line of a motor's torque-speed curve, and |q̇| up to the curve's end.

    A line holds while the motor drives, where τ and q̇ have one sign: -a <= τ + m q' ṙ <= a. Where it brakes that
    leaves more than the plain limit of the torque, which is a limit of its own.
    """
    _, joint, _, slope = curve_rows(cell)
    if not len(joint):
        return None
    return LimitRows(limits=_curve_sides(cell), speed=np.where(np.isfinite(slope), slope, 1.0) * motion.dq[:, joint])


@lru_cache(maxsize=KNOWN_CELLS)
def _curve_sides(cell: Cell) -> RowLimits:
    names, joint, limit, slope = curve_rows(cell)
    matrix = np.isfinite(slope)[:, None] * np.eye(len(cell.joint_names))[joint]
    return RowLimits.of(cell, names, -limit, limit, ["speed"], torque_matrix=matrix)
