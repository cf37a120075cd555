# SPDX-License-Identifier: MIT
"""Limits of the motion alone, whatever carries it: accelerations, points of arms and object, things on the object."""

import numpy as np

from mrts.base.arrays import Array, cross, row_products
from mrts.cell.cell import Cell
from mrts.cell.points import ArmPointLimit, CarriedThing, PointLimit
from mrts.cell.robot import Robot
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.arm_points import arm_point
from mrts.limits.rows import LimitRows, RowName, row_names, stack_rows

NORM_SIDES = 224
"""Sides of the polygon that stands for a circle: inside it, by at most 1 - cos(π / 224) < 1e-4 of the radius."""

STANDING = ("friction", "tilt +a", "tilt -a", "tilt +b", "tilt -b")
"""What keeps a thing on the object where it stands."""

NONE = np.zeros(0)


def limits_motion(cell: Cell) -> bool:
    """Whether a cell has limits of the motion alone, its velocity limits apart."""
    arms = [(robot.acceleration_lower, robot.acceleration_upper) for robot in cell.robots]
    limits = np.concatenate([*(side for sides in arms for side in sides), cell.object_acceleration_limit])
    points = any(robot.point_limits for robot in cell.robots) or cell.object_points
    return bool(np.isfinite(limits).any() or points or cell.carried)


def acceleration_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """a⁻ <= q' r̈ + q'' ṙ² <= a⁺, one row a joint, and the sizes of the object's acceleration."""
    limits = [(robot.acceleration_lower, robot.acceleration_upper) for robot in cell.robots]
    lower, upper = (np.concatenate(sides) for sides in zip(*limits, strict=True))
    if np.isinf(lower).all() and np.isinf(upper).all() and np.isinf(cell.object_acceleration_limit).all():
        return LimitRows.of(cell, names=(), lower=NONE, upper=NONE)
    names = tuple[RowName, ...]()
    for robot in cell.robots:
        units = tuple(f"{unit}/s²" for unit in robot.position_units)
        names += row_names("acceleration", robot.name, robot.joints, units)
    joints = LimitRows.of(cell, names=names, lower=lower, upper=upper, rate=motion.dq, square=motion.ddq).bounded()
    names = row_names("acceleration", "object", ("linear", "angular"), ("m/s²", "rad/s²"))
    rates, given = motion.object.twist.reshape(-1, 2, 3), motion.object.acceleration.reshape(-1, 2, 3)
    norms = [
        norm_rows(cell, name, rates[:, part], given[:, part], limit)
        for part, (name, limit) in enumerate(zip(names, cell.object_acceleration_limit.tolist(), strict=True))
        if np.isfinite(limit)
    ]
    return stack_rows([joints, *norms])


def point_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """Speed |p'| ṙ and acceleration |p' r̈ + p'' ṙ²| of points of arms and object."""
    pieces = [LimitRows.of(cell, names=(), lower=NONE, upper=NONE)]
    for robot in cell.robots:
        for point in robot.point_limits:
            pieces += _of_point(cell, robot.name, point, *_arm_point(cell, robot, point, motion))
    for own in cell.object_points:
        pieces += _of_point(cell, "object", own, *object_point(motion, np.array(own.point)))
    return stack_rows(pieces)


def carried_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """Things that stand loose on the object neither slide nor tip.

    What one takes from the object, per mass, is s = Rᵀ (p' r̈ + p'' ṙ² - gravity) at its centre of mass. In its own axes
    a, b, n: |(s_a, s_b)| <= friction × s_n, and |s_a| height <= half width × s_n, likewise along b.
    """
    size = max(float(np.linalg.norm(cell.gravity)), 1.0)
    pieces = [LimitRows.of(cell, names=(), lower=NONE, upper=NONE)]
    for thing in cell.carried:
        axes, names = _facets(thing)
        turn = axes @ motion.object.rotation.transpose(0, 2, 1)
        rate, square = (np.einsum("nkj,nj->nk", turn, of) for of in object_point(motion, thing.centre))
        pieces.append(
            LimitRows.of(
                cell,
                names=[RowName("contact", "object", f"{thing.name} {what}", "m/s²") for what in names],
                lower=np.full(len(axes), -np.inf),
                upper=np.zeros(len(axes)),
                rate=rate,
                square=square,
                offset=-turn @ cell.gravity,
                size=size * np.abs(axes @ thing.axes[2]),
            )
        )
    return stack_rows(pieces)


def _facets(thing: CarriedThing) -> tuple[Array, list[str]]:
    """Directions d with d s <= 0 in object axes, Shape (k, 3), and what each keeps from happening."""
    a, b, n = thing.axes
    directions, names = [], []
    if thing.friction is not None:
        angle = (np.arange(NORM_SIDES) + 0.5) * (2 * np.pi / NORM_SIDES)
        within = thing.friction * np.cos(np.pi / NORM_SIDES)
        directions += [np.outer(np.cos(angle), a) + np.outer(np.sin(angle), b) - within * n]
        names += [STANDING[0]] * NORM_SIDES
    if thing.half_width is not None:
        for axis, width in zip((a, b), thing.half_width, strict=True):
            directions += [np.array([sign * axis - width / thing.centre_height * n for sign in (1, -1)])]
        names += STANDING[1:]
    return np.concatenate(directions), names


def norm_rows(cell: Cell, name: RowName, rate: Array, square: Array, limit: float) -> LimitRows:
    """|rate r̈ + square ṙ²| <= limit as the sides of a polygon inside that circle, all of one name.

    Corners lie along `square` and across it: with r̈ = 0, and on a straight line, the rows are exact.

    Args:
        cell: The cell.
        name: Of each row.
        rate: Shape (N, 3).
        square: Shape (N, 3).
        limit: > 0.
    """
    first = _unit(np.where(np.linalg.norm(square, axis=1, keepdims=True) > 0, square, rate))
    second = rate
    for _ in range(2):  # twice is enough, where the two are almost one direction
        second = _unit(second - row_products(second, first)[:, None] * first)
    angle = (np.arange(NORM_SIDES // 2) + 0.5) * (2 * np.pi / NORM_SIDES)
    across = np.stack([np.cos(angle), np.sin(angle)]) / np.cos(np.pi / NORM_SIDES)
    columns = {
        key: np.stack([row_products(of, first), row_products(of, second)], axis=1) @ across
        for key, of in (("rate", rate), ("square", square))
    }
    sides = np.full(len(angle), limit)
    return LimitRows.of(cell, names=[name] * len(angle), lower=-sides, upper=sides, **columns)


def _unit(vectors: Array) -> Array:
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    found: Array = np.divide(vectors, size, out=np.zeros_like(vectors), where=size > 0)
    return found


def _of_point(cell: Cell, owner: str, point: PointLimit, velocity: Array, acceleration: Array) -> list[LimitRows]:
    pieces, element = [], str(point.name)
    if point.speed is not None and cell.enforces_velocity_limits:
        pieces.append(
            LimitRows.of(
                cell,
                names=[RowName("velocity", owner, element, "m/s")],
                lower=np.array([-np.inf]),
                upper=np.array([point.speed]),
                speed=np.linalg.norm(velocity, axis=1, keepdims=True),
            )
        )
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


def _arm_point(cell: Cell, robot: Robot, point: ArmPointLimit, motion: CoordinatedMotion) -> tuple[Array, Array]:
    """Velocity p' and acceleration p'' of a point of an arm, base axes, each Shape (N, 3)."""
    first = cell.joint_slices[robot.name].start
    moving = slice(first, first + point.joints)
    return arm_point(
        cell.library,
        axes=robot.axes[: point.joints],
        points=robot.points[: point.joints],
        slides=[kind == "prismatic" for kind in robot.joint_types[: point.joints]],
        at_zero=np.array(point.at_zero),
        rates=[of[:, moving] for of in (motion.q, motion.dq, motion.ddq)],
    )
