# SPDX-License-Identifier: MIT
"""The best timing of a path within limits of torques and of how fast they change, with nodes at its samples."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Progress, SolverError
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.motion_rows import motion_rows
from mrts.program.path_program import path_program
from mrts.program.path_solver import KEPT, KernelSolver
from mrts.program.range_status import RangeStatus
from mrts.program.rate_limits import RateLimits
from mrts.program.reserve import given_sizes, reserved_torques
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.smooth_program import Goal, SmoothProfile, SmoothProgram
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.program.successive_steps import NoProfileError, StepsTaken, successive_steps
from mrts.program.torque_distribution import distribute_torques, torque_weights
from mrts.program.widening import least_widening
from mrts.scaling.result import ScalingResult
from mrts.timing.path_pieces import (
    PLACES,
    STRIDE,
    PathPiece,
    closed_piece,
    joined_at_stops,
    path_pieces,
    smooth_path,
    stops,
    with_samples,
)
from mrts.timing.result import RetimingResult, RetimingStatus
from mrts.timing.retimed_motion import SmoothPiece

NARROWING = 1e-5
"""Of each limit, as a share of it, in the timing: what it leaves for the torques has an inside then."""

UNBOUNDED = 1e-6
"""A timing in less than this share of the usual duration is one that nothing limits."""


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
    corners: list[int]

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
        return given_sizes(self.bare.cell, self.bare.motion)

    @cached_property
    def weights(self) -> Array:
        """W of the effort, Shape (m, m)."""
        return torque_weights(self.bare.options.weights, self.bare.cell)

    def program(self, part: "_Part", chosen: Sequence[int], weights: Array | None) -> SmoothProgram:
        """Limits of a piece for some of its loads, with the wrenches that are given at its ends."""
        piece, speeds, problems = part.piece, self.bare.end_speeds, [part.problems[place] for place in chosen]
        start, end = (
            None if stopped else float((speed * piece.speed[place] / piece.arc_speed[place]) ** 2)
            for stopped, speed, place in zip(stops(piece, speeds), speeds, (0, -1), strict=True)
        )
        first, last = (None if held is None else held[[*chosen]].ravel() for held in part.held)
        third = np.stack([part.third[::STRIDE, 0], part.third[STRIDE - 1 :: STRIDE, 1]], axis=1)
        return path_program(
            self.bare.cell,
            piece.path,
            problems,
            self.rates,
            weights,
            (start, end),
            (first, last),
            third,
            self.sizes,
        )


@dataclass(frozen=True, eq=False)
class _Part:
    """A piece that is to be timed.

    Attributes:
        piece: The piece, by σ.
        fine: Of `SmoothPiece`.
        third: Likewise.
        problems: Rows of [F, u, x] at its nodes, one a load; the last is that of the cell's own load.
        held: F of each problem at its start and its end, Shape (p, f), of the least torques at a stop on the way; None
            where it is free.
        before: The same piece in the round before.
    """

    piece: PathPiece
    fine: CoordinatedMotion
    third: Array
    problems: list[SampleProblem]
    held: tuple[Array | None, Array | None]
    before: SmoothPiece | None


def smooth_timing(
    question: SmoothQuestion, motion: CoordinatedMotion, before: Sequence[SmoothPiece], progress: Progress
) -> RetimingResult:
    """The best timing with limits kept at the nodes, the samples of a motion.

    Raises:
        InputError: If the least energy is asked for of a motion that stops on its way.
        SolverError: If no solver answers.
    """
    bare = question.bare
    status = RetimingStatus.LOCALLY_OPTIMAL
    untimed = RetimingResult(bare.cell, motion, bare.given, bare.options, status, loads=bare.loads)
    parts = _parts(question, motion, before)
    if question.goal.longest is not None and len(parts) > 1:
        raise InputError("least_energy_in", "goes with a motion that does not stop on its way: ask for each part.")
    try:
        timed = [(part, *_timed(question, part, progress)) for part in parts]
    except NoProfileError as none:
        status, why = _why(question, none)
        return replace(untimed, status=status, explanation=why)
    if sum(float(np.sum(program.times(found.profile.x))) for _, program, found in timed) < UNBOUNDED * question.usual:
        why = "nothing limits the speed. Give velocity limits, or limits of torque rates or jerk."
        return replace(untimed, status=RetimingStatus.UNBOUNDED, explanation=why)
    return replace(untimed, pieces=tuple(_planned(question, *one) for one in timed))


def _parts(question: SmoothQuestion, motion: CoordinatedMotion, before: Sequence[SmoothPiece]) -> list[_Part]:
    cell, time, loads = question.bare.cell, motion.object.time, question.bare.loads
    fine = with_samples(cell, motion, (time[:-1, None] + np.diff(time)[:, None] * PLACES).ravel())
    pieces = [closed_piece(cell, piece) for piece in path_pieces(fine)]
    usual = question.usual / float(time[-1])
    by_sigma, *other = zip(*(smooth_path(motion, one, question.bare.end_speeds, usual) for one in pieces), strict=True)
    paths = joined_at_stops(by_sigma)
    parts: list[_Part] = []
    start = None
    for number, (piece, fine, third) in enumerate(zip(paths, *other, strict=True)):
        rows = motion_rows(cell, piece.path, question.bare.options.sharing, circles=True)
        carried = loads if len(loads) == 1 else (*loads, None)
        problems = [build_sample_problem(rows, load=load, varying=True) for load in carried]
        end = None if number == len(paths) - 1 else _stopped_wrenches(problems, question.weights)
        parts.append(_Part(piece, fine, third, problems, (start, end), before[number] if before else None))
        start = end
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


def _timed(question: SmoothQuestion, part: _Part, progress: Progress) -> tuple[SmoothProgram, StepsTaken]:
    """The timing of a piece, and the limits that it was found with.

    Few corners of a box bind. So programs have the limits of one load, and while a best profile, or one with room,
    admits no wrenches within those of others, of the one besides that it passes most. An effort is one of all loads.
    """
    loads = range(len(question.bare.loads))
    corners = question.corners if question.goal.effort == 0 else [*loads]
    carried: dict[int, Array] = {}

    def limits(chosen: Sequence[int]) -> SmoothProgram:
        return question.program(part, chosen, question.weights if question.goal.effort > 0 else None)

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
        found = successive_steps(
            program, likely, question.goal, question.solver, lambda step: progress(step, step + 1), accepted
        )
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


def _why(question: SmoothQuestion, found: NoProfileError) -> tuple[RetimingStatus, str]:
    if found.duration is not None:
        return RetimingStatus.TOO_SHORT, (
            f"the motion cannot be done in {question.goal.longest:.6g} s; the fastest timing within the limits of "
            f"rates takes {found.duration:.6g} s. Allow more than that."
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


def _planned(question: SmoothQuestion, part: _Part, program: SmoothProgram, steps: StepsTaken) -> SmoothPiece:
    x, u, problem = steps.profile.x, steps.profile.u, part.problems[-1]
    known = steps.shares if len(question.bare.loads) == 1 else None  # of several loads they are no single one's
    limits = question.program(part, [len(part.problems) - 1], question.weights)
    plan = reserved_torques(limits, x, u, question.solver, known)
    if plan is None:
        raise SolverError("no torques were found within the rates that the timing keeps: please report it.")
    unknowns = np.column_stack([plan, u, x])
    return SmoothPiece(
        piece=part.piece,
        fine=part.fine,
        third=part.third,
        x=x,
        rates=np.column_stack([u[:-1], u[1:]]),
        program=program,
        steps=steps,
        plan=plan,
        torque=problem.torque(unknowns),
        wrench=problem.wrench(unknowns),
    )


def _stopped_wrenches(problems: Sequence[SampleProblem], weights: Array) -> Array:
    """The free wrenches of the least torques that hold still at the last node, one row a load."""
    found = []
    for problem in problems:
        last = problem.at(np.array([problem.samples - 1]))
        maps = {name: np.delete(getattr(last, name), -2, axis=2) for name in ("A", "torque_map", "wrench_map")}
        still = replace(last, speed=None, torque_speed=None, **maps)
        found.append(distribute_torques(still, 0.0, weights, DEFAULT_SOLVER)[0][0, :-1])
    return np.stack(found)
