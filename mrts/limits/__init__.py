# SPDX-License-Identifier: MIT
"""Every limit as named rows. A new one is a function, given to the cell.

May import base to following. Start at `cell_limits.py`.
"""

from collections.abc import Callable
from dataclasses import replace

from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits import cell_limits as of_cell
from mrts.limits import motion_limits as of_motion
from mrts.limits.rows import LimitRows, checked_rows, stack_rows

Limit = Callable[[Cell, CoordinatedMotion], LimitRows]
"""The rows of a limit along a motion; one of your own: docs/extending.md."""

CELL_LIMITS: tuple[Callable[[Cell, CoordinatedMotion], LimitRows | None], ...] = (
    *(of_cell.torque_limits, of_cell.wrench_limits),
    *(of_cell.contact_limits, of_cell.velocity_limits, of_cell.motor_limits),
    *(of_motion.acceleration_limits, of_motion.point_limits, of_motion.carried_limits),
)
"""Those of the cell file, None where it gives none; `Cell.limits` are there beside them."""


def rows_by_limit(cell: Cell, motion: CoordinatedMotion) -> list[tuple[Callable[..., object], LimitRows]]:
    """The rows of each limit that a cell has.

    Raises:
        InputError: If a limit that the cell was given gives no rows of this cell along this motion; it names the limit.
    """
    found: list[tuple[Callable[..., object], LimitRows]] = []
    for limit in (*CELL_LIMITS, *cell.limits):
        rows = checked_rows(limit, cell, motion) if limit in cell.limits else limit(cell, motion)
        if rows is not None:
            found.append((limit, rows))
    return found


def limit_rows(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """The rows that the cell keeps along a motion: those with a limit on some side, less its reserve.

    Velocities are left out unless it enforces their limits.

    Raises:
        InputError: As `rows_by_limit`.
    """
    rows = stack_rows([rows.bounded for _, rows in rows_by_limit(cell, motion)], known=not cell.limits)
    return replace(rows, limits=rows.limits.shrunk(cell.reserve)) if cell.reserve else rows


def all_rows(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """The rows of all that can be limited along a motion, velocities enforced or not, with limits or without."""
    enforced = replace(cell, enforces_velocity_limits=True)
    _, pieces = zip(*rows_by_limit(enforced, motion), strict=True)
    return stack_rows(pieces)
