# SPDX-License-Identifier: MIT
"""The registry of solvers. A new solver is one file here and one line in `SOLVERS`."""

from collections.abc import Callable
from typing import Protocol

from mrts.errors import InputError
from mrts.rigid_transform import Array
from mrts.solvers.qpsol import QpsolSolver
from mrts.solvers.scipy_highs import ScipyHighsSolver

DEFAULT_SOLVER = "qpsol:qpoases"


class BatchSolver(Protocol):
    """Solves a batch of programs of equal size; see `mrts.convex_program.ConvexPrograms` for the shapes."""

    def solve(
        self,
        H: Array | None,
        g: Array,
        A: Array,
        lower: Array,
        upper: Array,
        x_lower: Array,
        x_upper: Array,
    ) -> tuple[Array, Array, Array]:
        """Minimisers, row multipliers and bound multipliers; anything at all where it fails, never an exception."""


SOLVERS: dict[str, Callable[[], BatchSolver]] = {
    "qpsol:qpoases": lambda: QpsolSolver("qpoases"),
    "qpsol:highs": lambda: QpsolSolver("highs"),
    "qpsol:daqp": lambda: QpsolSolver("daqp"),
    "scipy:highs": ScipyHighsSolver,
}

FALLBACKS = ("qpsol:qpoases", "scipy:highs", "qpsol:daqp")
"""Asked in this order for what the chosen solver does not get right; between them they solve both kinds."""


def with_fallbacks(name: str) -> list[BatchSolver]:
    """A solver by its registered name, and the others to ask where it fails.

    Raises:
        InputError: If there is no such solver.
    """
    if name not in SOLVERS:
        raise InputError("solver", f"there is no such solver; there are {', '.join(SOLVERS)}.", value=name)
    return [SOLVERS[name](), *(SOLVERS[other]() for other in FALLBACKS if other != name)]
