# SPDX-License-Identifier: MIT
"""Every limit as named rows. A new one is one file and one line in `LIMITS`.

May import base to diagnosis. Start at `rows.py`.
"""

from collections.abc import Callable
from dataclasses import replace
from weakref import WeakKeyDictionary

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

LIMITS: dict[str, Callable[[Cell, CoordinatedMotion], LimitRows]] = {
    "torque_limits": torque_limits,
    "wrench_limits": wrench_limits,
    "contact_limits": contact_limits,
    "velocity_limits": velocity_limits,
    "motor_limits": motor_limits,
}

OWN_LIMITS = tuple(LIMITS)
"""Names of the limits that mrts comes with."""

_Limit = Callable[[Cell, CoordinatedMotion], LimitRows]
_OWN: tuple[_Limit, ...] = tuple(LIMITS.values())
_OF_CELL: WeakKeyDictionary[Cell, dict[_Limit, LimitRows]] = WeakKeyDictionary()
_Registered = tuple[_Limit, ...]
_OF_ANY_MOTION: WeakKeyDictionary[Cell, tuple[_Registered, SquaredRows]] = WeakKeyDictionary()
_SQUARED: WeakKeyDictionary[CoordinatedMotion, WeakKeyDictionary[Cell, tuple[_Registered, SquaredRows]]] = (
    WeakKeyDictionary()
)


def squared_limits(cell: Cell, motion: CoordinatedMotion) -> SquaredRows:
    """`limit_rows` as the programs take them, put together once for a cell and a motion and kept while both live.

    Args:
        cell: The cell.
        motion: Its motion.

    Raises:
        InputError: If a limit gives rows that do not fit the cell or the motion.
    """
    of_motion = _SQUARED.setdefault(motion, WeakKeyDictionary())
    registered, known = tuple(LIMITS.values()), of_motion.get(cell)
    if known is None or known[0] != registered:
        known = of_motion[cell] = registered, _squared(cell, motion, registered)
    return known[1]


def _squared(cell: Cell, motion: CoordinatedMotion, registered: _Registered) -> SquaredRows:
    """`squared_limits`, put together once for a cell whose rows are the same along every motion."""
    pieces, of_cell = _pieces(cell, motion), _OF_CELL[cell]
    if not all(limit in of_cell for limit in registered):
        return squared(_stacked(cell, pieces))
    known = _OF_ANY_MOTION.get(cell)
    if known is None or known[0] != registered:
        known = _OF_ANY_MOTION[cell] = registered, squared(_stacked(cell, pieces))
    return known[1]


def rows_by_limit(cell: Cell, motion: CoordinatedMotion) -> dict[str, LimitRows]:
    """The rows of each limit of the registry, checked.

    Args:
        cell: The cell.
        motion: Its motion.

    Raises:
        InputError: If a limit gives no rows of this cell along this motion; it names the limit.
    """
    return {name: checked_rows(name, limit(cell, motion), cell, motion) for name, limit in LIMITS.items()}


def limit_rows(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """The rows that the cell keeps along a motion: of all limits, those with a limit on some side.

    Args:
        cell: The cell; velocities are left out unless it enforces their limits. Its reserve is taken off all limits.
        motion: Its motion.
    """
    return _stacked(cell, _pieces(cell, motion))


def _pieces(cell: Cell, motion: CoordinatedMotion) -> list[LimitRows]:
    """The rows of each limit that have a limit on some side.

    Those of our own limits are put together once for a cell, where they are the same along every motion.
    """
    of_cell = _OF_CELL.setdefault(cell, {})
    pieces = []
    for name, limit in LIMITS.items():
        rows = of_cell.get(limit)
        if rows is None:
            given = checked_rows(name, limit(cell, motion), cell, motion)
            rows = given.bounded()
            # along a motion that stands still the rows that are kept may have nothing of it
            if not given.along_motion and any(limit is one for one in _OWN):
                of_cell[limit] = rows
        pieces.append(rows)
    return pieces


def _stacked(cell: Cell, pieces: list[LimitRows]) -> LimitRows:
    rows = stack_rows(pieces)
    return rows.shrunk(cell.reserve) if cell.reserve else rows


def all_rows(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """The rows of all that can be limited along a motion, velocities enforced or not, with limits or without.

    Args:
        cell: The cell.
        motion: Its motion.
    """
    enforced = replace(cell, enforces_velocity_limits=True)
    return stack_rows(list(rows_by_limit(enforced, motion).values()))
