# SPDX-License-Identifier: MIT
"""How far a retimed motion oversteps limits between the samples at which they were kept, and samples against that."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import between_samples, denser, moved_remarks
from mrts.limits.rows import ActiveRow
from mrts.motion.object_courses import Geodesic, PoseSplines, WaypointPath
from mrts.program.excess import Excess
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_widening import motion_widening
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.program.trajectory_programs import motion_ranges
from mrts.timing.path_pieces import PLACES
from mrts.timing.result import RetimingResult
from mrts.timing.retimed_motion import between_path_samples

MOST_ROUNDS = 12
"""Times that a path is timed again: a segment is then 4096 times shorter."""

MOST_SAMPLES, MOST_TIMES = 1000, 4
"""Samples up to which more are added, or so many times those of the motion."""

MOST_STALLED = 6
"""Times in turn that a path is timed again without less excess than at best: what is left is the samples' rounding.
Those that end take up to four, where a new sample moves a switch of the fastest timing."""

COARSE = 64
"""Motions of fewer samples are looked at between all of them, as by `mrts.program.search.COARSE`."""

BENT = 0.05
"""Largest part of a joint's step that velocities and accelerations at its ends may miss: a change of branch is all."""


@dataclass(frozen=True)
class SegmentExcess:
    """Excess over limits inside the segments of a retimed path.

    Attributes:
        share: The worst of each segment, Shape (N - 1,).
        worst: Of all.
    """

    share: Array
    worst: Excess


def refined_timing(
    timed: RetimingResult,
    again: Callable[[CoordinatedMotion], RetimingResult],
    excess: Callable[[RetimingResult], SegmentExcess],
    tolerance: float,
    *,
    adds: bool,
    near: float = 1.0,
) -> RetimingResult:
    """A timing whose limits hold between samples to a tolerance, or that says by how much they do not.

    Each segment that oversteps limits gets a sample in its middle, and the whole path is timed again: a bounded number
    of times, of which the one with the least excess is kept.

    Args:
        timed: The fastest timing of a motion.
        again: Times the same motion with more samples.
        excess: Finds by how much a timing oversteps limits between samples.
        tolerance: Share of a limit by which it may be overstepped.
        adds: Whether samples are added at all.
        near: Share of the tolerance from which a segment gets a sample once one passes it: less than 1 takes fewer
            rounds and more samples.

    Raises:
        MotionError: If the arms cannot hold the object between the samples.
        SolverError: If no solver answers.
    """
    most = max(MOST_SAMPLES, MOST_TIMES * timed.motion.samples)
    best, stalled = timed, 0
    for turn in range(MOST_ROUNDS + 1):
        if not timed.pieces:
            return timed
        found = excess(timed)
        timed = with_excess(timed, found.worst)
        if best.excess is None or found.worst.share < best.excess.share:
            best, stalled = timed, 0
        else:
            stalled += 1
        passing = np.flatnonzero(found.share > (near * tolerance if np.any(found.share > tolerance) else tolerance))
        if not adds or turn == MOST_ROUNDS or stalled == MOST_STALLED or not len(passing):
            break
        if timed.motion.samples + len(passing) > most:
            break
        time = timed.motion.object.time
        middles = (time[passing] + time[passing + 1]) / 2
        more = between_samples(timed.cell, timed.motion, middles)
        motion = denser(timed.motion, more, np.arange(1, len(middles) + 1, dtype=np.intp))
        timed = _as_before(again(motion), timed, middles)
    if best.excess is None or not best.excess.passes:
        return best
    return replace(best, status=best.status.at_samples)


def with_excess(timed: RetimingResult, worst: Excess) -> RetimingResult:
    """A timing that says its excess, in the time of the given motion and in that of the retimed one.

    Args:
        timed: The timing.
        worst: The excess, in the time of the given motion.
    """
    played = timed.retimed
    if played is not None:
        given, own = timed.motion.object.time, played.motion.object.time
        at = None if worst.time is None else float(np.interp(worst.time, given, own))
        played = replace(played, excess=replace(worst, time=at))
    return replace(timed, excess=worst, retimed=played)


def _as_before(finer: RetimingResult, timed: RetimingResult, added: Array) -> RetimingResult:
    """A timing with more samples that warns of the same."""
    played = finer.retimed
    if played is not None and timed.retimed is not None:
        warnings = moved_remarks(timed.retimed.warnings, timed.motion.object.time, added)
        played = replace(played, warnings=warnings)
    return replace(finer, retimed=played)


def check_held_between(cell: Cell, motion: CoordinatedMotion) -> None:
    """Check that the arms can hold the object between the samples of a motion, where that is in doubt.

    In doubt are few samples, a course that a user wrote, which may go anywhere between them, and steps of joints that
    their velocities do not lead along: a posture that changes there.

    Args:
        cell: The cell.
        motion: Its motion.

    Raises:
        MotionError: If they cannot.
    """
    time = motion.object.time
    doubtful = np.arange(len(time) - 1)
    of_object = motion.object.course
    if motion.samples >= COARSE and (of_object is None or isinstance(of_object, Geodesic | WaypointPath | PoseSplines)):
        h, dq, ddq = np.diff(time)[:, None], motion.dq, motion.ddq
        steps = np.diff(motion.q, axis=0)
        missed = steps - h / 2 * (dq[1:] + dq[:-1]) - h**2 / 12 * (ddq[:-1] - ddq[1:])
        allowed = BENT * np.max(np.abs(steps))
        bent = np.max(np.abs(missed)) > allowed
        doubtful = np.flatnonzero(np.any(np.abs(missed) > allowed, axis=1)) if bent else doubtful[:0]
    if len(doubtful):
        between_samples(cell, motion, (time[doubtful] + time[doubtful + 1]) / 2)


def excess_by_segment(timed: RetimingResult, tolerance: float) -> SegmentExcess:
    """The largest excess inside each segment, where wrenches are free to do their best; its row is named when read.

    Args:
        timed: A timing.
        tolerance: Share of a limit by which it may be overstepped.

    Raises:
        SolverError: If no solver answers.
    """
    cell, motion, pieces, loads = timed.cell, timed.motion, timed.pieces, timed.loads
    sharing = timed.options.sharing
    worst, shares, time = Excess(0.0, tolerance), np.zeros(motion.samples - 1), motion.object.time
    for part in pieces:
        played = between_path_samples(cell, part, PLACES)
        for load in loads:
            share = motion_widening(cell, played, np.ones(played.samples), sharing=sharing, load=load)
            segments = slice(part.piece.first, part.piece.first + len(part.piece.step))
            shares[segments] = np.maximum(shares[segments], _worst_of_each(share))
            most = int(np.argmax(share))
            if share[most] > worst.share:
                segment, place = divmod(most, len(PLACES))
                start, end = time[part.piece.first + segment :][:2]
                at = float(start + PLACES[place] * (end - start))
                named = partial(_overstepped, cell, played.at(np.array([most, most])), sharing, load)
                worst = Excess(float(share[most]), tolerance, at, named)
    return SegmentExcess(shares, worst)


def _worst_of_each(share: Array) -> Array:
    """The largest of the places of each segment, Shape (n - 1,): faster by places than by segments."""
    by_place = np.ascontiguousarray(share.reshape(-1, len(PLACES)).T)
    worst: Array = np.max(by_place, axis=0)
    return worst


def _overstepped(
    cell: Cell, there: CoordinatedMotion, sharing: LoadSharing | None, load: Array | None
) -> ActiveRow | None:
    """The row that a motion oversteps first as it gets faster, at its first sample."""
    rows = motion_ranges(cell, there, "wrench", sharing, DEFAULT_SOLVER, load, 1.0).binding(0, "upper")
    return rows[0] if rows else None
