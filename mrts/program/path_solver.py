# SPDX-License-Identifier: MIT
"""Our own interior point for the programs of smooth timing; see mrts/kernel/c/smooth/interior_point.h."""

from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.kernel.smooth_programs import Ask, PathRows, path_rows, smooth_programs
from mrts.program.smooth_program import Goal, SmoothProfile, SmoothProgram

NEAR = 0.1
"""Share by which a step may have moved any x for the next one to start from its iterates: tangents change as much."""


DURATIONS = 100.0
"""Weight of the share by which limits of rates are passed, against the duration of the profile that is started from."""

KEPT = 1e-7
"""Excess over a limit that an answer may have, as a share of it: far below any tolerance."""


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
        steps: Profiles that were found.

    Raises:
        CompilerError: If there is no C compiler, or it fails.
    """

    def __init__(self) -> None:
        self._programs = smooth_programs()
        self._rows: tuple[SmoothProgram, PathRows] | None = None
        self._last: _Answer | None = None
        self.iterations = self.steps = 0

    def step(self, program: SmoothProgram, around: Array, goal: Goal) -> SmoothProfile | None:
        """The best profile where what is not convex is replaced by what is stricter, touching it at a profile.

        Δt of limited changes and 1/√x of limited jerks are replaced by their tangents, which lie below them; root √x by
        its tangent on the side of a row where it presses towards the limit, and so root² √x of the effort.

        Args:
            program: The program.
            around: x > 0 where tangents are laid, Shape (n,).
            goal: What is the best.

        Returns:
            The profile, within all limits, or None where none is found.
        """
        return self._step(program, around, goal, moving=False)

    def near(self, program: SmoothProgram, around: Array, goal: Goal) -> SmoothProfile | None:
        """A profile within all limits that steps would hardly better: the tangents follow the iterates.

        Args:
            program: The program.
            around: x > 0 to start from, Shape (n,).
            goal: What is the best.
        """
        return self._step(program, around, goal, moving=True)

    def torques(self, program: SmoothProgram, x: Array, u: Array) -> Array | None:
        """F of the least effort at a given timing, Shape (n, f); None where none is found.

        Args:
            program: The program.
            x: Shape (n,).
            u: Shape (n,).
        """
        program = program.without_jerks()
        free = _free(program)
        if free.shape[1] == 0:
            return free
        timed = [np.array(of, dtype=np.float64) for of in (x, u)]
        ask = Ask(around=timed[0].copy(), effort=1.0, timed=True, held=_given(program.end_free))
        solved = self._programs.solve(self._packed(program), ask, timed[0], timed[1], free)
        self.iterations = solved.iterations
        return free if solved.found and program.excess(timed[0], timed[1], free) <= KEPT else None

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
        self.steps += solved.found
        return (SmoothProfile(start.x, start.u, start.free), solved.share) if solved.found else None

    def _step(self, program: SmoothProgram, around: Array, goal: Goal, *, moving: bool) -> SmoothProfile | None:
        last, self._last = self._last, None
        known = last and last.program is program and last.goal == goal.evened(0.0) and np.array_equal(last.x, around)
        for work in (last.work, None) if last and known else (None,):  # the start far from the limits is the safer one
            start = self._start(program, around)
            ask = replace(self._ask(program, start.around, goal), moving=moving, last=work)
            solved = self._programs.solve(self._packed(program), ask, start.x, start.u, start.free)
            self.iterations = solved.iterations
            if not (solved.found and _kept(program, start)):
                continue
            self.steps += 1
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


def _kept(program: SmoothProgram, found: _Start) -> bool:
    """Whether a profile keeps all limits."""
    return bool(np.all(found.x > 0)) and program.excess(found.x, found.u, found.free) <= KEPT


def _free(program: SmoothProgram) -> Array:
    """F that is given at the ends, else 0, Shape (n, f)."""
    free = np.zeros((program.nodes, program.free.shape[2]))
    for place, given in zip((0, -1), program.end_free, strict=True):
        if given is not None:
            free[place] = given
    return free


def _given(ends: tuple[object | None, object | None]) -> tuple[bool, bool]:
    return ends[0] is not None, ends[1] is not None
