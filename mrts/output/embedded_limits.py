# SPDX-License-Identifier: MIT
"""The limits of a cell as an exported library carries them: tables of rows, and velocity limits."""

import numpy as np

from mrts.base.embedded_inputs import EmbeddedLimits
from mrts.base.errors import MrtsError
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits import LIMITS
from mrts.limits.rows import RowName, stack_rows
from mrts.motion.object_motion import ObjectMotion


def embedded_limits(cell: Cell) -> EmbeddedLimits:
    """All limits of the registry, those without a limit too: it may get one at run time.

    Args:
        cell: The cell; velocity limits that it does not enforce are unlimited.

    Raises:
        MrtsError: If a limit other than of velocities depends on the motion.
    """
    pieces = [limit(cell, _at_rest(cell)) for limit in LIMITS.values()]
    fixed = [piece for piece in pieces if not piece.depends_on_motion]
    for piece in pieces:
        if piece.depends_on_motion and any(name.kind != "velocity" for name in piece.names):
            raise MrtsError(
                f"{piece.names[0]}: this limit depends on the motion, which an exported library is given sample by "
                "sample; of such limits it has those of velocities only."
            )
    rows = stack_rows(fixed)
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


def _at_rest(cell: Cell) -> CoordinatedMotion:
    """A motion that stands still: which rows depend on the motion is the same for every motion."""
    q = np.tile(np.concatenate([robot.posture for robot in cell.robots]), (2, 1))
    none, there = np.zeros((2, 6)), np.tile(np.eye(3), (2, 1, 1))
    still = ObjectMotion(np.array([0.0, 1.0]), np.zeros((2, 3)), there, none, none, smooth=False)
    return CoordinatedMotion(still, q, np.zeros_like(q), np.zeros_like(q))


def _text(name: RowName) -> str:
    return f"{name.robot}/{name.element} {name.kind}" if name.robot else str(name)
