# SPDX-License-Identifier: MIT
"""How far a retimed motion oversteps limits between the samples at which they were kept, and samples against that."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mrts.base.arrays import Array, apply
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import between_samples
from mrts.limits.rows import ActiveRow, in_circles
from mrts.motion.object_courses import PoseSplines, ProfiledPath
from mrts.program.between_samples import BETWEEN, COARSE, Excess
from mrts.program.infeasibility import motion_widening
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import motion_ranges
from mrts.timing.path_pieces import PLACES, PathPiece, path_pieces, root_mean_square, with_samples
from mrts.timing.result import (
    ONLY_AT_SAMPLES,
    RetimingResult,
    RetimingStatus,
    SmoothPiece,
    TimedPiece,
    between_path_samples,
)

MOST_ROUNDS = 12
"""Times that a path is timed again: a segment is then 4096 times shorter."""

MOST_SAMPLES, MOST_TIMES = 1000, 4
"""Samples up to which more are added, or so many times those of the motion."""

NEAR = 0.3
"""Share of the tolerance from which a segment is divided once one passes it: each round times the whole path."""

PARTS = 4
"""Parts of a segment in one round at most: with 2 joint accelerations, which bind all along a path, took 2.5 times as
long as no such limits, with 4 they take 1.5 times; without them 4 saves a quarter."""

MOST_STALLED = 6
"""Times in turn that a path is timed again without less excess than at best: what is left is the samples' rounding.
Those that end take up to four, where a new sample moves a switch of the fastest timing."""

SHARP = 0.1
"""Turn of the joints' direction on a segment [rad] from which a fastest timing has it divided, whatever it oversteps.
On coarse tables of joints what it takes longer than the optimum falls from a median of 0.8 to 0.2 %."""

ALIKE = 1e-12
"""Relative difference of speeds and accelerations on a segment that is rounding: its excess is what it was before."""

BENT = 0.05
"""Largest part of a joint's step that velocities and accelerations at its ends may miss: a change of branch is all."""


def refined_timing(
    timed: RetimingResult, again: Callable[[CoordinatedMotion, RetimingResult], RetimingResult] | None
) -> RetimingResult:
    """A timing whose limits hold between samples to the tolerance of its options, or that says by how much they do not.

    Each segment that oversteps limits, or is near it, is divided, of a fastest timing with those beside it, and
    first those that turn sharply. The whole path is timed again, a bounded number of times; the timing with the least
    excess is kept.

    Args:
        again: The timing of the motion with further samples, told the one before; None adds none.

    Raises:
        MotionError: If the arms cannot hold the object between the samples.
        SolverError: If no solver answers.
    """
    most = max(MOST_SAMPLES, MOST_TIMES * timed.motion.samples)
    tolerance = BETWEEN if timed.options.between is None else timed.options.between
    best, least, stalled, before = timed, Excess(np.inf, tolerance), 0, None
    for turn in range(MOST_ROUNDS + 1):
        if not timed.pieces:
            return timed
        shares, worst = excess_between(timed, tolerance, before)
        before, is_fastest = (timed, shares), timed.pieces[0].profile is not None
        share = np.concatenate([its.T.copy().max(axis=0) for its in shares])  # faster by places than by segments
        if again and turn == 0 and is_fastest:
            sharp = _sharpness([part.piece for part in timed.pieces])
            share = np.where(sharp > 1, np.maximum(share, tolerance * sharp**2), share)
        if worst.share < least.share:
            best, least, stalled = timed, worst, 0
        else:
            stalled += 1
        if again is None or turn == MOST_ROUNDS or stalled == MOST_STALLED or not (share > tolerance).any():
            break
        share = np.where(share > NEAR * tolerance, share, 0.0)
        if is_fastest:  # its switches move out of a segment that is divided
            beside = np.concatenate([np.zeros(1), share, np.zeros(1)])
            share = np.maximum(np.maximum(beside[:-2], beside[2:]), share)
        parts = np.where(share > 0, np.ceil(np.sqrt(share / tolerance)).clip(2, PARTS), 1)  # excess goes as its square
        if timed.motion.samples + np.sum(parts - 1) > most:
            break
        timed = again(_divided(timed.cell, timed.motion, parts), timed)
    status = RetimingStatus(f"{best.status.value}{ONLY_AT_SAMPLES}") if least.passes else best.status
    return replace(best, status=status, excess=least)


def without_sharp_turns(cell: Cell, motion: CoordinatedMotion) -> CoordinatedMotion:
    """A motion with its sharp turns divided, which may admit no speed as they are."""
    return _divided(cell, motion, np.ceil(_sharpness(path_pieces(cell, motion))).clip(1, PARTS))


def _sharpness(pieces: Sequence[PathPiece]) -> Array:
    """How far each segment of a path turns, as a multiple of what is `SHARP`."""
    return np.concatenate([root_mean_square(np.diff(piece.path.dq, axis=0)) for piece in pieces]) / SHARP


def _divided(cell: Cell, motion: CoordinatedMotion, parts: Array) -> CoordinatedMotion:
    """The motion with its segments divided into some parts each."""
    time, count = motion.object.time, parts.astype(int)
    segment = np.arange(len(count)).repeat(count - 1)
    place = (np.arange(1, len(segment) + 1) - (count - 1).cumsum()[segment] + count[segment] - 1) / count[segment]
    return with_samples(cell, motion, time[segment] * (1 - place) + time[segment + 1] * place)


def check_held_between(cell: Cell, motion: CoordinatedMotion) -> None:
    """Check that the arms can hold the object between the samples of a motion, where that is in doubt.

    In doubt are few samples, a course that a user wrote, which may go anywhere between them, and steps of joints that
    their velocities do not lead along: a posture that changes there.

    Raises:
        MotionError: If they cannot.
    """
    time = motion.object.time
    doubtful = np.ones((len(time) - 1, 1), dtype=bool)
    of_object = motion.object.course
    if motion.samples >= COARSE and (of_object is None or isinstance(of_object, ProfiledPath | PoseSplines)):
        h, dq, ddq = np.diff(time)[:, None], motion.dq, motion.ddq
        steps = np.diff(motion.q, axis=0)
        missed = steps - h / 2 * (dq[1:] + dq[:-1]) - h**2 / 12 * (ddq[:-1] - ddq[1:])
        doubtful = np.abs(missed) > BENT * np.abs(steps).max()
    if doubtful.any():
        between_samples(cell, motion, ((time[1:] + time[:-1]) / 2)[doubtful.any(axis=1)])


def excess_between(
    timed: RetimingResult, tolerance: float, before: tuple[RetimingResult, list[Array]] | None = None
) -> tuple[list[Array], Excess]:
    """The share by which limits are overstepped inside the segments, and the worst of all.

    Args:
        before: The timing before samples were added, and its shares: where nothing changed they are not found again.

    Returns:
        Of each piece, at each of `PLACES` in each segment, Shape (n - 1, p); and the worst.
    """
    shares, worst, time = list[Array](), Excess(0.0, tolerance), timed.motion.object.time
    for part in timed.pieces:
        row: ActiveRow | None = None
        if isinstance(part, SmoothPiece):
            share, row = _smooth_excess(timed, part)
        else:
            share = _least_excess(timed, part, before)
        shares.append(share)
        segment, place = divmod(int(np.argmax(share)), len(PLACES))
        if share[segment, place] > worst.share:
            start, end = time[part.piece.first + segment :][:2]
            named = row or partial(_overstepped, timed, part, segment, place)
            at = float(start + PLACES[place] * (end - start))
            worst = Excess(float(share[segment, place]), tolerance, at, named)
    return shares, worst


def _least_excess(timed: RetimingResult, part: TimedPiece, before: tuple[RetimingResult, list[Array]] | None) -> Array:
    """The excess at all places of a piece, Shape (n - 1, p), where wrenches do their best."""
    share, new = np.zeros((len(part.piece.step), len(PLACES))), np.ones(len(part.piece.step), dtype=bool)
    known = before and before[0].part_along(part.piece, timed.motion)
    if before and known:
        number, own = known
        old, starts, ends = before[0].pieces[number], own[:-1], own[1:]
        speeds = np.maximum(np.abs(part.x[starts] - old.x[:-1]), np.abs(part.x[ends] - old.x[1:]))
        rates = np.maximum(*np.abs(part.rates[starts] - old.rates).T)
        alike = (starts + 1 == ends) & (speeds <= ALIKE * old.x[:-1]) & (rates <= ALIKE * np.abs(old.rates).max())
        share[starts[alike]] = before[1][number][alike]
        new[starts[alike]] = False
    segments = new.nonzero()[0]
    if segments.size:
        played = between_path_samples(timed.cell, part, segments)
        rows, one = motion_rows(timed.cell, played, timed.options.sharing), np.ones(played.samples)
        found = [motion_widening(rows, one, load) for load in timed.loads]
        share[segments] = np.max(found, axis=0).reshape(-1, len(PLACES))
    return share


def _overstepped(timed: RetimingResult, part: TimedPiece, segment: int, place: int) -> ActiveRow | None:
    played = between_path_samples(timed.cell, part, np.array([segment]))
    rows, one = motion_rows(timed.cell, played, timed.options.sharing), np.ones(played.samples)
    worst = max(timed.loads, key=lambda load: motion_widening(rows, one, load)[place])
    found = motion_ranges(rows, worst, 1.0).binding(place, "upper")
    return found[0] if found else None


def _smooth_excess(timed: RetimingResult, part: SmoothPiece) -> tuple[Array, ActiveRow]:
    """The excess over rows and limits of jerk at all places of a smooth piece, Shape (n - 1, p), and the worst limit.

    Torques are commanded linear in time between nodes, so their rates are constant there and kept; what the motion
    needs differs from that by the square of the step. So it is looked at with wrenches that are linear too: those of
    the plan, and where the load varies those that carry each of its corners.
    """
    inside, segment, place, x, u = part.between()
    path = part.piece.fine.at(inside)
    judged = [(timed.cell.load, part.plan)]
    if len(timed.loads) > 1:
        judged += zip(timed.loads, part.carried, strict=True)
    over: list[Array] = []
    row_at: list[Callable[..., ActiveRow]] = []
    rates, program = timed.options.rates, part.program
    if rates is not None and program.jerk.size:
        limited = np.isfinite(rates.jerk)
        slope = (np.diff(part.rates)[segment, 0] / part.piece.step[segment])[:, None]
        thirds = np.stack([part.piece.third[inside - 1, 1], part.piece.third[inside, 0]])[:, :, limited]
        jerk = path.dq[:, limited] * slope + 3 * path.ddq[:, limited] * u[:, None] + thirds * x[:, None]
        over.append(np.abs(jerk) * np.sqrt(x)[:, None] / program.jerk - 1)
        row_at.append(lambda row, **_side: ActiveRow(program.jerk_names[row], "upper", float(program.jerk[row])))
    rows = motion_rows(timed.cell, path, timed.options.sharing, circles=True)
    for load, free in judged:
        between = free[segment] * (1 - place[:, None]) + free[segment + 1] * place[:, None]
        problem = build_sample_problem(rows, load=load, varying=True)
        values = apply(problem.A, np.column_stack([between, u, x]))
        if problem.speed is not None:
            values += problem.speed * np.sqrt(x[:, None])
        sides = np.stack([values - problem.upper, problem.lower - values])
        in_circles(problem.names, *sides)
        over.append(sides)
        row_at.append(problem.active_row)
    shares = np.stack([np.max(sides, axis=(0, 2)) for sides in over])
    source, most = divmod(int(np.argmax(shares)), len(x))
    sides = over[source][:, most]
    row = int(np.argmax(np.max(sides, axis=0)))
    by_place = np.max(shares, axis=0).reshape(-1, len(PLACES))
    return by_place, row_at[source](row, upper=bool(sides[0, row] >= sides[1, row]))
