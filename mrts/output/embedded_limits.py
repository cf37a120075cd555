# SPDX-License-Identifier: MIT
"""The limits of a cell as an exported library carries them: tables of rows, and velocity limits."""

import numpy as np

from mrts.base.embedded_inputs import EmbeddedLimits
from mrts.cell.cell import Cell
from mrts.limits import CONSTRAINTS
from mrts.limits.rows import RowName, stack_rows


def embedded_limits(cell: Cell) -> EmbeddedLimits:
    """All limits of the registry, those without a limit too: it may get one at run time.

    Args:
        cell: The cell; velocity limits that it does not enforce are unlimited.
    """
    rows = stack_rows([constraint(cell) for constraint in CONSTRAINTS.values()])
    units = list(dict.fromkeys(name.unit for name in rows.names))
    velocity = np.concatenate([*(robot.velocity_limit for robot in cell.robots), cell.object_velocity_limit])
    joints = [RowName("velocity", robot.name, joint) for robot in cell.robots for joint in robot.joints]
    parts = [RowName("velocity", "object", part) for part in ("linear", "angular")]
    return EmbeddedLimits(
        tuple(_text(name) for name in rows.names),
        np.hstack([rows.torque_matrix, rows.wrench_matrix]),
        rows.lower,
        rows.upper,
        tuple(units.index(name.unit) for name in rows.names),
        tuple(_text(name) for name in (*joints, *parts)),
        velocity if cell.enforces_velocity_limits else np.full_like(velocity, np.inf),
    )


def _text(name: RowName) -> str:
    return f"{name.robot}/{name.element} {name.kind}" if name.robot else str(name)
