# SPDX-License-Identifier: MIT
"""Our own interior point for the programs of smooth timing; see mrts/kernel/c/smooth/interior_point.h."""

from dataclasses import replace
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.kernel.smooth_programs import PathRows, Solved, path_rows, solve_smooth
from mrts.program.smooth_program import Goal, SmoothProfile, SmoothProgram

NEAR = 0.1
"""Share by which a step may have moved any x for the next one to start from its iterates: tangents change as much."""

DURATIONS = 100.0
"""Weight of the share by which limits of rates are passed, against the duration of the profile that is started from."""

KEPT = 1e-7
"""Excess over a limit that an answer may have, as a share of it: far below any tolerance."""


class KernelSolver:
    """A primal-dual interior point whose Newton steps are solved node by node.

    Attributes:
        iterations: How many the last program took.
        steps: Profiles that were found.
    """

    def __init__(self) -> None:
        self._rows: tuple[SmoothProgram, PathRows] | None = None
        self._last: tuple[SmoothProgram, Goal, Array, Array] | None = None  # program, goal, x and iterates
        self.iterations = self.steps = 0

    def step(self, program: SmoothProgram, around: Array, goal: Goal, *, moving: bool = False) -> SmoothProfile | None:
        """The best profile where what is not convex is replaced by what is stricter, touching it at a profile.

        Δt of limited changes and 1/√x of limited jerks are replaced by their tangents, which lie below them; root √x by
        its tangent on the side of a row where it presses towards the limit, and so root² √x of the effort.

        Args:
            program: The program.
            around: x > 0 where tangents are laid, Shape (n,).
            goal: What is the best.
            moving: Whether tangents follow the iterates: steps would hardly better the answer.

        Returns:
            The profile, within all limits, or None where none is found.
        """
        last, self._last = self._last, None
        evened = replace(goal, uneven=0.0)
        known = last and last[0] is program and last[1] == evened and np.array_equal(last[2], around)
        for work in (last[3], None) if last and known else (None,):  # the start far from the limits is the safer one
            found, solved = self._profile(program, around, goal, moving=moving, last=work)
            if not (solved.found and program.keeps(found, KEPT)):
                continue
            self.steps += 1
            if moving or np.max(np.abs(found.x / around - 1)) <= NEAR:
                self._last = program, evened, found.x.copy(), solved.work
            return found
        return None

    def torques(self, program: SmoothProgram, x: Array, u: Array) -> Array | None:
        """F of the least effort at a given timing, Shape (n, f); None where none is found."""
        program = program.without_jerks()
        if program.free.shape[2] == 0:
            return np.zeros((program.nodes, 0))
        timed = SmoothProfile(np.array(x, dtype=np.float64), np.array(u, dtype=np.float64), program.given_free())
        solved = self._solved(program, timed, around=timed.x.copy(), effort=1.0, timed=True)
        return timed.free if solved.found and program.excess(timed.x, timed.u, timed.free) <= KEPT else None

    def nearest(self, program: SmoothProgram, around: Array) -> tuple[SmoothProfile, float] | None:
        """The profile whose rates pass their limits least, the duration weighed little; all else is as in `step`.

        Args:
            program: The program.
            around: x > 0 where tangents are laid, Shape (n,).

        Returns:
            It and by what share; None where the other limits cannot be kept.
        """
        found, solved = self._profile(program, around, Goal(), relaxed=DURATIONS)
        self.steps += solved.found
        return (found, solved.share) if solved.found else None

    def _profile(
        self, program: SmoothProgram, around: Array, goal: Goal, **options: Any
    ) -> tuple[SmoothProfile, Solved]:
        around = np.array(around, dtype=np.float64)
        x = around.copy()
        for place, given in zip((0, -1), program.ends, strict=True):
            if given is not None:
                x[place] = given
        found = SmoothProfile(x, np.zeros(program.nodes), program.given_free())
        solved = self._solved(
            program, found, around=around, time=goal.time, effort=goal.effort, uneven=goal.uneven,
            longest=np.inf if goal.longest is None else goal.longest, given=_given(program.ends), **options,
        )  # fmt: skip
        return found, solved

    def _solved(self, program: SmoothProgram, found: SmoothProfile, **options: Any) -> Solved:
        """How the kernel ended; the answer is in the arrays of the profile, whose ends may be given."""
        if self._rows is None or self._rows[0] is not program:
            names = ("step", "square", "rate", "root", "offset", "lower", "upper", "change", "weight")
            arrays = {name: getattr(program, name) for name in (*names, "q1", "q2", "q3", "jerk")}
            self._rows = program, path_rows(program.free, **arrays)
        held = _given(program.end_free)
        solved = solve_smooth(self._rows[1], found.x, found.u, found.free, held=held, **options)
        self.iterations = solved.iterations
        return solved


def _given(ends: tuple[object | None, object | None]) -> tuple[bool, bool]:
    return ends[0] is not None, ends[1] is not None
