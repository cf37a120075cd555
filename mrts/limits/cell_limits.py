# SPDX-License-Identifier: MIT
"""The limits of a cell file: torques, wrenches, what hands can exert, velocities, torque-speed curves."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, freeze
from mrts.cell.cell import KNOWN_CELLS, Cell
from mrts.cell.hands import in_object_axes
from mrts.cell.robot import torque_speed_lines
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import TORQUE_SPEED, LimitRows, RowName, joint_rows, object_axes, row_names, wrench_rows


def torque_limits(cell: Cell, _motion: CoordinatedMotion | None = None) -> LimitRows:
    """Eq. (8): τ⁻ <= τ <= τ⁺, one row a joint."""
    names, sides = joint_rows(cell, "torque", "torque_units"), map(cell.stacked, ("torque_lower", "torque_upper"))
    return LimitRows.of(cell, names, *sides, torque_matrix=np.eye(len(names)))


def wrench_limits(cell: Cell, _motion: CoordinatedMotion | None = None) -> LimitRows:
    """Eq. (24): F_min <= F_i <= F_max in the axes of robot i's base, one row a component."""
    names, sides = wrench_rows(cell, "wrench"), map(cell.stacked, ("wrench_lower", "wrench_upper"))
    return LimitRows.of(cell, names, *sides, wrench_matrix=np.eye(len(names)))


def contact_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows | None:
    """Rows lower <= A F_i <= upper of every contact of every robot, in base axes or in those of the object."""
    contacts = [(robot, contact) for robot in cell.robots for contact in robot.contacts]
    if not contacts:
        return None
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
    turns = {"object_matrix": in_object, "object_axes": object_axes(cell, motion)} if np.any(in_object) else {}
    return LimitRows.of(cell, names, lower, upper, wrench_matrix=in_base, **turns)


def velocity_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows | None:
    """`velocity_rows` where they are enforced."""
    return velocity_rows(cell, motion) if cell.enforces_velocity_limits else None


def velocity_rows(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """-v <= q' ṙ <= v, one row a joint, and the sizes of the object's velocity."""
    x, y, z = motion.object.twist.reshape(-1, 2, 3).transpose(2, 0, 1)
    speed = np.concatenate([motion.dq, np.sqrt(x**2 + y**2 + z**2)], axis=1)
    return replace(_velocity_sides(cell), speed=speed)


@lru_cache(maxsize=KNOWN_CELLS)
def _velocity_sides(cell: Cell) -> LimitRows:
    names = joint_rows(cell, "velocity", "position_units", "/s")
    of_object = row_names("velocity", "object", ("linear", "angular"), ("m/s", "rad/s"))
    limit = np.append(cell.stacked("velocity_limit"), cell.object_velocity_limit)
    least = np.append(-limit[:-2], [-np.inf, -np.inf])  # the object's are sizes
    rows = LimitRows.of(cell, names + of_object, least, limit)
    freeze(rows)
    return rows


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
    names, joint, limit, slope = curve_rows(cell)
    if not names:
        return None
    of_torque = np.isfinite(slope)
    matrix = of_torque[:, None] * np.eye(motion.q.shape[1])[joint]
    speed = np.where(of_torque, slope, 1.0) * motion.dq[:, joint]
    return LimitRows.of(cell, names, -limit, limit, torque_matrix=matrix, speed=speed)
