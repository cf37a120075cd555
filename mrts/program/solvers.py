# SPDX-License-Identifier: MIT
"""Verified batches of linear and quadratic programs. A new solver is one file and one line in `SOLVERS`."""

from collections.abc import Callable, Iterator
from typing import Protocol

from mrts.base.argument_types import check_type
from mrts.base.arrays import Array
from mrts.base.errors import InputError

DEFAULT_SOLVER = "kernel"


class BatchSolver(Protocol):
    """Solves a batch of programs of equal size; see `mrts.program.convex_program.ConvexPrograms` for the shapes."""

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


def _kernel() -> BatchSolver:
    from mrts.program.kernel_solver import KernelSolver  # noqa: PLC0415 (a solver is imported when it is asked)

    return KernelSolver()


def _qpoases() -> BatchSolver:
    from mrts.program.qpsol import QpsolSolver  # noqa: PLC0415 (CasADi is not needed otherwise)

    return QpsolSolver("qpoases")


def _daqp() -> BatchSolver:
    from mrts.program.qpsol import QpsolSolver  # noqa: PLC0415 (likewise)

    return QpsolSolver("daqp")


def _scipy_highs() -> BatchSolver:
    from mrts.program.scipy_highs import ScipyHighsSolver  # noqa: PLC0415 (nor is scipy.optimize)

    return ScipyHighsSolver()


SOLVERS: dict[str, Callable[[], BatchSolver]] = {
    "kernel": _kernel,
    "qpsol:qpoases": _qpoases,
    "scipy:highs": _scipy_highs,
}

FALLBACKS = ("scipy:highs", "qpsol:qpoases")
"""Asked in this order for what the chosen solver does not get right; between them they solve both kinds. Last of all
DAQP is asked, no choice by itself, for the quadratic programs that qpOASES leaves."""


def with_fallbacks(name: str) -> Iterator[BatchSolver]:
    """A solver by its registered name, and the others to ask where it fails, each made when its turn comes.

    Raises:
        InputError: If there is no such solver.
    """
    check_solver(name)
    asked = (SOLVERS[each] for each in (name, *(other for other in FALLBACKS if other != name)))
    return (make() for make in (*asked, _daqp))


def check_solver(name: str) -> None:
    """Check a registered name.

    Raises:
        InputError: If there is no such solver.
    """
    check_type("solver", name, str)
    if name not in SOLVERS:
        raise InputError("solver", f"there is no such solver; there are {', '.join(SOLVERS)}.", value=name)
