# SPDX-License-Identifier: MIT
"""The best timing of a path within limits of torques and of how fast they change, with nodes at its samples."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array
from mrts.base.errors import InputError, SolverError
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.path_program import path_program
from mrts.program.path_solver import KernelSolver
from mrts.program.range_status import RangeStatus
from mrts.program.rate_limits import RateLimits
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.smooth_program import Goal, SmoothProgram
from mrts.program.successive_steps import RatesTooSmall, TooLong, successive_steps
from mrts.program.torque_distribution import torque_weights
from mrts.scaling.result import ScalingResult
from mrts.scaling.scale import FactorQuestion
from mrts.timing.held_wrenches import GivenTorques, given_wrenches, stopped_wrenches, unheld
from mrts.timing.path_pieces import NoPath, closed_piece, path_pieces
from mrts.timing.result import RetimingResult, RetimingStatus
from mrts.timing.retimed_motion import TimedPiece
from mrts.timing.smooth_path import SmoothPath, fine_motion, joined_at_stops, smooth_path
from mrts.timing.smooth_piece import SmoothPiece, smooth_pieces

NARROWING = 1e-5
"""Of each limit, as a share of it, in the timing: what it leaves for the torques has an inside then."""

UNBOUNDED = 1e-6
"""A timing in less than this share of the usual duration is one that nothing limits."""

ON_TIME = 1e-3
"""Share of the longest duration that a motion with stops may stay below it: what weighs time and energy is searched."""

MOST_WEIGHTS = 30
"""Weights of time that are tried for it."""


@dataclass(frozen=True)
class SmoothQuestion:
    """What is asked of a smooth timing.

    Attributes:
        compared: The best constant factor, with the cell and the rule of distribution.
        loads: Load vectors that are to be carried, each Shape (10,).
        rates: Limits of rates.
        goal: What is the best.
        end_speeds: ṙ at the start and at the end, multiples of the given motion's.
        end_torques: Torques that hold still at the start and at the end, Shape (m,); None leaves them free [N m].
        fastest: Duration of the fastest timing without limits of rates, None if nothing bounds it [s].
        solver: Solves the programs.
    """

    compared: FactorQuestion
    loads: tuple[Array, ...]
    rates: RateLimits
    goal: Goal
    end_speeds: tuple[float, float]
    end_torques: GivenTorques
    fastest: float | None
    solver: KernelSolver

    @property
    def constant(self) -> ScalingResult:
        """The best constant factor with its torques."""
        return self.compared.factor.whole

    @property
    def usual(self) -> float:
        """A duration of the size of the answer, whatever the given one is: what σ is measured in [s]."""
        best, given = self.constant.trajectory, float(self.constant.motion.object.time[-1])
        if best is None or self.constant.status is RangeStatus.UNBOUNDED:
            return given if self.fastest is None else self.fastest
        return best.duration

    @property
    def weights(self) -> Array:
        """W of the effort, Shape (m, m)."""
        return torque_weights(self.constant.rule.weights, self.constant.cell)

    def problem(self, path: SmoothPath, load: Array) -> SampleProblem:
        """Rows at the nodes of a path.

        Args:
            path: The path, n nodes.
            load: Load vector, Shape (10,).
        """
        sharing = self.constant.rule.sharing
        return build_sample_problem(self.constant.cell, path.path, sharing=sharing, load=load, varying=True)


@dataclass(frozen=True)
class _Part:
    """A piece that is to be timed."""

    piece: SmoothPath
    program: SmoothProgram
    likely: Array

    def timed(self, goal: Goal, solver: KernelSolver, progress: Progress) -> "SmoothPiece | RatesTooSmall | TooLong":
        found = successive_steps(self.program, self.likely, goal, solver, lambda step, _cost: progress(step, step + 1))
        if isinstance(found, RatesTooSmall | TooLong):
            return found
        rates = np.column_stack([found.profile.u[:-1], found.profile.u[1:]])
        return SmoothPiece(piece=self.piece, x=found.profile.x, rates=rates, program=self.program, steps=found)


def smooth_timing(
    question: SmoothQuestion, motion: CoordinatedMotion, before: Sequence[TimedPiece], progress: Progress
) -> RetimingResult:
    """The best timing with limits kept at the nodes, the samples of a motion.

    Args:
        question: What is asked.
        motion: The path, N samples.
        before: The timing of the same path with other nodes, if there is one.
        progress: Told how many steps are done.

    Raises:
        InputError: If an end speed is asked for where the motion rests.
        SolverError: If no solver answers.
    """
    parts = _parts(question, motion, smooth_pieces(before))
    if isinstance(parts, str):
        return _none(question, motion, RetimingStatus.HOLDING, parts)
    timed = _timed(question, parts, progress)
    if isinstance(timed, RatesTooSmall | TooLong):
        return _none(question, motion, *_why(question, timed))
    if sum(_duration(one) for one in timed) < UNBOUNDED * question.usual:
        why = "nothing limits the speed. Give velocity limits, or limits of torque rates or jerk."
        return _none(question, motion, RetimingStatus.UNBOUNDED, why)
    done = _none(question, motion, RetimingStatus.LOCALLY_OPTIMAL, "")
    return replace(done, pieces=_planned(question, timed))


def _none(question: SmoothQuestion, motion: CoordinatedMotion, status: RetimingStatus, why: str) -> RetimingResult:
    return RetimingResult(question.constant.cell, motion, status, why, question.compared, question.loads)


def _parts(question: SmoothQuestion, motion: CoordinatedMotion, before: Sequence[SmoothPiece]) -> list[_Part] | str:
    """The pieces of a path with their programs, or why given torques do not hold still."""
    fine = fine_motion(question.constant.cell, motion)
    found = path_pieces(fine.motion)
    if isinstance(found, NoPath):
        raise SolverError("a path that could be timed without limits of rates is no path with them: please report it.")
    pieces = [closed_piece(question.constant.cell, piece) for piece in found]
    _check_ends(question, (pieces[0].rests[0], pieces[-1].rests[1]))
    time, parts = motion.object.time, []
    held: Array | None = None
    usual = question.usual / float(time[-1])
    paths = [smooth_path(fine, given, question.end_speeds, usual) for given in pieces]
    for number, piece in enumerate(joined_at_stops(paths)):
        first, last = number == 0, number == len(pieces) - 1
        problems = [question.problem(piece, load) for load in question.loads]
        start, held = _held(question, problems, held, first=first, last=last)
        for end, asked in ((0, first), (1, last)):
            why = unheld(question.constant.cell, problems[0], question.end_torques, end) if asked else None
            if why is not None:
                return why
        weights = question.weights if question.goal.effort > 0 else None
        program = path_program(
            question.constant.cell,
            piece.path,
            problems,
            question.rates,
            weights,
            _ends(piece, question.end_speeds),
            (start, held),
            piece.third_at_nodes,
        )
        likely = _likely(question, piece, program, before[number] if before else None)
        parts.append(_Part(piece, program.narrowed(NARROWING), likely))
    return parts


def _held(
    question: SmoothQuestion, problems: Sequence[SampleProblem], before: Array | None, *, first: bool, last: bool
) -> tuple[Array | None, Array | None]:
    """Wrenches at both ends of a piece: those given, or at a stop on the way those of the least torques."""
    start = given_wrenches(problems, question.end_torques, 0) if first else before
    end = given_wrenches(problems, question.end_torques, 1) if last else stopped_wrenches(problems, question.weights)
    return start, end


def _check_ends(question: SmoothQuestion, at_rest: tuple[bool, bool]) -> None:
    for place, (name, rests) in enumerate(zip(("start", "end"), at_rest, strict=True)):
        if rests and question.end_speeds[place] > 0:
            rule = "the given motion is at rest there, so no other speed is possible."
            raise InputError(f"{name}_speed", rule, value=question.end_speeds[place])
        if question.end_speeds[place] > 0 and question.end_torques[place] is not None:
            raise InputError(f"{name}_torque", "is what holds still, but the motion is not to be at rest there.")


def _ends(piece: SmoothPath, end_speeds: tuple[float, float]) -> tuple[float | None, float | None]:
    """σ̇² at both ends where the timing does not rest there, else None."""
    first, last = (
        None if stopped else float((speed * piece.speed[place] / piece.arc_speed[place]) ** 2)
        for stopped, speed, place in zip(piece.stops, end_speeds, (0, -1), strict=True)
    )
    return first, last


def _likely(question: SmoothQuestion, piece: SmoothPath, program: SmoothProgram, before: SmoothPiece | None) -> Array:
    """X around which the first step is taken."""
    if before is None:
        x = np.full(program.nodes, 1.0 if question.fastest is None else (question.usual / question.fastest) ** 2)
    else:
        x = np.interp(piece.path.object.time, before.piece.path.object.time, before.x)
    for place, known in zip((0, -1), program.ends, strict=True):
        if known is not None:
            x[place] = known
    return x


def _timed(
    question: SmoothQuestion, parts: Sequence[_Part], progress: Progress
) -> "list[SmoothPiece] | RatesTooSmall | TooLong":
    goal, solver = question.goal, question.solver
    if goal.longest is not None and len(parts) > 1:
        return _within(question, parts, goal.longest, progress)
    timed = []
    for part in parts:
        found = part.timed(goal, solver, progress)
        if not isinstance(found, SmoothPiece):
            return found
        timed.append(found)
    return timed


def _within(
    question: SmoothQuestion, parts: Sequence[_Part], longest: float, progress: Progress
) -> "list[SmoothPiece] | RatesTooSmall | TooLong":
    """The least effort of several pieces within a duration: one weight of time for all, which is searched."""

    def weighed(time: float) -> "list[SmoothPiece] | RatesTooSmall | TooLong":
        goal = Goal(time, question.goal.effort) if np.isfinite(time) else Goal()
        return _timed(replace(question, goal=goal), parts, progress)

    found = weighed(np.inf)
    if not isinstance(found, list):
        return found
    fastest = sum(_duration(one) for one in found)
    if fastest > longest:
        return TooLong(fastest)
    spent = sum(one.program.effort(one.x, one.rate, one.steps.profile.free) for one in found)
    low, high = 0.0, np.inf
    weight = question.goal.effort * spent / fastest
    for _ in range(MOST_WEIGHTS):
        tried = weighed(weight)
        if not isinstance(tried, list):
            return tried
        total = sum(_duration(one) for one in tried)
        if total <= longest:
            found, high = tried, weight
            if total >= longest * (1 - ON_TIME):
                break
        else:
            low = weight
        weight = weight * 8 if high == np.inf else high / 8 if low == 0 else float(np.sqrt(low * high))
    return found


def _duration(part: SmoothPiece) -> float:
    return float(np.sum(part.segment_times))


def _why(question: SmoothQuestion, found: RatesTooSmall | TooLong) -> tuple[RetimingStatus, str]:
    if isinstance(found, TooLong):
        return RetimingStatus.TOO_SHORT, (
            f"the motion cannot be done in {question.goal.longest:.6g} s; the fastest timing within the limits of "
            f"rates takes {found.duration:.6g} s. Allow that long at least."
        )
    given = [name for name, torque in zip(("start", "end"), question.end_torques, strict=True) if torque is not None]
    also = f", or leave the torques at the {' and the '.join(given)} free" if given else ""
    if np.isfinite(found.share):
        return RetimingStatus.RATES_TOO_SMALL, (
            "no timing within the limits of rates was found; the nearest passes them by "
            f"{100 * found.share:.3g} %. Raise the torque rates or the jerk, change the end speeds{also}."
        )
    return RetimingStatus.RATES_TOO_SMALL, (
        "no timing was found that keeps the other limits where torques cannot jump. Raise the limits that bind in the "
        f"fastest timing, or leave limits of rates out{also}."
    )


def _planned(question: SmoothQuestion, timed: Sequence[SmoothPiece]) -> tuple[SmoothPiece, ...]:
    """The pieces with the wrenches of the least ∫ τᵀWτ dt within all limits, coupled by rates over each of them."""
    planned: list[SmoothPiece] = []
    held: Array | None = None
    for number, part in enumerate(timed):
        problem = question.problem(part.piece, question.constant.cell.load)
        start, held = _held(question, [problem], held, first=number == 0, last=number == len(timed) - 1)
        program = path_program(
            question.constant.cell, part.piece.path, [problem], question.rates, question.weights, part.program.ends,
            (start, held), part.piece.third_at_nodes,
        )  # fmt: skip
        free = question.solver.torques(program, part.x, part.rate)
        if free is None:
            raise SolverError("no torques were found within the rates that the timing keeps: please report it.")
        planned.append(replace(part, plan=free))
    return tuple(planned)


def torque_plan(question: SmoothQuestion, pieces: Sequence[TimedPiece]) -> tuple[Array, Array]:
    """Torques and wrenches of the plan over a whole motion: Shape (N, m) and (N, n w).

    Args:
        question: What was asked.
        pieces: The path with its timing.
    """
    torques, wrenches = [], []
    for number, part in enumerate(smooth_pieces(pieces)):
        problem = question.problem(part.piece, question.constant.cell.load)
        unknowns = np.column_stack([part.plan, part.rate, part.x])
        skip = 0 if number == 0 else 1
        torques.append(problem.torque(unknowns)[skip:])
        wrenches.append(problem.wrench(unknowns)[skip:])
    return np.concatenate(torques), np.concatenate(wrenches)
