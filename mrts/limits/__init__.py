# SPDX-License-Identifier: MIT
"""Every limit as named rows. A new one is one file and one line in `LIMITS`.

May import base to coordination. Start at `rows.py`.
"""

from collections.abc import Callable
from dataclasses import replace

from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import LimitRows, stack_rows
from mrts.limits.torque_limits import torque_limits
from mrts.limits.velocity_limits import velocity_limits
from mrts.limits.wrench_limits import wrench_limits

LIMITS: dict[str, Callable[[Cell, CoordinatedMotion], LimitRows]] = {
    "torque_limits": torque_limits,
    "wrench_limits": wrench_limits,
    "velocity_limits": velocity_limits,
}


def limit_rows(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """The rows that the cell keeps along a motion: of all limits, those with a limit on some side.

    Args:
        cell: The cell; velocities are left out unless it enforces their limits.
        motion: Its motion.
    """
    return stack_rows([limit(cell, motion).bounded() for limit in LIMITS.values()])


def all_rows(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """The rows of all that can be limited along a motion, velocities enforced or not, with limits or without.

    Args:
        cell: The cell.
        motion: Its motion.
    """
    enforced = replace(cell, enforces_velocity_limits=True)
    return stack_rows([limit(enforced, motion) for limit in LIMITS.values()])
