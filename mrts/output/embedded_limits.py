# SPDX-License-Identifier: MIT
"""The limits of a cell as an exported library carries them: tables of rows, limits of the motion alone, motors."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mrts.base.embedded_inputs import EmbeddedLimits, EmbeddedMotions, EmbeddedMotors
from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.cell.points import PointLimit
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits import rows_by_limit
from mrts.limits.cell_limits import CurveRow, curve_rows, motor_limits, velocity_limits
from mrts.limits.motion_limits import STANDING, acceleration_limits, carried_limits, point_limits
from mrts.limits.rows import LimitRows, RowName, limit_name, stack_rows
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.rows_at_rest import REST

ON_THE_MOTION = (velocity_limits, acceleration_limits, point_limits, carried_limits)
"""Limits of the motion alone: a library computes what they bound."""


def embedded_limits(cell: Cell) -> EmbeddedLimits:
    """All limits of the cell, those without a limit too: it may get one at run time; and what motors add.

    Raises:
        InputError: If a limit of one's own depends on the motion: the library has tables for those that do not; or if
            the cell keeps a reserve.
    """
    if cell.reserve:
        rule = (
            "an exported library has the limits as they are given. Move its sides inward in its settings, at run time."
        )
        raise InputError("reserve", rule, value=cell.reserve)
    probes = _probe(cell, 1), _probe(cell, 2)
    first, second = (rows_by_limit(cell, probe) for probe in probes)
    pieces: list[LimitRows] = []
    line_rows = range(0)
    curves = curve_rows(cell)
    lines, ends = ([row for row in curves if (row.slope is None) is at_end] for at_end in (False, True))
    for (limit, given), (_, other) in zip(first, second, strict=True):
        if limit is motor_limits:
            before = sum(len(piece.names) for piece in pieces)
            line_rows = range(before, before + len(lines))
            pieces.append(given.only(np.array([row.slope is not None for row in curves], dtype=bool)))
        elif limit not in ON_THE_MOTION:
            _check_constant(limit_name(limit), given, other)
            pieces.append(given)
    rows = stack_rows(pieces)
    groups = list(dict.fromkeys(name.group for name in rows.names))
    velocity = velocity_limits(replace(cell, enforces_velocity_limits=True), probes[0])
    most = velocity.upper if cell.enforces_velocity_limits else np.full_like(velocity.upper, np.inf)
    return EmbeddedLimits(
        texts=tuple(_text(name) for name in rows.names),
        matrix=rows.matrix,
        base=None if rows.object_axes is None else rows.object_axes.base,
        axes=() if rows.object_axes is None else rows.object_axes.axes,
        lower=rows.lower,
        upper=rows.upper,
        group=tuple(groups.index(name.group) for name in rows.names),
        velocity_texts=tuple(_text(name) for name in (*velocity.names, *(row.name for row in ends))),
        velocity=np.concatenate([most, [row.limit for row in ends]]),
        motors=_motors(cell, lines, ends, line_rows),
        motions=_motions(cell) if cell.limits_motion else None,
    )


def _motions(cell: Cell) -> EmbeddedMotions:
    robots, things = cell.robots, cell.carried
    names = [RowName("acceleration", robot.name, joint) for robot in robots for joint in robot.joints]
    names += [RowName("acceleration", "object", part) for part in ("linear", "angular")]
    owners: list[tuple[str, PointLimit]] = [(robot.name, point) for robot in robots for point in robot.point_limits]
    owners += [("object", point) for point in cell.object_points]
    names += [RowName(kind, owner, str(point.name)) for owner, point in owners for kind in ("velocity", "acceleration")]
    names += [RowName("contact", "object", f"{thing.name} {what}") for thing in things for what in STANDING]
    limits = [[point.speed if cell.enforces_velocity_limits else None, point.acceleration] for _, point in owners]
    of_arms = [(cell.joint_slices[robot.name].start, point) for robot in robots for point in robot.point_limits]
    places = [point.at_zero for _, point in of_arms] + [point.point for point in cell.object_points]
    unlimited = [np.inf, np.inf]
    tilt = [np.divide(thing.half_width or unlimited, thing.centre_height or 1.0) for thing in things]
    return EmbeddedMotions(
        texts=tuple(map(_text, names)),
        acceleration=np.concatenate([[robot.acceleration_lower, robot.acceleration_upper] for robot in robots], axis=1),
        object_acceleration=cell.object_acceleration_limit,
        axes=np.concatenate([robot.axes for robot in robots]),
        axis_points=np.concatenate([robot.points for robot in robots]),
        slides=tuple(kind == "prismatic" for robot in robots for kind in robot.joint_types),
        point_joints=(*((first, point.joints) for first, point in of_arms), *((0, 0) for _ in cell.object_points)),
        points=np.array(places, dtype=np.float64).reshape(-1, 3),
        point_limits=np.array([[limit or np.inf for limit in both] for both in limits]).reshape(-1, 2),
        thing_axes=np.array([thing.axes for thing in things]).reshape(-1, 3, 3),
        thing_centres=np.array([thing.centre for thing in things]).reshape(-1, 3),
        friction=np.array([thing.friction or np.inf for thing in things]),
        tilt=np.array(tilt).reshape(-1, 2),
        gravity=cell.gravity,
    )


def _motors(
    cell: Cell, lines: Sequence[CurveRow], ends: Sequence[CurveRow], line_rows: Sequence[int]
) -> EmbeddedMotors | None:
    motors = [robot.motors for robot in cell.robots]
    if not (lines or ends or any(motor.has_effect for motor in motors)):
        return None
    return EmbeddedMotors(
        armature=np.concatenate([motor.armature for motor in motors]),
        coulomb=np.concatenate([motor.coulomb for motor in motors]),
        viscous=np.concatenate([motor.viscous for motor in motors]),
        line_rows=tuple(line_rows),
        line_joints=tuple(row.joint for row in lines),
        slope=np.array([row.slope for row in lines], dtype=np.float64),
        end_joints=tuple(row.joint for row in ends),
        rest=REST,
    )


def _probe(cell: Cell, seed: int) -> CoordinatedMotion:
    """Two samples in which everything moves; no arm needs to be able to do that."""
    rng = np.random.default_rng(seed)
    joints = len(cell.joint_names)
    q, dq, ddq = rng.normal(size=(3, 2, joints))
    position, twist, acceleration = rng.normal(size=(2, 3)), *rng.normal(size=(2, 2, 6))
    time, still = np.array([0.0, 1.0]), np.tile(np.eye(3), (2, 1, 1))
    return CoordinatedMotion(ObjectMotion(time, position, still, twist, acceleration, smooth=False), q, dq, ddq)


def _check_constant(limit: str, rows: LimitRows, again: LimitRows) -> None:
    of_speed = any(column is not None and np.any(column) for column in (rows.rate, rows.speed, rows.square))
    tables = [
        (each.torque_matrix, each.wrench_matrix, each.in_object_axes, each.lower, each.upper) for each in (rows, again)
    ]
    alike = rows.names == again.names and all(map(np.array_equal, *tables))
    if of_speed or not alike:
        raise InputError(
            f"limit '{limit}'",
            f"depends on the {'speed' if of_speed else 'motion'}, which an exported library cannot compute: it carries "
            "the limits of the cell file, and tables of limits that are constant in torques and wrenches. Export the "
            "cell without it (`Cell.with_limits`), and keep it by other means.",
        )


def _text(name: RowName) -> str:
    return f"{name.robot}/{name.element} {name.kind}" if name.robot and name.kind != "contact" else str(name)
