# SPDX-License-Identifier: MIT
"""The best timing of a path within limits of torques and of how fast they change, with nodes at its samples."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array
from mrts.base.errors import SolverError
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.motion_rows import motion_rows
from mrts.program.path_program import path_program, with_circles, without_polygons
from mrts.program.path_solver import KEPT, KernelSolver
from mrts.program.range_status import RangeStatus
from mrts.program.rate_limits import RateLimits
from mrts.program.reserve import given_sizes, reserved_torques
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.smooth_program import Goal, SmoothProfile, SmoothProgram
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.program.successive_steps import NoProfile, StepsTaken, successive_steps
from mrts.program.torque_distribution import distribute_torques, torque_weights
from mrts.program.widening import least_widening
from mrts.scaling.result import ScalingResult
from mrts.timing.path_pieces import (
    PLACES,
    STRIDE,
    NoPath,
    SmoothPath,
    closed_piece,
    joined_at_stops,
    path_pieces,
    smooth_path,
    with_samples,
)
from mrts.timing.result import RetimingResult, RetimingStatus
from mrts.timing.retimed_motion import SmoothPiece, TimedPiece, smooth_pieces

NARROWING = 1e-5
"""Of each limit, as a share of it, in the timing: what it leaves for the torques has an inside then."""

UNBOUNDED = 1e-6
"""A timing in less than this share of the usual duration is one that nothing limits."""

ON_TIME = 1e-3
"""Share of the longest duration that a motion with stops may stay below it: what weighs time and energy is searched."""

MOST_WEIGHTS = 30
"""Weights of time that are tried for it."""

Held = tuple[Array | None, Array | None]
"""The free wrenches at the start and at the end of a piece, of all loads, or None where they are free."""

_Timed = tuple[SmoothPath, SampleProblem, SmoothProgram, StepsTaken]


@dataclass(frozen=True)
class SmoothQuestion:
    """What is asked of a smooth timing.

    Attributes:
        bare: The fastest timing without limits of rates; nothing bounds it, or it has a duration.
        constant: A constant factor, whose duration is of the size of the answer's.
        goal: What is the best.
        solver: Solves the programs.
        corners: Loads whose limits the programs of a duration have so far, by their place among those of `bare`: the
            heaviest, and what was passed.
    """

    bare: RetimingResult
    constant: ScalingResult
    goal: Goal
    solver: KernelSolver
    corners: list[int] = field(init=False)

    def __post_init__(self) -> None:
        loads = self.bare.loads
        heaviest = max(range(len(loads)), key=lambda place: 0.0 if loads[place] is None else float(loads[place][0]))
        object.__setattr__(self, "corners", [heaviest])

    @property
    def rates(self) -> RateLimits:
        """Limits of rates."""
        rates = self.bare.options.rates
        assert rates is not None  # noqa: S101 (else no smooth timing is asked for)
        return rates

    @cached_property
    def usual(self) -> float:
        """A duration of the size of the answer, whatever the given one is: what σ is measured in [s]."""
        best, given = self.constant, float(self.bare.motion.object.time[-1])
        if best.duration is None or best.status is RangeStatus.UNBOUNDED:
            return given if self.bare.duration is None else self.bare.duration
        return best.duration

    @cached_property
    def sizes(self) -> Array | None:
        """What 100 % of each limit is, where torques are chosen to keep most of every limit free; else None."""
        if self.bare.options.distribute != "reserve":
            return None
        return given_sizes(self.bare.cell, self.bare.motion, polygons=False)

    @cached_property
    def weights(self) -> Array:
        """W of the effort, Shape (m, m)."""
        return torque_weights(self.bare.options.weights, self.bare.cell)

    def program(
        self, piece: SmoothPath, problems: Sequence[SampleProblem], held: Held, weights: Array | None
    ) -> SmoothProgram:
        """Limits of a piece for some loads, with the wrenches that are given at its ends."""
        start, end = (
            None if stopped else float((speed * piece.speed[place] / piece.arc_speed[place]) ** 2)
            for stopped, speed, place in zip(piece.stops, self.bare.end_speeds, (0, -1), strict=True)
        )
        third = np.stack([piece.third[::STRIDE, 0], piece.third[STRIDE - 1 :: STRIDE, 1]], axis=1)
        rows = [without_polygons(problem) for problem in problems]
        cell, path = self.bare.cell, piece.path
        program = path_program(cell, path, rows, self.rates, weights, (start, end), held, third, self.sizes)
        return with_circles(program, problems[0])  # they are the same for all loads

    def held(self, problems: Sequence[SampleProblem], before: Held, *, last: bool) -> Held:
        """Wrenches at both ends of a piece: free at those of the motion, of the least torques at a stop on the way.

        Args:
            problems: Rows of [F, u, x] at its nodes, one a load.
            before: Those of the piece before.
            last: Whether it is the last.
        """
        return before[1], None if last else _stopped_wrenches(problems, self.weights)


@dataclass(frozen=True, eq=False)
class _Part:
    """A piece that is to be timed: its rows of [F, u, x] for each load and for the cell's, and what is given of it."""

    piece: SmoothPath
    problems: list[SampleProblem]
    own: SampleProblem
    held: Held
    weights: Array | None
    before: SmoothPiece | None


def smooth_timing(
    question: SmoothQuestion, motion: CoordinatedMotion, before: Sequence[TimedPiece], progress: Progress
) -> RetimingResult:
    """The best timing with limits kept at the nodes, the samples of a motion.

    Raises:
        SolverError: If no solver answers.
    """
    bare = question.bare
    status = RetimingStatus.LOCALLY_OPTIMAL
    untimed = RetimingResult(bare.cell, motion, bare.given, bare.options, status, loads=bare.loads)
    timed = _timed(question, _parts(question, motion, smooth_pieces(before)), progress)
    if isinstance(timed, NoProfile):
        status, why = _why(question, timed)
        return replace(untimed, status=status, explanation=why)
    if _duration(timed) < UNBOUNDED * question.usual:
        why = "nothing limits the speed. Give velocity limits, or limits of torque rates or jerk."
        return replace(untimed, status=RetimingStatus.UNBOUNDED, explanation=why)
    return replace(untimed, pieces=_planned(question, timed))


def _parts(question: SmoothQuestion, motion: CoordinatedMotion, before: Sequence[SmoothPiece]) -> list[_Part]:
    cell, time = question.bare.cell, motion.object.time
    fine = with_samples(cell, motion, (time[:-1, None] + np.diff(time)[:, None] * PLACES).ravel())
    found = path_pieces(fine)
    if isinstance(found, NoPath):
        raise SolverError("a path that could be timed without limits of rates is no path with them: please report it.")
    pieces = [closed_piece(cell, piece) for piece in found]
    usual = question.usual / float(time[-1])
    paths = joined_at_stops([smooth_path(motion, piece, question.bare.end_speeds, usual) for piece in pieces])
    parts: list[_Part] = []
    held: Held = None, None
    for number, piece in enumerate(paths):
        rows = motion_rows(cell, piece.path, question.bare.options.sharing, circles=True)
        problems = [build_sample_problem(rows, load=load, varying=True) for load in question.bare.loads]
        held = question.held(problems, held, last=number == len(paths) - 1)
        weights = question.weights if question.goal.effort > 0 else None
        own = problems[0] if len(problems) == 1 else build_sample_problem(rows, varying=True)
        parts.append(_Part(piece, problems, own, held, weights, before[number] if before else None))
    return parts


def _likely(question: SmoothQuestion, part: _Part, ends: tuple[float | None, float | None]) -> Array:
    time = part.piece.path.object.time
    if part.before is None:
        fastest = question.bare.duration
        x = np.full(len(time), 1.0 if fastest is None else (question.usual / fastest) ** 2)
    else:
        x = np.interp(time, part.before.piece.path.object.time, part.before.x)
    for place, known in zip((0, -1), ends, strict=True):
        if known is not None:
            x[place] = known
    return x


def _timed(question: SmoothQuestion, parts: Sequence[_Part], progress: Progress) -> list[_Timed] | NoProfile:
    goal, timed = question.goal, []
    if goal.longest is not None and len(parts) > 1:
        return _within(question, parts, goal.longest, progress)
    for part in parts:
        program, found = _timed_part(question, part, progress)
        if isinstance(found, NoProfile):
            return found
        timed.append((part.piece, part.own, program, found))
    return timed


def _timed_part(
    question: SmoothQuestion, part: _Part, progress: Progress
) -> tuple[SmoothProgram, StepsTaken | NoProfile]:
    """The timing of a piece, and the limits that it was found with.

    Few corners of a box bind. So programs have the limits of one load, and while a best profile, or one with room,
    admits no wrenches within those of others, of the one besides that it passes most. An effort is one of all loads.
    """
    loads = range(len(question.bare.loads))
    corners = question.corners if question.goal.effort == 0 else [*loads]
    carried: dict[int, Array] = {}

    def told(step: int, _cost: float) -> None:
        progress(step, step + 1)

    def limits(chosen: Sequence[int]) -> SmoothProgram:
        held = [None if given is None else given.reshape(len(loads), -1)[[*chosen]].ravel() for given in part.held]
        problems = [part.problems[place] for place in chosen]
        return question.program(part.piece, problems, (held[0], held[1]), part.weights)

    def accepted(profile: SmoothProfile) -> bool:
        passed: dict[int, float] = {}
        for place in [place for place in loads if place not in corners]:
            program = limits([place])
            free = question.solver.torques(program, profile.x, profile.u)
            if free is None or not program.keeps(replace(profile, free=free), KEPT):
                passed[place] = _widening(program, profile)
            else:
                carried[place] = free
        if passed:
            corners.append(max(passed, key=lambda place: passed[place]))
        return not passed

    program = limits(corners).narrowed(NARROWING)
    likely = _likely(question, part, program.ends)
    while True:
        found = successive_steps(program, likely, question.goal, question.solver, told, accepted)
        if isinstance(found, NoProfile):
            return program, found
        if isinstance(found, StepsTaken):
            carried |= zip(corners, np.split(found.profile.free, len(corners), axis=1), strict=True)
            free = np.concatenate([carried[place] for place in loads], axis=1)
            return program, replace(found, profile=replace(found.profile, free=free))
        program, likely = limits(corners).narrowed(NARROWING), found.x


def _widening(program: SmoothProgram, profile: SmoothProfile) -> float:
    """The share of limits by which those of some node must widen to admit wrenches, whatever these do elsewhere."""
    rows, free = program.free.shape[1:]
    given = program.values(profile.x, profile.u, np.zeros((program.nodes, free)))
    limits = program.lower - given, program.upper - given
    anywhere, all_rows = np.full(free, -np.inf), np.ones(rows, dtype=bool)
    what = "by how much a corner's limits are passed"
    return float(np.max(least_widening(program.free, *limits, all_rows, anywhere, DEFAULT_SOLVER, what, least=-1.0)[0]))


def _within(
    question: SmoothQuestion, parts: Sequence[_Part], longest: float, progress: Progress
) -> list[_Timed] | NoProfile:
    """The least effort of several pieces within a duration: one weight of time for all, which is searched."""

    def weighed(time: float) -> list[_Timed] | NoProfile:
        goal = Goal(time, question.goal.effort) if np.isfinite(time) else Goal()
        return _timed(replace(question, goal=goal), parts, progress)

    found = weighed(np.inf)
    if isinstance(found, NoProfile):
        return found
    fastest = _duration(found)
    if fastest > longest:
        return NoProfile(duration=fastest)
    spent = sum(program.effort(taken.profile.x, taken.profile.u, taken.profile.free) for *_, program, taken in found)
    low, high = 0.0, np.inf
    weight = question.goal.effort * spent / fastest
    for _ in range(MOST_WEIGHTS):
        tried = weighed(weight)
        if isinstance(tried, NoProfile):
            return tried
        total = _duration(tried)
        if total <= longest:
            found, high = tried, weight
            if total >= longest * (1 - ON_TIME):
                break
        else:
            low = weight
        weight = weight * 8 if high == np.inf else high / 8 if low == 0 else float(np.sqrt(low * high))
    return found


def _duration(timed: Sequence[_Timed]) -> float:
    return sum(float(np.sum(program.times(taken.profile.x))) for *_, program, taken in timed)


def _why(question: SmoothQuestion, found: NoProfile) -> tuple[RetimingStatus, str]:
    if found.duration is not None:
        return RetimingStatus.TOO_SHORT, (
            f"the motion cannot be done in {question.goal.longest:.6g} s; the fastest timing within the limits of "
            f"rates takes {found.duration:.6g} s. Allow {1 + ON_TIME:g} times that at least."
        )
    if np.isfinite(found.share):
        return RetimingStatus.RATES_TOO_SMALL, (
            "no timing within the limits of rates was found; the nearest passes them by "
            f"{100 * found.share:.3g} %. Raise the torque rates or the jerk, or change the end speeds."
        )
    return RetimingStatus.RATES_TOO_SMALL, (
        "no timing was found that keeps the other limits where torques cannot jump. Raise the limits that bind in the "
        "fastest timing, or leave limits of rates out."
    )


def _planned(question: SmoothQuestion, timed: Sequence[_Timed]) -> tuple[SmoothPiece, ...]:
    planned: list[SmoothPiece] = []
    held: Held = None, None
    for number, (piece, problem, program, steps) in enumerate(timed):
        x, u = steps.profile.x, steps.profile.u
        held = question.held([problem], held, last=number == len(timed) - 1)
        limits = question.program(piece, [problem], held, question.weights)
        known = steps.shares if len(question.bare.loads) == 1 else None  # of several loads they are no single one's
        plan = reserved_torques(limits, x, u, question.solver, known)
        if plan is None:
            raise SolverError("no torques were found within the rates that the timing keeps: please report it.")
        unknowns = np.column_stack([plan, u, x])
        given = {"torque": problem.torque(unknowns), "wrench": problem.wrench(unknowns)}
        rates = np.column_stack([u[:-1], u[1:]])
        planned.append(SmoothPiece(piece=piece, x=x, rates=rates, program=program, steps=steps, plan=plan, **given))
    return tuple(planned)


def _stopped_wrenches(problems: Sequence[SampleProblem], weights: Array) -> Array:
    """The free wrenches of the least torques that hold still at the last node, of all loads."""
    found = []
    for problem in problems:
        last = problem.at(np.array([problem.samples - 1]))
        maps = {name: np.delete(getattr(last, name), -2, axis=2) for name in ("A", "torque_map", "wrench_map")}
        still = replace(last, speed=None, torque_speed=None, **maps)
        found.append(distribute_torques(still, 0.0, weights, DEFAULT_SOLVER)[0][0, :-1])
    return np.concatenate(found)
