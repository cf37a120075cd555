# SPDX-License-Identifier: MIT
"""The limits of a cell as an exported library carries them: tables of rows, and velocity limits."""

from dataclasses import replace

import numpy as np

from mrts.base.embedded_inputs import EmbeddedLimits
from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits import LIMITS, rows_by_limit
from mrts.limits.rows import LimitRows, RowName, stack_rows
from mrts.limits.velocity_limits import velocity_limits
from mrts.motion.object_motion import ObjectMotion


def embedded_limits(cell: Cell) -> EmbeddedLimits:
    """All limits of the registry, those without a limit too: it may get one at run time.

    Args:
        cell: The cell; velocity limits that it does not enforce are unlimited.

    Raises:
        InputError: If a limit, velocities aside, depends on the motion: the library has tables for those that do not.
    """
    for robot in cell.robots:
        if robot.motors.has_effect:
            raise InputError(f"robot '{robot.name}'", "motors cannot be exported yet.", key="motors")
    probes = _probe(cell, 1), _probe(cell, 2)
    first, second = (rows_by_limit(cell, probe) for probe in probes)
    pieces = []
    for name, limit in LIMITS.items():
        if limit is not velocity_limits:
            _check_constant(name, first[name], second[name])
            pieces.append(first[name])
    rows = stack_rows(pieces)
    units = list(dict.fromkeys(name.unit for name in rows.names))
    velocity = velocity_limits(replace(cell, enforces_velocity_limits=True), probes[0])
    enforced = cell.enforces_velocity_limits and velocity_limits in LIMITS.values()
    return EmbeddedLimits(
        texts=tuple(_text(name) for name in rows.names),
        matrix=np.hstack([rows.torque_matrix, rows.wrench_matrix]),
        lower=rows.lower,
        upper=rows.upper,
        group=tuple(units.index(name.unit) for name in rows.names),
        velocity_texts=tuple(_text(name) for name in velocity.names),
        velocity=velocity.upper if enforced else np.full_like(velocity.upper, np.inf),
    )


def _probe(cell: Cell, seed: int) -> CoordinatedMotion:
    """Two samples in which everything moves; no arm needs to be able to do that."""
    rng = np.random.default_rng(seed)
    joints = sum(len(robot.joints) for robot in cell.robots)
    q, dq, ddq = rng.normal(size=(3, 2, joints))
    position, twist, acceleration = rng.normal(size=(2, 3)), *rng.normal(size=(2, 2, 6))
    time, still = np.array([0.0, 1.0]), np.tile(np.eye(3), (2, 1, 1))
    return CoordinatedMotion(ObjectMotion(time, position, still, twist, acceleration, smooth=False), q, dq, ddq)


def _check_constant(limit: str, rows: LimitRows, again: LimitRows) -> None:
    """Refuse a limit of which a library cannot compute the rows at a sample."""
    of_speed = any(column is not None and np.any(column) for column in (rows.rate, rows.speed, rows.square))
    tables = [(each.torque_matrix, each.wrench_matrix, each.lower, each.upper) for each in (rows, again)]
    alike = rows.names == again.names and all(map(np.array_equal, *tables))
    if of_speed or not alike:
        raise InputError(
            f"limit '{limit}'",
            f"depends on the {'speed' if of_speed else 'motion'}, which an exported library cannot compute: it carries "
            "velocity limits, and tables of limits that are constant in torques and wrenches. Take the limit out of "
            "mrts.limits.LIMITS for the export, and keep it by other means.",
        )


def _text(name: RowName) -> str:
    return f"{name.robot}/{name.element} {name.kind}" if name.robot else str(name)
