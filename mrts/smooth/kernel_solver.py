# SPDX-License-Identifier: MIT
"""Our own interior point for the programs of smooth timing; see mrts/kernel/c/smooth/interior_point.h."""

from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.kernel.smooth_programs import Ask, PathRows, path_rows, smooth_programs
from mrts.smooth.program import Goal, SmoothProfile, SmoothProgram

NEAR = 0.1
"""Share by which a step may have moved any x for the next one to start from its iterates: tangents change as much."""


EFFORTS = 1e8
"""Weight of the share by which limits of rates are passed against the effort of a profile at its start."""

DURATIONS = 100.0
"""Likewise against its duration."""


@dataclass(frozen=True)
class _Answer:
    """An answer that a next step may start from."""

    program: SmoothProgram
    goal: Goal
    x: Array
    work: Array


@dataclass(frozen=True)
class _Start:
    """Where a program starts, and where its answer goes: tangents, x, u and F."""

    around: Array
    x: Array
    u: Array
    free: Array


class KernelSolver:
    """A primal-dual interior point whose Newton steps are solved node by node.

    Attributes:
        iterations: How many the last program took.

    Raises:
        CompilerError: If there is no C compiler, or it fails.
    """

    def __init__(self) -> None:
        self._programs = smooth_programs()
        self._rows: tuple[SmoothProgram, PathRows] | None = None
        self._last: _Answer | None = None
        self.iterations = 0

    def step(self, program: SmoothProgram, around: Array, goal: Goal) -> SmoothProfile | None:
        """See `SmoothSolver.step`."""
        return self._step(program, around, goal, moving=False)

    def near(self, program: SmoothProgram, around: Array, goal: Goal) -> SmoothProfile | None:
        """See `NearSolver.near`: the tangents follow the iterates."""
        return self._step(program, around, goal, moving=True)

    def torques(self, program: SmoothProgram, x: Array, u: Array) -> Array | None:
        """See `SmoothSolver.torques`."""
        free = _free(program)
        if free.shape[1] == 0:
            return free
        timed = [np.array(of, dtype=np.float64) for of in (x, u)]
        ask = Ask(around=timed[0].copy(), effort=1.0, timed=True, held=_given(program.end_free))
        for relaxed in (0.0, EFFORTS):  # where limits leave hardly any room, multipliers of relaxed ones stay finite
            given = free.copy()
            solved = self._programs.solve(
                self._packed(program), replace(ask, relaxed=relaxed), timed[0], timed[1], given
            )
            self.iterations = solved.iterations
            if solved.found:
                return given
        return None

    def nearest(self, program: SmoothProgram, around: Array) -> tuple[SmoothProfile, float] | None:
        """The profile whose rates pass their limits least, the duration weighed little; all else is as in `step`.

        Args:
            program: The program.
            around: x > 0 where tangents are laid, Shape (n,).

        Returns:
            It and by what share; None where the other limits cannot be kept.
        """
        start = self._start(program, around)
        ask = replace(self._ask(program, start.around, Goal()), relaxed=DURATIONS)
        solved = self._programs.solve(self._packed(program), ask, start.x, start.u, start.free)
        self.iterations = solved.iterations
        return (SmoothProfile(start.x, start.u, start.free), solved.share) if solved.found else None

    def _step(self, program: SmoothProgram, around: Array, goal: Goal, *, moving: bool) -> SmoothProfile | None:
        last, self._last = self._last, None
        known = last and last.program is program and last.goal == goal.evened(0.0) and np.array_equal(last.x, around)
        for work in (last.work, None) if last and known else (None,):  # the start far from the limits is the safer one
            start = self._start(program, around)
            ask = replace(self._ask(program, start.around, goal), moving=moving, last=work)
            solved = self._programs.solve(self._packed(program), ask, start.x, start.u, start.free)
            self.iterations = solved.iterations
            if not solved.found:
                continue
            if moving or np.max(np.abs(start.x / start.around - 1)) <= NEAR:
                self._last = _Answer(program, goal.evened(0.0), start.x.copy(), solved.work)
            return SmoothProfile(start.x, start.u, start.free)
        return None

    @staticmethod
    def _start(program: SmoothProgram, around: Array) -> "_Start":
        touched = np.array(around, dtype=np.float64)
        x = touched.copy()
        for place, given in zip((0, -1), program.ends, strict=True):
            x[place] = touched[place] if given is None else given
        return _Start(touched, x, np.zeros(program.nodes), _free(program))

    @staticmethod
    def _ask(program: SmoothProgram, around: Array, goal: Goal) -> Ask:
        return Ask(
            around=around, time=goal.time, effort=goal.effort, uneven=goal.uneven,
            longest=np.inf if goal.longest is None else goal.longest,
            given=_given(program.ends), held=_given(program.end_free),
        )  # fmt: skip

    def _packed(self, program: SmoothProgram) -> PathRows:
        """Arrays of a program, kept for the next step on it."""
        if self._rows is None or self._rows[0] is not program:
            names = ("step", "square", "rate", "root", "offset", "lower", "upper", "change", "weight")
            arrays = {name: getattr(program, name) for name in (*names, "q1", "q2", "q3", "jerk")}
            self._rows = program, path_rows(program.free, program.columns, **arrays)
        return self._rows[1]


def _free(program: SmoothProgram) -> Array:
    """F that is given at the ends, else 0, Shape (n, f)."""
    free = np.zeros((program.nodes, program.free.shape[2]))
    for place, given in zip((0, -1), program.end_free, strict=True):
        if given is not None:
            free[place] = given
    return free


def _given(ends: tuple[object | None, object | None]) -> tuple[bool, bool]:
    return ends[0] is not None, ends[1] is not None
