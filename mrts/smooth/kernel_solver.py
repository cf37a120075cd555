# SPDX-License-Identifier: MIT
"""Our own interior point for the programs of smooth timing; see mrts/kernel/c/smooth/interior_point.h."""

import numpy as np

from mrts.base.arrays import Array
from mrts.kernel.smooth_programs import PathRows, path_rows, smooth_programs
from mrts.smooth.program import Goal, SmoothProfile, SmoothProgram

import os
MOVING=0
NOWARM=os.environ.get('NOWARM')

class KernelSolver:
    """A primal-dual interior point whose Newton steps are solved node by node.

    Attributes:
        iterations: How many the last program took.

    Raises:
        CompilerError: If there is no C compiler, or it fails.
    """

    def __init__(self) -> None:
        self._programs = smooth_programs()
        self._last: tuple[SmoothProgram, PathRows] | None = None
        self.iterations = 0

    def step(self, program: SmoothProgram, around: Array, goal: Goal) -> SmoothProfile | None:
        """See `SmoothSolver.step`."""
        start, end = program.ends
        touched = np.array(around, dtype=np.float64)
        x, u, free = touched.copy(), np.zeros(program.nodes), self._free(program)
        for place, given in zip((0, -1), program.ends, strict=True):
            x[place] = touched[place] if given is None else given
        longest = np.inf if goal.longest is None else goal.longest
        w = getattr(self,'_warm',None)
        again = w is not None and w[0] is program and np.array_equal(w[1], touched) and not NOWARM
        found, self.iterations = self._programs.solve(
            self._rows(program), touched, x, u, free, time=goal.time, effort=goal.effort, longest=longest,
            given_start=start is not None, given_end=end is not None, **_held(program), again=again, moving=MOVING, work=w[2] if again else None
        )  # fmt: skip
        self._warm = (program, x, self._programs.last_work) if found else None
        return SmoothProfile(x, u, free) if found else None

    def torques(self, program: SmoothProgram, x: Array, u: Array) -> Array | None:
        """See `SmoothSolver.torques`."""
        free = self._free(program)
        if free.shape[1] == 0:
            return free
        timed = [np.array(of, dtype=np.float64) for of in (x, u)]
        found, self.iterations = self._programs.solve(
            self._rows(program), timed[0], *timed, free, timed=1, time=0.0, effort=1.0, **_held(program)
        )
        return free if found else None

    def _rows(self, program: SmoothProgram) -> PathRows:
        """Arrays of a program, kept for the next step on it."""
        if self._last is None or self._last[0] is not program:
            names = ("step", "square", "rate", "root", "offset", "lower", "upper", "change", "weight")
            arrays = {name: getattr(program, name) for name in (*names, "q1", "q2", "q3", "jerk")}
            self._last = program, path_rows(program.free, program.columns, **arrays)
        return self._last[1]

    @staticmethod
    def _free(program: SmoothProgram) -> Array:
        """F that is given at the ends, else 0, Shape (n, f)."""
        free = np.zeros((program.nodes, program.free.shape[2]))
        for place, given in zip((0, -1), program.end_free, strict=True):
            if given is not None:
                free[place] = given
        return free


def _held(program: SmoothProgram) -> dict[str, int]:
    start, end = program.end_free
    return {"held_start": start is not None, "held_end": end is not None}
