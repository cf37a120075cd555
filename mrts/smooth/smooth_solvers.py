# SPDX-License-Identifier: MIT
"""The solvers of smooth timing, and the one that checks what they answer. A new one is one file and one line."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.smooth.program import Goal, SmoothProfile, SmoothProgram, SmoothSolver

KEPT = 1e-7
"""Excess over a limit that an answer may have, as a share of it: what Clarabel reaches, far below any tolerance."""

DEFAULT_SMOOTH_SOLVER = "conic"


def _conic() -> SmoothSolver:
    from mrts.smooth.conic import ConicSolver  # noqa: PLC0415 (scipy and Clarabel are not needed otherwise)

    return ConicSolver()


SMOOTH_SOLVERS: dict[str, Callable[[], SmoothSolver]] = {"conic": _conic}

FALLBACK = "conic"

Answer = TypeVar("Answer")


def check_smooth_solver(name: str) -> None:
    """Check a registered name.

    Raises:
        InputError: If there is no such solver.
    """
    if name not in SMOOTH_SOLVERS:
        raise InputError("solver", f"there is no such solver of smooth timing; there are {', '.join(SMOOTH_SOLVERS)}.",
                         value=name)  # fmt: skip


@dataclass
class CheckedSolver:
    """A solver whose answers keep all limits; where one does not, Clarabel is asked.

    Attributes:
        name: In `SMOOTH_SOLVERS`.
        fallbacks: Programs that Clarabel had to solve instead.
    """

    name: str = DEFAULT_SMOOTH_SOLVER
    fallbacks: int = 0
    _made: dict[str, SmoothSolver] = field(default_factory=dict)

    def step(self, program: SmoothProgram, around: Array, goal: Goal) -> SmoothProfile | None:
        """See `SmoothSolver.step`; what it returns keeps the limits of the program."""

        def kept(found: SmoothProfile) -> bool:
            return bool(np.all(found.x > 0)) and program.excess(found.x, found.u, found.free) <= KEPT

        return self._asked(lambda solver: solver.step(program, around, goal), kept)

    def torques(self, program: SmoothProgram, x: Array, u: Array) -> Array | None:
        """See `SmoothSolver.torques`; what it returns keeps the limits of the program."""
        return self._asked(
            lambda solver: solver.torques(program, x, u), lambda free: program.excess(x, u, free) <= KEPT
        )

    def _asked(self, ask: Callable[[SmoothSolver], Answer | None], kept: Callable[[Answer], bool]) -> Answer | None:
        for name in dict.fromkeys((self.name, FALLBACK)):
            if name not in self._made:
                self._made[name] = SMOOTH_SOLVERS[name]()
            found = ask(self._made[name])
            if found is not None and kept(found):
                self.fallbacks += name != self.name
                return found
        return None
