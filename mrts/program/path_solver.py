# SPDX-License-Identifier: MIT
"""The best profile within limits of rates, which are not convex: convex programs one after the other, each inside.

They are solved by our own interior point; see mrts/kernel/c/smooth_timing.c.
"""

import ctypes
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import Progress
from mrts.kernel.binding import INFINITY, interruptible
from mrts.kernel.c_text import SMOOTH
from mrts.kernel.programs import program_library
from mrts.program.smooth_program import (
    LEAST_EFFORT,
    PROGRAM,
    Goal,
    SmoothProfile,
    SmoothProgram,
    of_shares,
    whole_sides,
)

CONVERGED = 1e-4
"""Share of the cost by which a step must lower it, or it was the last."""

EVEN = 1e-3
"""Share of the cost that the jumps of u count for where they are largest; it costs 1e-5 of the duration."""

MOST_STEPS = 60
"""Steps after which the profile is taken as it is: every one keeps all limits."""

SLOWER = 4.0
"""Each start that is not admissible is followed by one with x so many times less."""

STARTS = 3
"""Starts of one constant speed, from each of which limits of rates are relaxed less and less."""

RELAXED_STEPS = 30
"""Steps by which relaxed limits of rates must be kept."""

STALLED = 1e-3
"""Share by which such a step must lower what rates pass their limits by, or no profile is found."""

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

SHARE_MARGIN = 1e-5
"""Share of a limit beyond the least that torques within rates may use: the least shares of a whole motion are met by
hardly more than one distribution, in which an interior point finds no inside."""


class KernelSolver:
    """A primal-dual interior point whose Newton steps are solved node by node.

    A step starts from the iterates of the last one of the same kind, which is near: the one before, or one with fewer
    nodes.

    Attributes:
        told: Told how many of how many profiles are found.
        iterations: How many the last program took.
        steps: Profiles that were found.
    """

    def __init__(self, told: Progress = lambda _done, _total: None) -> None:
        self.told = told
        self._iterates: dict[tuple[Any, ...], tuple[Array, Array]] = {}  # of a kind: σ at the nodes, what C keeps
        self.iterations = self.steps = 0

    def step(self, program: SmoothProgram, around: Array, goal: Goal, *, moving: bool = False) -> SmoothProfile | None:
        """The best profile where what is not convex is replaced by what is stricter, touching it at x = `around` > 0.

        Δt of limited changes and 1/√x of limited jerks are replaced by their tangents, which lie below them; root √x by
        its tangent on the side of a row where it presses towards the limit, and so root² √x of the effort. Where the
        tangents move with the iterates, steps from the answer would hardly better it. None where none is found.
        """
        found = self._near(program, around, goal, moving=moving)
        if found is not None:
            self.steps += 1
            self.told(self.steps, self.steps + 1)
        return found

    def torques(self, program: SmoothProgram, x: Array, u: Array) -> Array | None:
        """F of the least effort at a given timing, Shape (n, f); None where none is found."""
        program = program.of_free()
        if program.free.shape[2] == 0:
            return np.zeros((len(x), 0))
        found = self._near(program, x, LEAST_EFFORT, u)
        return None if found is None else found.free

    def reserved_torques(self, program: SmoothProgram, x: Array, u: Array, shares: Array | None = None) -> Array | None:
        """F of the least effort at a given timing among those with the least ∫ s² dt of `of_shares`, Shape (n, f).

        Where no rates join the nodes these are the torques of `reserved`; where no share counts, those of the least
        effort alone. None where none keep the limits and the rates. `shares` are s of the least ∫ s² dt where it is
        known.
        """
        if program.free.shape[2] == 0 or not np.any(program.sizes):
            return self.torques(program, x, u)
        found = self.torques(of_shares(program), x, u) if shares is None else None
        if found is not None:
            shares = found[:, -1]
        if shares is None:
            return None
        low, high = (1 - np.minimum(shares[:, None] + SHARE_MARGIN, 1.0)) * whole_sides(program.free, program.sizes)
        least = self.torques(replace(program, lower=program.lower + low, upper=program.upper - high), x, u)
        if least is None and found is None:
            return self.reserved_torques(program, x, u)
        return found[:, :-1] if least is None and found is not None else least

    def _near(
        self, program: SmoothProgram, around: Array, goal: Goal, u: Array | None = None, *, moving: bool = False
    ) -> SmoothProfile | None:
        """The answer of a program, whose timing is given with u, from the last iterate of its kind where there is one.

        The start far from the limits is the safer one.
        """
        changes, weighed = np.count_nonzero(np.isfinite(program.change)), np.count_nonzero(program.weight)
        sizes = program.in_c.rows, program.free.shape[2], program.gram.shape[1], changes, len(program.jerk), weighed
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
        n, kept = len(x), program.in_turn[0]
        r, count = program.in_c.rows, program.in_c.changes
        for least in LEAST_RATES:
            eased, goal = replace(program, change=least * program.change), Goal(time=0.0)
            solved, beyond, left = self._solve(eased, _start(eased, x), goal, timed=True, relaxed=least)
            if solved:
                slots = n * 2 * (r + count)
                multipliers = left[slots + OF_PATH :][:slots].reshape(n, -1)  # behind as many slacks
                rows, changes = np.split(multipliers, [2 * r], axis=1)
                by_side = changes[:-1].reshape(n - 1, 2, count).swapaxes(0, 1) / least
                by_row = np.zeros((2, *program.square.shape))
                by_row[..., kept] = rows.reshape(n, 2, r).swapaxes(0, 1)[..., : len(kept)]
                return least * (1 + beyond), by_row, by_side
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
        given, around = PROGRAM.from_buffer_copy(program.in_c), found.x.copy()
        given.kept = program.in_c, around  # by a call that is left behind
        given.around, given.again, given.timed = around.ctypes.data, kept is not None, timed
        given.moving, given.relaxed = moving, relaxed
        given.time, given.effort, given.uneven = goal.time, goal.effort, goal.uneven
        given.longest = INFINITY if goal.longest is None else goal.longest
        given.given_start, given.given_end = given.given_start and not timed, given.given_end and not timed
        library, share, iterations = program_library(SMOOTH), ctypes.c_double(), ctypes.c_int()
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


@dataclass(frozen=True)
class StepsTaken:
    """What the iteration found.

    Attributes:
        profile: The last profile.
        best: The last that is the best one, before any room was given: what binds there limits the speed.
        gain: Share of the cost by which the last step lowered it, 0 where it did not, or by which the only one differs
            from what was spent before; None where no solver took it.
        shares: The largest share of any limit that the profile uses at each node, where room was made, Shape (n,).
    """

    profile: SmoothProfile
    best: SmoothProfile
    gain: float | None
    shares: Array | None = None


class NoProfileError(Exception):
    """No profile was found within the limits of rates, or none within the longest duration.

    Attributes:
        share: By how much rates pass their limits in the nearest one, as a share of them; infinity if none keeps the
            other limits.
        duration: Duration of the fastest profile that was found, where it is too long [s].
    """

    def __init__(self, share: float = np.inf, duration: float | None = None) -> None:
        super().__init__()
        self.share, self.duration = share, duration


def successive_steps(
    program: SmoothProgram, likely: Array, goal: Goal, solver: KernelSolver, before: float = np.inf
) -> StepsTaken:
    """Profiles within all limits, each better than the one before, from one whose x is `likely`, > 0, Shape (n,).

    In each step Δt of limited changes and 1/√x of limited jerks are replaced by their tangents at the last profile,
    which lie below them: a convex program inside the given one, which the last profile keeps. So the cost only falls.
    Within a longest duration it starts from a profile that is fast enough. A first profile that costs what the best one
    cost `before`, with fewer nodes, is the best one: its tangents moved with it.

    Raises:
        NoProfileError: If none is found.
    """
    found = _first(program, likely, goal if goal.longest is None else Goal(), solver)
    if goal.longest is not None:
        fast = _descent(program, found, Goal(), solver, enough=goal.longest)
        duration = program.duration(fast.profile.x)
        if duration > goal.longest:
            raise NoProfileError(duration=duration)
        found = solver.step(program, fast.profile.x, goal) or fast.profile
    return _descent(program, found, goal, solver, before=before)


def last_step(program: SmoothProgram, best: StepsTaken, goal: Goal, solver: KernelSolver) -> StepsTaken:
    """What is played: by a step from the best profile to one with room, or to one whose u does not jump."""
    if goal.room and program.free.shape[2]:  # a second step would lower ∫ s² dt by less than a hundredth
        longest = (1 + goal.room) * program.duration(best.profile.x)
        spacious = solver.step(of_shares(program), best.profile.x, Goal(0.0, 1.0, longest))
        if spacious is not None:
            free, shares = spacious.free[:, :-1], spacious.free[:, -1]  # the last is s
            return replace(best, profile=replace(spacious, free=free), shares=shares)
    uneven = EVEN * cost(program, best.profile, goal) / max(_jumps(program, best.profile), np.finfo(float).tiny)
    even = _descent(program, best.profile, replace(goal, uneven=uneven), solver)
    return replace(even, gain=best.gain)


def _descent(
    program: SmoothProgram,
    found: SmoothProfile,
    goal: Goal,
    solver: KernelSolver,
    enough: float = 0.0,
    before: float = np.inf,
) -> StepsTaken:
    """Steps from an admissible profile until one gains little, or its cost is low enough."""
    spent, steps = cost(program, found, goal), 1
    gain = abs(1 - spent / before)
    while steps < MOST_STEPS and spent > enough and gain >= CONVERGED:
        better = solver.step(program, found.x, goal)
        if better is None:
            return StepsTaken(found, found, None)
        after = cost(program, better, goal)
        gain = max(1 - after / spent, 0.0)
        if gain > 0:
            found, spent, steps = better, after, steps + 1
    return StepsTaken(found, found, gain)


def _first(program: SmoothProgram, likely: Array, goal: Goal, solver: KernelSolver) -> SmoothProfile:
    """Any profile within all limits, a fast one: where steps lead, if it can be foreseen, or by relaxed rates."""
    found = solver.step(program, likely, goal, moving=True)
    if found is not None:
        return found
    least = np.inf
    for slower in range(STARTS):
        x, before = likely / SLOWER**slower, np.inf
        for _ in range(RELAXED_STEPS):
            nearest = solver.nearest(program, x)
            if nearest is None:
                break
            found, share = nearest
            if program.keeps(found, KEPT):
                return found
            least = min(least, share)
            if not np.all(found.x > 0) or share > before * (1 - STALLED):
                break
            x, before = found.x, share
    raise NoProfileError(least)


def cost(program: SmoothProgram, profile: SmoothProfile, goal: Goal) -> float:
    """What a profile costs: the weighted sum of its duration, its effort and its jumps of u."""
    spent = goal.time * program.duration(profile.x)
    if goal.effort > 0:
        spent += goal.effort * program.effort(profile)
    return spent + goal.uneven * _jumps(program, profile)


def _jumps(program: SmoothProgram, profile: SmoothProfile) -> float:
    return float(np.sum(np.diff(profile.u) ** 2 / program.step))
