# SPDX-License-Identifier: MIT
"""The solvers of smooth timing, and the one that checks what they answer. A new one is one file and one line."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from mrts.base.argument_types import check_type
from mrts.base.arrays import Array
from mrts.base.errors import CompilerError, InputError
from mrts.smooth.program import Goal, NearSolver, SmoothProfile, SmoothProgram, SmoothSolver

KEPT = 1e-7
"""Excess over a limit that an answer may have, as a share of it: what Clarabel reaches, far below any tolerance."""

DEFAULT_SMOOTH_SOLVER = "kernel"


def _conic() -> SmoothSolver:
    from mrts.smooth.conic import ConicSolver  # noqa: PLC0415 (scipy and Clarabel are not needed otherwise)

    return ConicSolver()


def _kernel() -> SmoothSolver:
    """Our kernel; without a C compiler that works, Clarabel."""
    from mrts.smooth.kernel_solver import KernelSolver  # noqa: PLC0415 (a solver is imported when it is asked)

    try:
        return KernelSolver()
    except CompilerError:
        return _conic()


SMOOTH_SOLVERS: dict[str, Callable[[], SmoothSolver]] = {"kernel": _kernel, "conic": _conic}

FALLBACK = "conic"

Answer = TypeVar("Answer")


def check_smooth_solver(name: str) -> None:
    """Check a registered name.

    Raises:
        InputError: If there is no such solver.
    """
    check_type("solver", name, str)
    if name not in SMOOTH_SOLVERS:
        raise InputError("solver", f"there is no such solver of smooth timing; there are {', '.join(SMOOTH_SOLVERS)}.",
                         value=name)  # fmt: skip


@dataclass
class CheckedSolver:
    """A solver whose answers keep all limits; where one does not, Clarabel is asked.

    Attributes:
        name: In `SMOOTH_SOLVERS`.
        fallbacks: Programs that Clarabel had to solve instead.
        steps: Steps that were found.
    """

    name: str = DEFAULT_SMOOTH_SOLVER
    fallbacks: int = 0
    steps: int = 0
    _made: dict[str, SmoothSolver] = field(default_factory=dict)

    def step(self, program: SmoothProgram, around: Array, goal: Goal) -> SmoothProfile | None:
        """See `SmoothSolver.step`; what it returns keeps the limits of the program."""
        found = self._asked(lambda solver: solver.step(program, around, goal), lambda found: _kept(program, found))
        self.steps += found is not None
        return found

    def near(self, program: SmoothProgram, around: Array, goal: Goal) -> SmoothProfile | None:
        """See `NearSolver.near`; what it returns keeps the limits, and it is None where the solver cannot."""
        solver = self._solver(self.name)
        found = solver.near(program, around, goal) if isinstance(solver, NearSolver) else None
        if found is None or not _kept(program, found):
            return None
        self.steps += 1
        return found

    def torques(self, program: SmoothProgram, x: Array, u: Array) -> Array | None:
        """See `SmoothSolver.torques`; what it returns keeps the limits of the program that torques can keep."""
        rows = program.without_jerks()
        return self._asked(lambda solver: solver.torques(rows, x, u), lambda free: rows.excess(x, u, free) <= KEPT)

    def _asked(self, ask: Callable[[SmoothSolver], Answer | None], kept: Callable[[Answer], bool]) -> Answer | None:
        for name in dict.fromkeys((self.name, FALLBACK)):
            found = ask(self._solver(name))
            if found is not None and kept(found):
                self.fallbacks += name != self.name
                return found
        return None

    def _solver(self, name: str) -> SmoothSolver:
        if name not in self._made:
            self._made[name] = SMOOTH_SOLVERS[name]()
        return self._made[name]


def _kept(program: SmoothProgram, found: SmoothProfile) -> bool:
    """Whether a profile keeps all limits."""
    return bool(np.all(found.x > 0)) and program.excess(found.x, found.u, found.free) <= KEPT
