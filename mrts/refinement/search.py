# SPDX-License-Identifier: MIT
"""Where between the samples a range of c² would be narrower, and which samples must be added for that."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.load_box import LoadPoint
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.coordination.denser_motion import between_samples, denser
from mrts.refinement.doubtful_gaps import doubtful_gaps, turning
from mrts.refinement.excess import Excess
from mrts.samples.sample_problem import SampleProblem
from mrts.samples.sample_ranges import SampleRanges
from mrts.samples.widening import overstepped_row, widening_at
from mrts.solvers import DEFAULT_SOLVER

PLACES = np.array([0.25, 0.5, 0.75])
"""Where each doubtful gap is looked at."""

COARSE = 64
"""Motions of fewer samples are looked at in every gap: neighbours may not show what happens in one."""

MOST_ROUNDS = 24
"""A gap is then 4⁻²⁴ of what it was, beyond `mrts.refinement.doubtful_gaps.RESOLUTION`."""

MOST_PLACES = 8
"""Places that are looked at for each sample of the motion, at most."""

FEWEST_PLACES = 2000
"""As many are allowed in any case."""

NUDGE = 1e-3
"""Share by which c² is moved to see how much a limit widens with it."""

WHAT = "the excess between samples"


@dataclass(frozen=True)
class Asked:
    """What is asked along any motion of a cell.

    Attributes:
        ranges: The ranges of c² along a motion.
        problem: The rows of some samples of a motion, each with a load, Shape (k, 10), or None for the cell's.
    """

    ranges: Callable[[CoordinatedMotion], SampleRanges]
    problem: Callable[[CoordinatedMotion, NDArray[np.intp], Array | None], SampleProblem]

    def widening(self, seen: "Seen", places: NDArray[np.intp], c2: Array) -> Array:
        """By how much all limits must move outward for some c², one a place: Shape (k,)."""
        if not len(places):
            return np.zeros(0)
        problem = self.problem(seen.motion, places, seen.loads(places, c2))
        return widening_at(problem, c2[:, None], DEFAULT_SOLVER, WHAT)


@dataclass(frozen=True)
class Seen:
    """What is known of the ranges of c² at some samples.

    Attributes:
        motion: N samples.
        lower: Shape (N,).
        upper: Shape (N,).
        lower_loads: Loads that set the lower ends; None where the load is known.
        upper_loads: Likewise.
    """

    motion: CoordinatedMotion
    lower: Array
    upper: Array
    lower_loads: Sequence[LoadPoint] | None
    upper_loads: Sequence[LoadPoint] | None

    @classmethod
    def of(cls, motion: CoordinatedMotion, found: SampleRanges) -> "Seen":
        """What ranges tell."""
        return cls(motion, found.lower, found.upper, found.lower_loads, found.upper_loads)

    def ends(self) -> tuple[float, float]:
        """The largest lower and the least upper end."""
        return float(np.max(self.lower)), float(np.min(self.upper))

    def rising(self) -> tuple[Array, Array]:
        """What is largest where the range ends: 1 / c²⁺ and c²⁻, each Shape (N,)."""
        with np.errstate(divide="ignore"):
            return 1 / self.upper, self.lower

    def loads(self, places: NDArray[np.intp], c2: Array) -> Array | None:
        """Loads that forbid some c² at some places, Shape (k, 10)."""
        if self.lower_loads is None or self.upper_loads is None:
            return None
        slow = c2 < self.lower[places]
        return np.array(
            [
                (self.lower_loads if low else self.upper_loads)[place].load
                for low, place in zip(slow, places, strict=True)
            ]
        )

    def and_inside(self, other: "Seen") -> "Seen":
        """These and the inner samples of others."""
        inner = np.arange(1, other.motion.samples - 1, dtype=np.intp)
        order = np.argsort(np.concatenate([self.motion.object.time, other.motion.object.time[inner]]), kind="stable")

        def merged(ours: Sequence[LoadPoint] | None, theirs: Sequence[LoadPoint] | None) -> Sequence[LoadPoint] | None:
            if ours is None or theirs is None:
                return None
            both = [*ours, *(theirs[place] for place in inner.tolist())]
            return [both[place] for place in order.tolist()]

        return Seen(
            denser(self.motion, other.motion, inner),
            np.concatenate([self.lower, other.lower[inner]])[order],
            np.concatenate([self.upper, other.upper[inner]])[order],
            merged(self.lower_loads, other.lower_loads),
            merged(self.upper_loads, other.upper_loads),
        )


@dataclass(frozen=True)
class Refinement:
    """What was found between the samples of a motion.

    Attributes:
        motion: The motion with the samples that had to be added; the given one where none had to.
        seen: All places that were looked at, both ends of the motion included; None if none had to be.
        asked: What was asked there.
        tolerance: Excess that was allowed, as a share of a limit.
        left: A bound of what was not looked at, where there was no end of it.
    """

    motion: CoordinatedMotion
    seen: Seen | None
    asked: Asked
    tolerance: float
    left: Excess | None = field(default=None)

    def excess(self, c2: float) -> Excess:
        """How far limits are overstepped between the samples at a c² that is admissible at all of them."""
        worst = self.left or Excess(0.0, self.tolerance)
        if self.seen is None:
            return worst
        places = np.flatnonzero((self.seen.lower > c2) | (self.seen.upper < c2))
        taken = np.isin(self.seen.motion.object.time[places], self.motion.object.time)
        places = places[~taken]
        share = self.asked.widening(self.seen, places, np.full(len(places), c2))
        if not len(places) or np.max(share) <= worst.share:
            return worst
        most = int(np.argmax(share))
        place, at = places[[most]], np.array([c2])
        problem = self.asked.problem(self.seen.motion, place, self.seen.loads(place, at))
        row = overstepped_row(problem, 0, c2, DEFAULT_SOLVER, WHAT)
        return Excess(float(share[most]), self.tolerance, float(self.seen.motion.object.time[place[0]]), row)


def refine(cell: Cell, motion: CoordinatedMotion, found: SampleRanges, asked: Asked, tolerance: float) -> Refinement:
    """Look between the samples of a motion wherever its range of c² may be narrower, and add what samples that takes.

    The least c²⁺ and the largest c²⁻ along the motion are looked for in the gaps between samples; a place joins the
    samples where limits would have to move outward by more than the tolerance to admit the ends of the range. So the
    ends become those at the worst places, and no other place forbids them.

    Args:
        cell: The cell.
        motion: Its motion.
        found: The ranges at its samples, which have a c² in common.
        asked: How ranges and rows are found at other places.
        tolerance: Share of a limit by which it may be overstepped.

    Raises:
        MotionError: If the arms cannot hold the object between the samples.
        SolverError: If no solver answers.
    """
    everything = Seen.of(motion, found)
    ends = everything.ends()
    if ends[1] <= 0:
        return Refinement(motion, None, asked, tolerance)
    seen: Seen | None = None
    allowed, left = _allowed(everything, asked, tolerance), None
    for turn in range(MOST_ROUNDS):
        everywhere = turn == 0 and (motion.samples < COARSE or allowed is None)
        gaps = _doubtful(everything, allowed, everywhere=everywhere)
        if not len(gaps):
            break
        if len(everything.lower) + len(gaps) * len(PLACES) > max(FEWEST_PLACES, MOST_PLACES * motion.samples):
            left = _left(everything, allowed, tolerance)
            break
        time = everything.motion.object.time
        at = (time[gaps][:, None] + np.diff(time)[gaps][:, None] * PLACES).ravel()
        there = between_samples(cell, motion, at)
        new = Seen.of(there, asked.ranges(there))
        everything = everything.and_inside(new)
        seen = new if seen is None else seen.and_inside(new)
        if not np.all(new.upper > 0):
            break  # nothing moves there: that settles the outcome
        allowed = allowed or _allowed(everything, asked, tolerance)
    if seen is None:
        return Refinement(motion, None, asked, tolerance, left)
    added = _needed(seen, asked, ends, tolerance)
    if len(added):
        motion = denser(motion, seen.motion, added)
    return Refinement(motion, seen, asked, tolerance, left)


def _allowed(known: Seen, asked: Asked, tolerance: float) -> tuple[float, float] | None:
    """By how much 1 / c²⁺ and c²⁻ may rise before a limit is overstepped by the tolerance; None without a c²⁺."""
    low, high = known.ends()
    if not np.isfinite(high):
        return None
    places = np.array([np.argmax(known.lower), np.argmin(known.upper)])
    c2 = np.array([low * (1 - NUDGE), high * (1 + NUDGE)])
    slow, fast = asked.widening(known, places, c2) / NUDGE
    rise = tolerance / fast if fast > 0 else np.inf
    return float(rise / high), float(tolerance / slow * low if slow > 0 else tolerance * high)


def _doubtful(known: Seen, allowed: tuple[float, float] | None, *, everywhere: bool) -> NDArray[np.intp]:
    """Gaps in which an end of the range may lie."""
    time = known.motion.object.time
    if everywhere:
        return np.arange(len(time) - 1)
    if allowed is None:
        return np.zeros(0, dtype=np.intp)
    return np.union1d(*(doubtful_gaps(time, of, most) for of, most in zip(known.rising(), allowed, strict=True)))


def _left(known: Seen, allowed: tuple[float, float] | None, tolerance: float) -> Excess | None:
    """What the range may be narrower by in gaps that were not looked at."""
    time = known.motion.object.time
    step, worst = np.diff(time), Excess(0.0, tolerance)
    for of, most in zip(known.rising(), allowed or (), strict=allowed is not None):
        above = np.maximum(of[:-1], of[1:]) + turning(step, of) - np.max(of)
        gap = int(np.argmax(above))
        share = float(tolerance * above[gap] / most)
        if share > worst.share:
            worst = replace(worst, share=share, time=float(time[gap] + step[gap] / 2))
    return worst


def _needed(seen: Seen, asked: Asked, ends: tuple[float, float], tolerance: float) -> NDArray[np.intp]:
    """Places that must join the samples: where an end would overstep limits by more than the tolerance, the worst."""
    low, high = ends
    added = []
    for c2, forbidden, order in ((high, seen.upper < high, seen.upper), (low, seen.lower > low, -seen.lower)):
        if not np.isfinite(c2):
            places = np.flatnonzero(forbidden)
            added += [places[np.argmin(order[places])]] if len(places) else []
            continue
        places = np.flatnonzero(forbidden)
        share = asked.widening(seen, places, np.full(len(places), c2))
        if len(places) and np.max(share) > tolerance:
            added.append(places[np.argmin(order[places])])
    return np.unique(np.array(added, dtype=np.intp))
