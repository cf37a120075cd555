# SPDX-License-Identifier: MIT
"""The registry of constraints. A new constraint is one file here and one line in `CONSTRAINTS`."""

from collections.abc import Callable

from mrts.cell import Cell
from mrts.constraints.torque_limits import torque_limits
from mrts.constraints.wrench_limits import wrench_limits
from mrts.limit_rows import LimitRows, stack_rows

CONSTRAINTS: dict[str, Callable[[Cell], LimitRows]] = {
    "torque_limits": torque_limits,
    "wrench_limits": wrench_limits,
}


def cell_rows(cell: Cell) -> LimitRows:
    """The rows of all constraints of a cell that have a limit on some side."""
    return stack_rows([constraint(cell) for constraint in CONSTRAINTS.values()]).bounded()
