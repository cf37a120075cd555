# SPDX-License-Identifier: MIT
"""The best timing of a path within limits of torques and of how fast they change, with nodes at its samples."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Progress, SolverError
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.infeasibility import least_widening
from mrts.program.motion_rows import motion_rows
from mrts.program.path_solver import KEPT, KernelSolver, NoProfileError, StepsTaken, cost, last_step, successive_steps
from mrts.program.reserve import given_sizes
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.sample_ranges import RangeStatus
from mrts.program.smooth_program import Goal, SmoothProfile, SmoothProgram, path_program
from mrts.program.torque_distribution import distribute_torques, torque_weights
from mrts.timing.between_samples import refined_timing
from mrts.timing.path_pieces import STRIDE, SmoothPath, smooth_nodes, smooth_pieces, stops
from mrts.timing.result import RetimingResult, RetimingStatus, SmoothAnswer, SmoothPiece, smooth_parts

NARROWING = 1e-5
"""Of each limit, as a share of it, in the timing: what it leaves for the torques has an inside then."""

UNBOUNDED = 1e-6
"""A timing in less than this share of the usual duration is one that nothing limits."""


@dataclass(frozen=True)
class SmoothQuestion:
    """What is asked of a smooth timing.

    Attributes:
        bare: The fastest timing without limits of rates; nothing bounds it, or it has a duration.
        goal: What is the best.
        usual: A duration of the size of the answer, whatever the given one is: what σ is measured in [s].
        weights: W of the effort, Shape (m, m).
        sizes: What 100 % of each limit is, where torques are chosen to keep most of every limit free; else None.
        solver: Solves the programs.
        corners: Loads whose limits the programs of a duration have so far, by their place among those of `bare`: the
            heaviest, and what was passed.
    """

    bare: RetimingResult
    goal: Goal
    usual: float
    weights: Array
    sizes: Array | None
    solver: KernelSolver
    corners: list[int]


def smooth_timing(bare: RetimingResult, goal: Goal, progress: Progress) -> RetimingResult:
    """The best timing within limits of rates, which hold between its nodes too.

    Args:
        bare: The fastest timing without limits of rates, which are in its options; nothing bounds it, or it has a
            duration.
        goal: What is the best.
        progress: Told how many of how many steps are done.

    Raises:
        InputError: If the least energy is asked for of a motion that stops on its way.
        SolverError: If no solver answers.
    """
    usual = float(bare.motion.object.time[-1]) if bare.duration is None else bare.duration
    question = SmoothQuestion(
        bare,
        goal,
        usual,
        torque_weights(bare.options.weights, bare.cell),
        given_sizes(bare.cell, bare.motion) if bare.options.distribute == "reserve" else None,
        KernelSolver(progress),
        [int(np.argmax(np.array(bare.loads)[:, 0]))],
    )
    nodes = smooth_nodes(bare.cell, bare.given, bare.end_speeds)
    coarse = timing_at_nodes(question, nodes)
    if coarse.status is RetimingStatus.RATES_TOO_SMALL:  # they may slow it down by far: by how much takes longer to ask
        best = bare.factor
        slower = None if best.status is RangeStatus.UNBOUNDED else best.duration
        question = replace(question, usual=slower or usual)
        coarse = timing_at_nodes(question, nodes)
    again = None if bare.options.between is None else partial(timing_at_nodes, question)
    found = refined_timing(coarse, again)
    if goal.room and len(bare.loads) == 1 and found.pieces:  # with room, wrenches are near enough to be refined with
        again = None if found.excess is None or found.excess.passes else again
        found = _with_plans(question, replace(found, status=coarse.status))
        found = refined_timing(found, again and (lambda *told: _with_plans(question, timing_at_nodes(question, *told))))
    parts = smooth_parts(found.pieces)
    gains, least = [part.steps.gain for part in parts], sum(part.program.duration(part.steps.best.x) for part in parts)
    answer = SmoothAnswer(
        longest=goal.longest,
        steps=question.solver.steps,
        gain=None if None in gains else max(filter(None, gains), default=0.0),
        room=found.duration / least - 1 if found.duration is not None and goal.room else 0.0,
        fastest=bare.pieces,
    )
    return replace(found, smooth=answer)


def timing_at_nodes(
    question: SmoothQuestion, motion: CoordinatedMotion, before: RetimingResult | None = None
) -> RetimingResult:
    """The best timing with limits kept at the nodes, the samples of a motion, told the one with fewer of them."""
    bare = question.bare
    outcome = partial(RetimingResult, bare.cell, motion, bare.given, bare.options, loads=bare.loads)
    paths = smooth_pieces(bare.cell, motion, bare.end_speeds, question.usual)
    if question.goal.longest is not None and len(paths) > 1:
        raise InputError("least_energy_in", "goes with a motion that does not stop on its way: ask for each part.")
    known = smooth_parts(before.pieces) if before else [None] * len(paths)
    pieces: list[SmoothPiece] = []
    start = None
    for path, coarse in zip(paths, known, strict=True):
        search = _Search(question, path, coarse, start, stops=path is not paths[-1])
        found = search.run()
        if not isinstance(found, SmoothPiece):
            return outcome(*found)
        pieces.append(found)
        start = search.end
    timed = outcome(RetimingStatus.LOCALLY_OPTIMAL, pieces=tuple(pieces))
    return timed if question.goal.room and len(bare.loads) == 1 else _with_plans(question, timed)


def _with_plans(question: SmoothQuestion, timed: RetimingResult) -> RetimingResult:
    """A timing with the wrenches of the least torques for those that it was found with."""
    pieces = list[SmoothPiece]()
    for part in smooth_parts(timed.pieces):
        profile, known = part.steps.profile, part.steps.shares
        known = known if len(part.carried) == 1 else None  # of several loads they are no single one's
        plan = question.solver.reserved_torques(part.own, profile.x, profile.u, known)
        if plan is None:
            raise SolverError("no torques were found within the rates that the timing keeps: please report it.")
        pieces.append(replace(part, plan=plan))
    return replace(timed, pieces=tuple(pieces))


@dataclass(frozen=True, eq=False)
class _Search:
    """A piece that is to be timed.

    Attributes:
        question: What is asked.
        piece: The piece, n nodes.
        before: Its timing with fewer nodes, None where there is none.
        start: F of each problem at its start, Shape (p, f), of the least torques at a stop on the way; None where it is
            free.
        stops: Whether there is such a stop at its end.
        programs: Those that have been made, by the places of their loads.
    """

    question: SmoothQuestion
    piece: SmoothPath
    before: SmoothPiece | None
    start: Array | None
    stops: bool
    programs: dict[tuple[int, ...], SmoothProgram] = field(default_factory=dict)

    @cached_property
    def problems(self) -> list[SampleProblem]:
        """Rows of [F, u, x] at the nodes, one a load; the last is that of the cell's own load."""
        bare = self.question.bare
        rows = motion_rows(bare.cell, self.piece.path, bare.options.sharing, circles=True)
        loads = bare.loads if len(bare.loads) == 1 else (*bare.loads, None)
        return [build_sample_problem(rows, load=load, varying=True) for load in loads]

    @cached_property
    def end(self) -> Array | None:
        """As `start`, at its end."""
        return _stopped_wrenches(self.problems, self.question.weights) if self.stops else None

    @cached_property
    def ends(self) -> tuple[float | None, float | None]:
        """σ̇² at its start and its end; None where it is free, as it is at rest by the given parameter."""
        piece, speeds = self.piece, self.question.bare.end_speeds
        start, end = (
            None if at_rest else float(speed * piece.speed[place] / piece.arc_speed[place]) ** 2
            for place, speed, at_rest in zip((0, -1), speeds, stops(piece, speeds), strict=True)
        )
        return start, end

    def program(self, *chosen: int) -> SmoothProgram:
        """The limits for some of the loads, with the wrenches that are given at the ends.

        Torques are weighed in an effort, and of the cell's own load, whose least ones are the plan.
        """
        if chosen not in self.programs:
            question, third, own = self.question, self.piece.third, len(self.problems) - 1
            rates = question.bare.options.rates
            assert rates is not None  # noqa: S101 (only then is a timing smooth)
            self.programs[chosen] = path_program(
                question.bare.cell,
                self.piece.path,
                [self.problems[place] for place in chosen],
                rates,
                question.weights if question.goal.effort > 0 or chosen == (own,) else None,
                self.ends,
                (
                    None if self.start is None else self.start[list(chosen)].ravel(),
                    None if self.end is None else self.end[list(chosen)].ravel(),
                ),
                np.stack([third[::STRIDE, 0], third[STRIDE - 1 :: STRIDE, 1]], axis=1),
                question.sizes,
            )
        return self.programs[chosen]

    def run(self) -> SmoothPiece | tuple[RetimingStatus, str]:
        """The timing with its torques, or the outcome without one."""
        question, piece = self.question, self.piece
        try:
            program, steps, carried = self.timed()
        except NoProfileError as none:
            return _why(question, none)
        x, u = steps.profile.x, steps.profile.u
        if program.duration(x) < UNBOUNDED * piece.path.object.time[-1]:
            why = "nothing limits the speed. Give velocity limits, or limits of torque rates or jerk."
            return RetimingStatus.UNBOUNDED, why
        return SmoothPiece(
            piece=piece,
            x=x,
            rates=np.column_stack([u[:-1], u[1:]]),
            program=program,
            steps=steps,
            carried=carried,
            plan=carried[0],
            problem=self.problems[-1],
            own=self.program(len(self.problems) - 1),
        )

    def timed(self) -> tuple[SmoothProgram, StepsTaken, tuple[Array, ...]]:
        """The timing, the limits that it was found with, and its free wrenches for each load.

        Few corners of a box bind. So programs have the limits of one load, and while a best profile, or one with
        room, admits no wrenches within those of others, of the one besides that it passes most. An effort is one of all
        loads.
        """
        question, goal, last = self.question, self.question.goal, self.before
        loads = range(len(question.bare.loads))
        corners = question.corners if goal.effort == 0 else [*loads]
        carried: dict[int, Array] = {}

        def accepted(profile: SmoothProfile) -> bool:
            passed: dict[int, float] = {}
            for place in [place for place in loads if place not in corners]:
                program = self.program(place)
                free = question.solver.torques(program, profile.x, profile.u)
                if free is None or not program.keeps(replace(profile, free=free), KEPT):
                    passed[place] = _widening(program, profile)
                else:
                    carried[place] = free
            if passed:
                corners.append(max(passed, key=lambda place: passed[place]))
            return not passed

        if last is None:
            fastest = question.bare.duration
            likely = np.full(len(self.piece.arc), 1.0 if fastest is None else (question.usual / fastest) ** 2)
        else:
            likely = np.interp(self.piece.path.object.time, last.piece.path.object.time, last.x)
        before = np.inf if last is None else cost(last.program, last.steps.best, goal)
        while True:
            program = self.program(*corners).narrowed(NARROWING)
            best = successive_steps(program, likely, goal, question.solver, before)
            if accepted(best.profile):
                found = last_step(program, best, goal, question.solver)
                if accepted(found.profile):
                    carried |= zip(corners, np.split(found.profile.free, len(corners), axis=1), strict=True)
                    return program, found, tuple(carried[place] for place in loads)
            likely = best.profile.x


def _widening(program: SmoothProgram, profile: SmoothProfile) -> float:
    """The share of limits by which those of some node must widen to admit wrenches, whatever these do elsewhere."""
    given = program.values(profile.x, profile.u, np.zeros_like(program.free[:, 0]))
    return float(np.max(least_widening(program.free, program.lower - given, program.upper - given, least=-1.0)[0]))


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


def _stopped_wrenches(problems: Sequence[SampleProblem], weights: Array) -> Array:
    """The free wrenches of the least torques that hold still at the last node, one row a load."""
    found = []
    for problem in problems:
        last = problem.at(np.array([problem.samples - 1]))
        maps = {name: np.delete(getattr(last, name), -2, axis=2) for name in ("A", "torque_map", "wrench_map")}
        still = replace(last, speed=None, torque_speed=None, **maps)
        found.append(distribute_torques(still, 0.0, weights)[0, :-1])
    return np.stack(found)
