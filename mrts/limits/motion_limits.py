# SPDX-License-Identifier: MIT
"""Limits of the motion alone, whatever carries it: accelerations, points of arms and object, things on the object."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from mrts.base.arrays import Array, cross, row_products
from mrts.base.rigid_transform import rotations_from_vectors
from mrts.cell.cell import Cell
from mrts.cell.points import ArmPointLimit, CarriedThing, PointLimit
from mrts.cell.robot import Robot
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import KNOWN_LIMITS, LimitRows, RowLimits, RowName, joint_rows, row_names, stack_rows

NORM_SIDES = 224
"""Sides of the polygon that stands for a circle: inside it, by at most 1 - cos(π / 224) < 1e-4 of the radius."""

STANDING = ("friction", "tilt +a", "tilt -a", "tilt +b", "tilt -b")
"""What keeps a thing on the object where it stands."""


def acceleration_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows | None:
    """a⁻ <= q' r̈ + q'' ṙ² <= a⁺, one row a joint, and the sizes of the object's acceleration."""
    if not cell.limits_motion:
        return None
    pieces = [LimitRows(limits=_joint_sides(cell), rate=motion.dq, square=motion.ddq).bounded]
    names = row_names("acceleration", "object", ("linear", "angular"), ("m/s²", "rad/s²"))
    rates, given = motion.object.twist.reshape(-1, 2, 3), motion.object.acceleration.reshape(-1, 2, 3)
    for part, (name, limit) in enumerate(zip(names, cell.object_acceleration_limit.tolist(), strict=True)):
        if np.isfinite(limit):
            pieces.append(norm_rows(cell, name, rates[:, part], given[:, part], limit))
    return stack_rows(pieces)


@lru_cache(maxsize=KNOWN_LIMITS)
def _joint_sides(cell: Cell) -> RowLimits:
    names = joint_rows(cell, "acceleration", "position_units", "/s²")
    lower, upper = map(cell.stacked, ("acceleration_lower", "acceleration_upper"))
    return RowLimits.of(cell, names, lower, upper, ("rate", "square"))


def point_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows | None:
    """Speed |p'| ṙ and acceleration |p' r̈ + p'' ṙ²| of points of arms and object."""
    if not cell.limits_motion:
        return None
    pieces = []
    for robot, joints in zip(cell.robots, cell.joint_slices.values(), strict=True):
        given = [of[:, joints] for of in (motion.q, motion.dq, motion.ddq)]
        for point in robot.point_limits:
            pieces += _of_point(cell, robot.name, point, *arm_point(robot, point, *given))
    for own in cell.object_points:
        pieces += _of_point(cell, "object", own, *object_point(motion, np.array(own.point)))
    return stack_rows(pieces) if pieces else None


def carried_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows | None:
    """Things that stand loose on the object neither slide nor tip.

    What one takes from the object, per mass, is s = Rᵀ (p' r̈ + p'' ṙ² - gravity) at its centre of mass. In its own axes
    a, b, n: |(s_a, s_b)| <= friction × s_n, and |s_a| height <= half width × s_n, likewise along b.
    """
    if not cell.carried:
        return None
    size, pieces = max(float(np.linalg.norm(cell.gravity)), 1.0), []
    for thing in cell.carried:
        axes, names = _facets(thing)
        turn = axes @ motion.object.rotation.transpose(0, 2, 1)
        rate, square = (np.einsum("nkj,nj->nk", turn, of) for of in object_point(motion, thing.centre))
        named = [RowName("contact", "object", f"{thing.name} {what}", "m/s²", sides) for what, sides in names]
        none, terms = np.full(len(axes), -np.inf), {"rate": rate, "square": square, "offset": -turn @ cell.gravity}
        sizes = size * np.abs(axes @ thing.axes[2])
        pieces.append(LimitRows.of(cell, named, none, np.zeros(len(axes)), **terms, size=sizes))
    return stack_rows(pieces)


def _facets(thing: CarriedThing) -> tuple[Array, list[tuple[str, int]]]:
    """Directions d with d s <= 0 in object axes, Shape (k, 3), what each keeps from happening, and `RowName.sides`."""
    a, b, n = thing.axes
    directions, names = [], list[tuple[str, int]]()
    if thing.friction is not None:
        angle = (np.arange(NORM_SIDES) + 0.5) * (2 * np.pi / NORM_SIDES)
        within = thing.friction * np.cos(np.pi / NORM_SIDES)
        directions += [np.outer(np.cos(angle), a) + np.outer(np.sin(angle), b) - within * n]
        names += [(STANDING[0], NORM_SIDES)] * NORM_SIDES
    if thing.half_width is not None and thing.height is not None:
        for axis, width in zip((a, b), thing.half_width, strict=True):
            directions += [np.array([sign * axis - width / thing.height * n for sign in (1, -1)])]
        names += [(what, 0) for what in STANDING[1:]]
    return np.concatenate(directions), names


def norm_rows(cell: Cell, name: RowName, rate: Array, square: Array, limit: float) -> LimitRows:
    """|rate r̈ + square ṙ²| <= limit as the sides of a polygon inside that circle, all of one name.

    Corners lie along `square`, Shape (N, 3), and across it: with r̈ = 0, and on a straight line, the rows are exact.
    """
    first = _unit(np.where(np.linalg.norm(square, axis=1, keepdims=True) > 0, square, rate))
    second = _unit(rate - row_products(rate, first)[:, None] * first)
    across = second - row_products(second, first)[:, None] * first  # what rounding left of one direction is not across
    second = np.where(np.linalg.norm(across, axis=1, keepdims=True) > 0.5, _unit(across), 0.0)  # noqa: PLR2004 (0 or 1)
    angle = (np.arange(NORM_SIDES // 2) + 0.5) * (2 * np.pi / NORM_SIDES)
    sides = np.stack([np.cos(angle), np.sin(angle)]) / np.cos(np.pi / NORM_SIDES)
    columns = {
        key: np.stack([row_products(of, first), row_products(of, second)], axis=1) @ sides
        for key, of in (("rate", rate), ("square", square))
    }
    return LimitRows(limits=_circle_sides(cell, name, limit), **columns)


@lru_cache(maxsize=KNOWN_LIMITS)
def _circle_sides(cell: Cell, name: RowName, limit: float) -> RowLimits:
    most, names = np.full(NORM_SIDES // 2, limit), [replace(name, sides=NORM_SIDES)] * (NORM_SIDES // 2)
    return RowLimits.of(cell, names, -most, most, ("rate", "square"))


def _unit(vectors: Array) -> Array:
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    found: Array = np.divide(vectors, size, out=np.zeros_like(vectors), where=size > 0)
    return found


def _of_point(cell: Cell, owner: str, point: PointLimit, velocity: Array, acceleration: Array) -> list[LimitRows]:
    pieces, element = [], str(point.name)
    if point.speed is not None and cell.enforces_velocity_limits:
        names, limit = [RowName("velocity", owner, element, "m/s")], np.array([point.speed])
        speed = np.linalg.norm(velocity, axis=1, keepdims=True)
        pieces.append(LimitRows.of(cell, names, np.array([-np.inf]), limit, speed=speed))
    if point.acceleration is not None:
        name = RowName("acceleration", owner, element, "m/s²")
        pieces.append(norm_rows(cell, name, velocity, acceleration, point.acceleration))
    return pieces


def object_point(motion: CoordinatedMotion, point: Array) -> tuple[Array, Array]:
    """Velocity p' and acceleration p'' of a point of the object, given in its frame; world axes, each Shape (N, 3)."""
    r = motion.object.rotation @ point
    (velocity, turning), (acceleration, change) = (
        np.split(of, 2, axis=1) for of in (motion.object.twist, motion.object.acceleration)
    )
    around = cross(turning, r)
    return velocity + around, acceleration + cross(change, r) + cross(turning, around)


def arm_point(robot: Robot, point: ArmPointLimit, q: Array, dq: Array, ddq: Array) -> tuple[Array, Array]:
    """Velocity p' and acceleration p'' of a point of an arm, base axes, each Shape (N, 3); in numpy, for saved results.

    q, q' and q'' are those of the arm, each Shape (N, n).
    """
    place = np.broadcast_to(np.array(point.at_zero), (len(q), 3))
    velocity, acceleration = np.zeros((2, len(q), 3))
    for j in reversed(range(point.joints)):
        axis, (speed, change) = robot.axes[j], (of[:, j, None] for of in (dq, ddq))
        if robot.joint_types[j] == "prismatic":
            place = place + axis * q[:, j, None]
            velocity, acceleration = velocity + axis * speed, acceleration + axis * change
            continue
        R = rotations_from_vectors(axis * q[:, j, None])
        arm, velocity, acceleration = (
            np.einsum("nij,nj->ni", R, of) for of in (place - robot.points[j], velocity, acceleration)
        )
        along = np.broadcast_to(axis, arm.shape)
        around = cross(along, arm)
        turned = cross(along, around) * speed**2 + 2 * cross(along, velocity) * speed
        acceleration = acceleration + around * change + turned
        velocity, place = velocity + around * speed, robot.points[j] + arm
    return velocity, acceleration
