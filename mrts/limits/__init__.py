# SPDX-License-Identifier: MIT
"""Every limit as named rows. A new one is a function, given to the cell.

May import base to diagnosis. Start at `rows.py`.
"""

from collections.abc import Callable
from dataclasses import replace

from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.contact_limits import contact_limits
from mrts.limits.motor_limits import motor_limits
from mrts.limits.row_check import checked_rows
from mrts.limits.rows import LimitRows, stack_rows
from mrts.limits.squared_rows import SquaredRows, squared
from mrts.limits.torque_limits import torque_limits
from mrts.limits.velocity_limits import velocity_limits
from mrts.limits.wrench_limits import wrench_limits

Limit = Callable[[Cell, CoordinatedMotion], LimitRows]

CELL_LIMITS: tuple[Limit, ...] = (torque_limits, wrench_limits, contact_limits, velocity_limits, motor_limits)
"""Those of the cell file; `Cell.limits` are there beside them."""


def rows_by_limit(cell: Cell, motion: CoordinatedMotion) -> dict[Limit, LimitRows]:
    """The rows of each limit of a cell.

    Args:
        cell: The cell.
        motion: Its motion.

    Raises:
        InputError: If a limit that the cell was given gives no rows of this cell along this motion; it names the limit.
    """
    rows = {limit: limit(cell, motion) for limit in CELL_LIMITS}
    return rows | {limit: checked_rows(limit, cell, motion) for limit in cell.limits}


def limit_rows(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """The rows that the cell keeps along a motion: of all limits, those with a limit on some side.

    Args:
        cell: The cell; velocities are left out unless it enforces their limits. Its reserve is taken off all limits.
        motion: Its motion.

    Raises:
        InputError: As `rows_by_limit`.
    """
    rows = stack_rows([piece.bounded() for piece in rows_by_limit(cell, motion).values()])
    return rows.shrunk(cell.reserve) if cell.reserve else rows


def squared_limits(cell: Cell, motion: CoordinatedMotion) -> SquaredRows:
    """`limit_rows` as the programs take them.

    Args:
        cell: The cell.
        motion: Its motion.

    Raises:
        InputError: As `rows_by_limit`.
    """
    return squared(limit_rows(cell, motion))


def all_rows(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """The rows of all that can be limited along a motion, velocities enforced or not, with limits or without.

    Args:
        cell: The cell.
        motion: Its motion.
    """
    enforced = replace(cell, enforces_velocity_limits=True)
    return stack_rows(list(rows_by_limit(enforced, motion).values()))
