# SPDX-License-Identifier: MIT
"""Every limit as named rows. A new one is one file and one line in `CONSTRAINTS`.

May import base to coordination. Start at `rows.py`.
"""

from collections.abc import Callable

from mrts.cell.cell import Cell
from mrts.limits.rows import LimitRows, stack_rows
from mrts.limits.torque_limits import torque_limits
from mrts.limits.wrench_limits import wrench_limits

CONSTRAINTS: dict[str, Callable[[Cell], LimitRows]] = {
    "torque_limits": torque_limits,
    "wrench_limits": wrench_limits,
}


def cell_rows(cell: Cell) -> LimitRows:
    """The rows of all constraints of a cell that have a limit on some side."""
    return stack_rows([constraint(cell) for constraint in CONSTRAINTS.values()]).bounded()
