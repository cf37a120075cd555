# SPDX-License-Identifier: MIT
"""The best profile within limits of rates, which are not convex: convex programs one after the other, each inside."""

from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import Progress
from mrts.program.path_solver import KEPT, KernelSolver
from mrts.program.reserve import of_shares
from mrts.program.smooth_program import Goal, SmoothProfile, SmoothProgram

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
    program: SmoothProgram,
    likely: Array,
    goal: Goal,
    solver: KernelSolver,
    told: Progress = lambda _done, _total: None,
    before: float = np.inf,
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
        fast = _descent(program, found, Goal(), solver, told, enough=goal.longest)
        duration = cost(program, fast.profile, Goal())
        if duration > goal.longest:
            raise NoProfileError(duration=duration)
        found = solver.step(program, fast.profile.x, goal) or fast.profile
    return _descent(program, found, goal, solver, told, before=before)


def last_step(
    program: SmoothProgram,
    best: StepsTaken,
    goal: Goal,
    solver: KernelSolver,
    told: Progress = lambda _done, _total: None,
) -> StepsTaken:
    """What is played: by a step from the best profile to one with room, or to one whose u does not jump."""
    if goal.room and program.free.shape[2]:  # a second step would lower ∫ s² dt by less than a hundredth
        longest = (1 + goal.room) * program.duration(best.profile.x)
        spacious = solver.step(of_shares(program), best.profile.x, Goal(0.0, 1.0, longest))
        if spacious is not None:
            free, shares = spacious.free[:, :-1], spacious.free[:, -1]  # the last is s
            return replace(best, profile=replace(spacious, free=free), shares=shares)
    uneven = EVEN * cost(program, best.profile, goal) / max(_jumps(program, best.profile), np.finfo(float).tiny)
    even = _descent(program, best.profile, replace(goal, uneven=uneven), solver, told)
    return replace(even, gain=best.gain)


def _descent(
    program: SmoothProgram,
    found: SmoothProfile,
    goal: Goal,
    solver: KernelSolver,
    told: Progress,
    enough: float = 0.0,
    before: float = np.inf,
) -> StepsTaken:
    """Steps from an admissible profile until one gains little, or its cost is low enough."""
    spent, steps = cost(program, found, goal), 1
    gain = abs(1 - spent / before)
    told(steps, steps + 1)
    while steps < MOST_STEPS and spent > enough and gain >= CONVERGED:
        better = solver.step(program, found.x, goal)
        if better is None:
            return StepsTaken(found, found, None)
        after = cost(program, better, goal)
        gain = max(1 - after / spent, 0.0)
        if gain > 0:
            found, spent, steps = better, after, steps + 1
            told(steps, steps + 1)
    return StepsTaken(found, found, gain)


def _first(program: SmoothProgram, likely: Array, goal: Goal, solver: KernelSolver) -> SmoothProfile:
    """Any profile within all limits, a fast one: where steps lead, if it can be foreseen, or by relaxed rates."""
    found = solver.step(program, likely, goal, moving=True)
    if found is not None:
        return found
    least = np.inf
    for slower in range(STARTS):
        try:
            return _by_relaxation(program, likely / SLOWER**slower, solver)
        except NoProfileError as none:
            least = min(least, none.share)
    raise NoProfileError(least)


def _by_relaxation(program: SmoothProgram, likely: Array, solver: KernelSolver) -> SmoothProfile:
    """An admissible profile, by ever less relaxed limits of rates."""
    x, before = likely, np.inf
    for _ in range(RELAXED_STEPS):
        found = solver.nearest(program, x)
        if found is None:
            break
        profile, share = found
        if program.keeps(profile, KEPT):
            return profile
        if not np.all(profile.x > 0) or share > before * (1 - STALLED):
            before = min(share, before)
            break
        x, before = profile.x, share
    raise NoProfileError(before)


def cost(program: SmoothProgram, profile: SmoothProfile, goal: Goal) -> float:
    """What a profile costs: the weighted sum of its duration, its effort and its jumps of u."""
    spent = goal.time * program.duration(profile.x)
    if goal.effort > 0:
        spent += goal.effort * program.effort(profile)
    return spent + goal.uneven * _jumps(program, profile)


def _jumps(program: SmoothProgram, profile: SmoothProfile) -> float:
    return float(np.sum(np.diff(profile.u) ** 2 / program.step))
