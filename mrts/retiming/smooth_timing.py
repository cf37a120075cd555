# SPDX-License-Identifier: MIT
"""The best timing of a path within limits of torques and of how fast they change, with nodes at its samples."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array
from mrts.base.errors import InputError, SolverError
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.retiming.path_pieces import NoPath, closed_piece, path_pieces
from mrts.retiming.result import RetimingResult, RetimingStatus
from mrts.retiming.retimed_motion import TimedPiece
from mrts.retiming.smooth_path import SmoothPath, smooth_path
from mrts.retiming.smooth_piece import SmoothPiece, smooth_pieces
from mrts.samples.sample_problem import SampleProblem, build_sample_problem
from mrts.samples.torque_distribution import torque_weights
from mrts.scaling.result import ScalingResult
from mrts.smooth.path_program import path_program
from mrts.smooth.program import Goal
from mrts.smooth.rate_limits import RateLimits
from mrts.smooth.smooth_solvers import CheckedSolver
from mrts.smooth.successive_steps import RatesTooSmall, successive_steps

NARROWING = 1e-6
"""Of each limit, as a share of it, in the timing: what it leaves for the torques has an inside then."""

UNBOUNDED = 1e-6
"""A timing in less than this share of the given duration is one that nothing limits."""


@dataclass(frozen=True)
class SmoothQuestion:
    """What is asked of a smooth timing.

    Attributes:
        constant: The best constant factor, with the cell and the rule of distribution.
        loads: Load vectors that are to be carried, each Shape (10,).
        rates: Limits of rates.
        goal: What is the best.
        end_speeds: ṙ at the start and at the end, multiples of the given motion's.
        fastest: Duration of the fastest timing without limits of rates, None if nothing bounds it [s].
        solver: Solves the programs.
    """

    constant: ScalingResult
    loads: tuple[Array, ...]
    rates: RateLimits
    goal: Goal
    end_speeds: tuple[float, float]
    fastest: float | None
    solver: CheckedSolver


def smooth_timing(question: SmoothQuestion, motion: CoordinatedMotion, progress: Progress) -> RetimingResult:
    """The best timing with limits kept at the nodes, the samples of a motion.

    Args:
        question: What is asked.
        motion: The path, N samples.
        progress: Told how many steps are done.

    Raises:
        InputError: If an end speed is asked for where the motion rests.
        SolverError: If no solver answers.
    """
    constant = question.constant
    cell, found = constant.cell, path_pieces(motion)
    if isinstance(found, NoPath):
        raise SolverError("a path that could be timed without limits of rates is no path with them: please report it.")
    pieces = [closed_piece(cell, piece) for piece in found]
    ends = ((pieces[0].rests[0], "start_speed", 0), (pieces[-1].rests[1], "end_speed", 1))
    for rests, name, place in ends:
        if rests and question.end_speeds[place] > 0:
            rule = "the given motion is at rest there, so no other speed is possible."
            raise InputError(name, rule, value=question.end_speeds[place])
    time, timed = motion.object.time, []
    for number, piece in enumerate(pieces):
        n = len(piece.speed)
        smooth = smooth_path(piece, float(time[piece.first + n - 1] - time[piece.first]))
        first, last = number == 0, number == len(pieces) - 1
        speeds = (question.end_speeds[0] if first else 0.0, question.end_speeds[1] if last else 0.0)
        answer = _timed(question, smooth, speeds, float(time[-1]), progress)
        if isinstance(answer, str):
            return RetimingResult(cell, motion, RetimingStatus.RATES_TOO_SMALL, answer, constant, question.loads)
        timed.append(answer)
    duration = sum(float(np.sum(part.segment_times)) for part in timed)
    if duration < UNBOUNDED * time[-1]:
        why = "nothing limits the speed. Give velocity limits, or limits of torque rates or jerk."
        return RetimingResult(cell, motion, RetimingStatus.UNBOUNDED, why, constant, question.loads)
    return RetimingResult(
        cell, motion, RetimingStatus.LOCALLY_OPTIMAL, "", constant, question.loads, pieces=tuple(timed)
    )


def _timed(
    question: SmoothQuestion, piece: SmoothPath, end_speeds: tuple[float, float], given: float, progress: Progress
) -> SmoothPiece | str:
    """A piece with its timing, or why there is none."""
    weights = None
    if question.goal.effort > 0:
        weights = torque_weights(question.constant.rule.weights, piece.path.q.shape[1])
    ends = _ends(piece, end_speeds)
    problems = [sample_problem(question.constant, piece, load) for load in question.loads]
    program = path_program(question.constant.cell, piece.path, problems, question.rates, weights, ends)
    program = program.narrowed(NARROWING)
    likely = given if question.fastest is None else question.fastest
    around = np.full(program.nodes, (given / likely) ** 2)
    for place, x in zip((0, -1), ends, strict=True):
        if x is not None:
            around[place] = x
    found = successive_steps(
        program, around, question.goal, question.solver, lambda step, _cost: progress(step, step + 1)
    )
    if isinstance(found, RatesTooSmall):
        return _too_small(found)
    profile = found.profile
    rates = np.column_stack([profile.u[:-1], profile.u[1:]])
    return SmoothPiece(piece=piece, x=profile.x, rates=rates, program=program, steps=found)


def _ends(piece: SmoothPath, end_speeds: tuple[float, float]) -> tuple[float | None, float | None]:
    """σ̇² at both ends where the motion does not rest there, else None."""
    first, last = (
        None if rests else float((speed * piece.speed[place] / piece.arc_speed[place]) ** 2)
        for rests, speed, place in zip(piece.rests, end_speeds, (0, -1), strict=True)
    )
    return first, last


def _too_small(found: RatesTooSmall) -> str:
    if np.isfinite(found.share):
        return (
            f"no timing within the limits of rates was found; the nearest passes them by {100 * found.share:.3g} %. "
            "Raise the torque rates or the jerk, or give other end speeds."
        )
    return "no timing was found that keeps the other limits where torques cannot jump. Raise the limits of rates."


def sample_problem(constant: ScalingResult, piece: SmoothPath, load: Array) -> SampleProblem:
    """Rows at the nodes of a piece for one load.

    Args:
        constant: With the cell and the rule of distribution.
        piece: The piece.
        load: Load vector, Shape (10,).
    """
    return build_sample_problem(constant.cell, piece.path, sharing=constant.rule.sharing, load=load, varying=True)


def torque_plan(question: SmoothQuestion, pieces: Sequence[TimedPiece], load: Array) -> tuple[Array, Array]:
    """The least τᵀWτ within all limits at a timing, torques coupled by their rates: Shape (N, m) and (N, n w).

    Args:
        question: What was asked.
        pieces: The path with its timing.
        load: Load vector that is carried, Shape (10,).

    Raises:
        SolverError: If no solver answers.
    """
    torques, wrenches = [], []
    for number, part in enumerate(smooth_pieces(pieces)):
        problem = sample_problem(question.constant, part.piece, load)
        W = torque_weights(question.constant.rule.weights, part.piece.path.q.shape[1])
        program = path_program(question.constant.cell, part.piece.path, [problem], question.rates, W, part.program.ends)
        free = question.solver.torques(program, part.x, part.rate)
        if free is None:
            raise SolverError("no torques were found within the rates that the timing keeps: please report it.")
        unknowns = np.column_stack([free, part.rate, part.x])
        skip = 0 if number == 0 else 1
        torques.append(problem.torque(unknowns)[skip:])
        wrenches.append(problem.wrench(unknowns)[skip:])
    return np.concatenate(torques), np.concatenate(wrenches)
