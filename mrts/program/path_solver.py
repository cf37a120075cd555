# SPDX-License-Identifier: MIT
"""Our own interior point for the programs of smooth timing; see mrts/kernel/c/smooth_timing.c."""

import ctypes
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.kernel.binding import INFINITY, filled, interruptible, structure
from mrts.kernel.c_text import SMOOTH, SMOOTH_LEVEL, one_text
from mrts.kernel.compiler import compiled_library
from mrts.program.smooth_program import LEAST_EFFORT, Goal, SmoothProfile, SmoothProgram

DURATIONS = 100.0
"""Weight of the share by which limits of rates are passed, against the duration of the profile that is started from."""

LEAST_RATES = (0.5, 500.0)
"""Shares of limits of rates that are looked for at least, in turn: one is found up to some 5000 times as much."""

KEPT = 1e-7
"""Excess over a limit that an answer may have, as a share of it: far below any tolerance."""

SAME_LENGTH = 1e-9
"""Share by which σ at the end of a path may differ where nodes were added to it: rounding."""

OF_PATH = 2
"""Slots of the whole path, behind those of the nodes: of the duration, and of the share; see smooth_timing.c."""

FOUND = 0
"""The kernel's status of an answer, `MRTS_SMOOTH_FOUND` of smooth_timing.c."""

PROGRAM = structure("smooth_timing.c", "mrts_smooth_program")
AS_THEY_ARE = ("step", "square", "rate", "offset", "q1", "q2", "q3", "jerk")
"""Attributes of a program that C takes as they are."""


class KernelSolver:
    """A primal-dual interior point whose Newton steps are solved node by node.

    A step starts from the iterates of the last one of the same kind, which is near: the one before, or one with fewer
    nodes.

    Attributes:
        iterations: How many the last program took.
        steps: Profiles that were found.
    """

    def __init__(self) -> None:
        self._rows: tuple[SmoothProgram, Any] | None = None
        self._iterates: dict[tuple[Any, ...], tuple[Array, Array]] = {}  # of a kind: σ at the nodes, what C keeps
        self.iterations = self.steps = 0

    def step(self, program: SmoothProgram, around: Array, goal: Goal, *, moving: bool = False) -> SmoothProfile | None:
        """The best profile where what is not convex is replaced by what is stricter, touching it at x = `around` > 0.

        Δt of limited changes and 1/√x of limited jerks are replaced by their tangents, which lie below them; root √x by
        its tangent on the side of a row where it presses towards the limit, and so root² √x of the effort. Where the
        tangents move with the iterates, steps from the answer would hardly better it. None where none is found.
        """
        found = self._near(program, around, goal, moving=moving)
        self.steps += found is not None
        return found

    def torques(self, program: SmoothProgram, x: Array, u: Array) -> Array | None:
        """F of the least effort at a given timing, Shape (n, f); None where none is found."""
        program = program.of_free()
        if program.free.shape[2] == 0:
            return np.zeros((len(x), 0))
        found = self._near(program, x, LEAST_EFFORT, u)
        return None if found is None else found.free

    def _near(
        self, program: SmoothProgram, around: Array, goal: Goal, u: Array | None = None, *, moving: bool = False
    ) -> SmoothProfile | None:
        """The answer of a program, whose timing is given with u, from the last iterate of its kind where there is one.

        The start far from the limits is the safer one.
        """
        changes, weighed = np.count_nonzero(np.isfinite(program.change)), np.count_nonzero(program.weight)
        sizes = *program.free.shape[1:], program.gram.shape[1], changes, len(program.jerk), weighed
        kind = *sizes, u is None, goal.time > 0, goal.effort > 0, goal.longest is None
        sigma = np.append(0.0, np.cumsum(program.step))
        last = self._iterates.pop(kind, None)
        near = None if last is None else _at_nodes(*last, sigma, program.free.shape[2])
        for kept in (None,) if near is None else (near, None):
            found = _start(program, around, u)
            solved, _, left = self._solve(program, found, goal, kept, timed=u is not None, moving=moving)
            if solved and program.keeps(found, KEPT):
                self._iterates[kind] = sigma, left
                return found
        return None

    def least_rates(self, program: SmoothProgram, x: Array) -> tuple[float, Array, Array] | None:
        """The least share of all limits of rates that wrenches within the other limits take at a constant x.

        Args:
            program: Its rows, and limits of their rates.
            x: Shape (n,).

        Returns:
            The share, half at least; its multipliers of rows at their upper and lower limits, Shape (2, n, r), and of
            changes upward and downward, Shape (2, n - 1, number of limited rows). None where none is found.
        """
        n, r, _ = program.free.shape
        count = np.count_nonzero(np.isfinite(program.change))
        for least in LEAST_RATES:
            eased, goal = replace(program, change=least * program.change), Goal(time=0.0)
            solved, beyond, left = self._solve(eased, _start(eased, x), goal, timed=True, relaxed=least)
            if solved:
                slots = n * 2 * (r + count)
                multipliers = left[slots + OF_PATH :][:slots].reshape(n, -1)  # behind as many slacks
                rows, changes = np.split(multipliers, [2 * r], axis=1)
                by_side = changes[:-1].reshape(n - 1, 2, count).swapaxes(0, 1) / least
                return least * (1 + beyond), rows.reshape(n, 2, r).swapaxes(0, 1), by_side
        return None

    def nearest(self, program: SmoothProgram, around: Array) -> tuple[SmoothProfile, float] | None:
        """The profile whose rates pass their limits least, the duration weighed little; all else is as in `step`.

        Returns:
            It and by what share; None where the other limits cannot be kept.
        """
        found = _start(program, around)
        solved, share, _ = self._solve(program, found, Goal(), relaxed=DURATIONS)
        self.steps += solved
        return (found, share) if solved else None

    def _solve(
        self,
        program: SmoothProgram,
        found: SmoothProfile,
        goal: Goal,
        kept: Array | None = None,
        *,
        timed: bool = False,
        moving: bool = False,
        relaxed: float = 0.0,
    ) -> tuple[bool, float, Array]:
        """Solve a program, tangents laid at a profile, whose ends may be given; the answer is written to it.

        Returns:
            Whether there is an answer, by what share rates are passed in it, and the iterate that it leaves.
        """
        if self._rows is None or self._rows[0] is not program:
            self._rows = program, _of_program(program)
        given, around = PROGRAM.from_buffer_copy(self._rows[1]), found.x.copy()
        given.kept = self._rows, around  # by a call that is left behind
        given.around, given.again, given.timed = around.ctypes.data, kept is not None, timed
        given.moving, given.relaxed = moving, relaxed
        given.time, given.effort, given.uneven = goal.time, goal.effort, goal.uneven
        given.longest = INFINITY if goal.longest is None else goal.longest
        given.given_start, given.given_end = given.given_start and not timed, given.given_end and not timed
        library, share, iterations = _library(), ctypes.c_double(), ctypes.c_int()
        work = np.empty(library.mrts_smooth_work(given))
        left = work[-library.mrts_smooth_kept(given) :]
        if kept is not None:
            left[:] = kept
        reached = ctypes.byref(share), ctypes.byref(iterations)
        status = interruptible(
            lambda: int(library.mrts_smooth_solve(given, found.x, found.u, found.free, *reached, work))
        )
        self.iterations = iterations.value
        return status == FOUND, share.value, left.copy()


def _start(program: SmoothProgram, x: Array, u: Array | None = None) -> SmoothProfile:
    """A profile to start from, with what is given at the ends."""
    x, free = np.array(x, dtype=np.float64), np.zeros((len(x), program.free.shape[2]))
    for place, end, held in zip((0, -1), program.ends, program.end_free, strict=True):
        x[place] = x[place] if end is None else end
        free[place] = 0.0 if held is None else held
    return SmoothProfile(x, np.zeros(len(x)) if u is None else np.array(u), free)


def _at_nodes(before: Array, kept: Array, sigma: Array, free: int) -> Array | None:
    """What C keeps of an iterate, at the nodes of before and some between; None where it is of another path.

    Slacks and multipliers are those of the nearest node before, F and control points of x lie on lines between.
    """
    n, places = len(before), np.arange(len(before))
    if len(sigma) < n or not np.isclose(sigma[-1], before[-1], rtol=SAME_LENGTH, atol=0.0):
        return None
    nearest = np.rint(np.interp(sigma, before, places)).astype(int)
    slots, coarse, control, unit = np.split(kept, np.cumsum([len(kept) - n * (free + 1) - 2, n * free, n + 1]))
    of_nodes, of_path = np.split(slots.reshape(2, -1), [-OF_PATH], axis=1)
    slots = np.concatenate([of_nodes.reshape(2, n, -1)[:, nearest].reshape(2, -1), of_path], axis=1)
    F = np.reshape([np.interp(sigma, before, of_one) for of_one in coarse.reshape(n, free).T], (free, len(sigma)))
    at = np.concatenate([sigma[:1], (sigma[1:] + sigma[:-1]) / 2, sigma[-1:]])
    was = np.concatenate([before[:1], (before[1:] + before[:-1]) / 2, before[-1:]])
    return np.concatenate([slots.ravel(), F.T.ravel(), np.interp(at, was, control), unit])


def _of_program(program: SmoothProgram) -> Any:
    """The `mrts_smooth_program` of a program, without what is asked of it; what is absent is null."""
    n, r, f = program.free.shape
    used = np.any(program.free, axis=0)  # of a row, what lies from its first column that is not 0 to its last
    end = np.max(used * np.arange(1, f + 1), axis=1, initial=0)
    first = np.minimum(np.min(np.where(used, np.arange(f), f), axis=1, initial=f), end)
    taken = np.flatnonzero((np.arange(f) >= first[:, None]) & (np.arange(f) < end[:, None]))
    limited, count, cones = np.flatnonzero(np.isfinite(program.change)), end - first, program.gram.shape[1]
    sizes = {"nodes": n, "rows": r, "free": f, "width": len(taken), "cones": cones, "changes": len(limited)}
    return filled(
        PROGRAM,
        **{name: getattr(program, name) for name in AS_THEY_ARE},
        **sizes,
        jerks=len(program.jerk),
        first=first,
        count=count,
        place=np.cumsum(count) - count,
        limited=limited,
        entry=program.free.reshape(n, r * f)[:, taken],
        lower=np.maximum(program.lower, -INFINITY),
        upper=np.minimum(program.upper, INFINITY),
        gram=np.broadcast_to(program.gram, (n, cones, 3, 3)),
        bound=np.minimum(np.broadcast_to(program.bound, (n, cones, 3)), INFINITY),
        root=program.root if np.any(program.root) else None,
        weight=program.weight if np.any(program.weight) else None,
        change=program.change[limited],
        given_start=program.ends[0] is not None,
        given_end=program.ends[1] is not None,
        held_start=program.end_free[0] is not None,
        held_end=program.end_free[1] is not None,
    )


@lru_cache(maxsize=1)
def _library() -> ctypes.CDLL:
    return compiled_library("mrts_smooth", SMOOTH_LEVEL + one_text((SMOOTH,)), (SMOOTH,))
