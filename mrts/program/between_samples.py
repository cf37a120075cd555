# SPDX-License-Identifier: MIT
"""Where between the samples a range of c² would be narrower, and which samples must be added for that."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, is_number
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import between_samples, denser
from mrts.limits.rows import ActiveRow
from mrts.program.infeasibility import motion_widening
from mrts.program.motion_rows import MotionRows
from mrts.program.sample_ranges import SIDES, SampleRanges

BETWEEN = 1e-4
"""Share of a limit by which it may be overstepped between samples, unless told otherwise."""

LEAST_BETWEEN = 1e-5
"""Least share that can be asked for: joints between samples are known as well as that."""

LARGEST_BETWEEN = 1.0
"""Largest share: twice the limit."""


@dataclass(frozen=True)
class Excess:
    """The worst excess over a limit between samples, with the best distribution of the torques there.

    Attributes:
        share: Excess as a share of the limit; 0 if all are kept.
        tolerance: What was allowed.
        time: When that is, in the time of the given motion [s]; None if all limits are kept.
        named: The limit that is overstepped most, or what finds it; None likewise.
    """

    share: float
    tolerance: float
    time: float | None = None
    named: ActiveRow | Callable[[], ActiveRow | None] | None = None

    @cached_property
    def row(self) -> ActiveRow | None:
        """The limit that is overstepped most, found when it is asked for; None if all are kept."""
        return self.named() if callable(self.named) else self.named

    @property
    def passes(self) -> bool:
        """Whether it is more than was allowed."""
        return self.share > self.tolerance

    def __str__(self) -> str:
        where = "" if self.time is None else f" at t = {self.time:.4g} s"
        row = "" if self.row is None else f", {self.row}"
        return f"between the samples limits are overstepped by up to {100 * self.share:.2g} %{where}{row}"

    def to_json(self) -> dict[str, Any]:
        """Entry of "excess" in the JSON result."""
        row = None if self.row is None else self.row.to_json()
        return {"share": self.share, "tolerance": self.tolerance, "time": self.time, "row": row}


def checked_tolerance(between: object) -> float | None:
    """A tolerance between samples, None for none.

    Raises:
        InputError: If it is neither None nor a number that can be kept.
    """
    if between is None:
        return None
    if not is_number(between, LEAST_BETWEEN, LARGEST_BETWEEN):
        rule = f"must be a share of a limit from {LEAST_BETWEEN:g} to {LARGEST_BETWEEN:g}, or None (off)."
        raise InputError("between", rule, value=between)
    return float(between)  # type: ignore[arg-type]  # is_number has seen to it


WIDE, CLOSE = np.arange(1, 4) / 4, np.arange(1, 8) / 8
"""Where each doubtful gap is looked at, of many and of few."""

FEW = 8
"""So many doubtful gaps are few."""

COARSE = 64
"""Motions of fewer samples are looked at in every gap: neighbours may not show what happens in one."""

MOST_ROUNDS = 24
"""A gap is then 4⁻²⁴ of what it was, beyond `RESOLUTION`."""

RESOLUTION = 1e-6
"""Share of the duration below which no two samples are told apart: what jumps there has been seen on both sides."""

MOST_PLACES = 8
"""Places that are looked at for each sample of the motion, at most."""

FEWEST_PLACES = 2000
"""As many are allowed in any case."""

NUDGE = 1e-3
"""Share by which c² is moved to see how much a limit widens with it."""

Ranges = Callable[[MotionRows], SampleRanges]
"""The ranges of c² along a motion, of intervals that do not begin above the end of the range."""

Looked = list[tuple[MotionRows, SampleRanges]]
"""Places between the samples, round by round: the rows there and at both ends of the motion, and the ranges."""


def refine(
    given: MotionRows, found: SampleRanges, whole: tuple[float, float], ranges: Ranges, tolerance: float
) -> tuple[CoordinatedMotion, Callable[[float], Excess]]:
    """Look between the samples of a motion wherever its range of c² may be narrower, and add what samples that takes.

    The least c²⁺ and the largest c²⁻ along the motion are looked for in the gaps between samples; a place joins the
    samples where limits would have to move outward by more than the tolerance to admit the ends of the range, c²⁻ and
    c²⁺ as `whole`. So the ends become those at the worst places, and no other place forbids them.

    Returns:
        The motion with the samples that had to be added, the given one where none had to; and what tells how far limits
        are overstepped between the samples at a c² that is admissible at all of them.

    Raises:
        MotionError: If the arms cannot hold the object between the samples.
    """
    motion, left, looked = given.motion, Excess(0.0, tolerance), Looked()
    if whole[1] <= 0:
        return motion, lambda _c2: left
    known, allowed = np.array([found.time, found.lower, found.upper]), _allowed(given, found, tolerance)
    for turn in range(MOST_ROUNDS):
        time, doubt = known[0], _doubt(known, allowed)
        if turn == 0 and (motion.samples < COARSE or allowed is None or found.several):
            gaps = np.arange(len(doubt))
        else:
            gaps = ((doubt > 1) & (time[1:] - time[:-1] > RESOLUTION * time[-1])).nonzero()[0]
        if not len(gaps):
            break
        inside = CLOSE if len(gaps) <= FEW else WIDE
        if len(time) + len(gaps) * len(inside) > max(FEWEST_PLACES, MOST_PLACES * motion.samples):
            worst = int(np.argmax(doubt))
            left = Excess(tolerance * float(doubt[worst]), tolerance, float(time[worst : worst + 2].mean()))
            break
        at = time[gaps, None] + (time[gaps + 1] - time[gaps])[:, None] * inside
        rows = given.along(between_samples(given.cell, motion, at.ravel()))
        new = ranges(rows)
        looked.append((rows, new))
        known = np.concatenate([known, np.array([new.time, new.lower, new.upper])[:, 1:-1]], axis=1)
        known = known[:, known[0].argsort(kind="stable")]
        if not (new.upper > 0).all():
            break  # nothing moves there: that settles the outcome
        allowed = allowed or _allowed(rows, new, tolerance)
    if looked:
        added, left = _needed(looked, whole, left)
        for rows, _ in looked:
            own, added = np.split(added, [rows.motion.samples])
            if own.any():
                motion = denser(motion, rows.motion, own.nonzero()[0])
    return motion, partial(_excess, looked, left, whole)


def _excess(looked: Looked, left: Excess, whole: tuple[float, float], c2: float) -> Excess:
    """How far limits are overstepped at a c², given what is left at the ends of the range."""
    if c2 in whole:
        return left
    worst = left if left.passes else Excess(0.0, left.tolerance)
    for rows, ranges in looked:
        worst = _worse(worst, ranges, _overstepped(rows, ranges, (c2, c2)))
    return worst


def _loads(known: SampleRanges, side: NDArray[np.intp], places: NDArray[np.intp]) -> Array | None:
    """Loads that set the lower (0) or the upper end (1) at k places, Shape (k, 10); None where the load is known."""
    if known.loads is None:
        return None
    return np.array([known.loads[end][place].load for end, place in zip(side.tolist(), places.tolist(), strict=True)])


def _overstepped(rows: MotionRows, known: SampleRanges, ends: tuple[float, float]) -> Array:
    """By how much limits must move for two c² at each of n places, Shape (2, n); 0 of one that is not finite.

    Looked at is where the range of a place does not reach the lower or the upper one; outside of the interval that is
    known a c² may lie in another where there are several.
    """
    c2 = np.reshape(ends, (2, 1))
    above, below = known.lower > c2, known.upper < c2
    beyond = (np.array([above[0], below[1]]) | (known.gaps & (above | below))) & np.isfinite(c2)
    beyond[:, [0, -1]] = False  # samples of the motion
    (side, places), share = beyond.nonzero(), np.zeros(beyond.shape)
    share[side, places] = motion_widening(rows, c2[side, 0], _loads(known, side, places), places)
    return share


def _worse(worst: Excess, known: SampleRanges, share: Array) -> Excess:
    """The worst of `_overstepped`, if it is more."""
    side, place = divmod(int(share.argmax()), share.shape[1])
    if share[side, place] <= worst.share:
        return worst
    rows = known.binding(place, SIDES[side])
    return Excess(float(share[side, place]), worst.tolerance, float(known.time[place]), rows[0] if rows else None)


def _allowed(rows: MotionRows, known: SampleRanges, tolerance: float) -> tuple[float, float] | None:
    """By how much 1 / c²⁺ and c²⁻ may rise before a limit is overstepped by the tolerance; None without a c²⁺."""
    low, high = float(known.lower.max()), float(known.upper.min())
    if not np.isfinite(high):
        return None
    places = np.array([known.lower.argmax(), known.upper.argmin()])
    c2 = np.array([low * (1 - NUDGE), high * (1 + NUDGE)])
    slow, fast = motion_widening(rows, c2, _loads(known, np.arange(2), places), places) / NUDGE
    rise = tolerance / fast if fast > 0 else np.inf
    return float(rise / high), float(tolerance / slow * low if slow > 0 else tolerance * high)


def _doubt(known: Array, allowed: tuple[float, float] | None) -> Array:
    """How far an end may lie beyond all samples in each gap, as a multiple of what is allowed; 0 without a c²⁺.

    A quantity that turns inside a gap, smoothly or at a corner, lies above its samples by at most a quarter of the gap
    times the change of slope around it. `known` are times, c²⁻ and c²⁺ of N >= 2 samples, Shape (3, N).
    """
    time, lower, upper = known
    step = time[1:] - time[:-1]
    if allowed is None or len(step) == 1:
        return np.full(len(step), 0.0 if allowed is None else np.inf)
    both = np.array([1 / upper, lower])
    slope = (both[:, 1:] - both[:, :-1]) / step
    change = np.abs(slope[:, 1:] - slope[:, :-1])
    around = np.concatenate([change[:, :1], change], axis=1) + np.concatenate([change, change[:, -1:]], axis=1)
    rises = np.maximum(both[:, :-1], both[:, 1:]) + step * around / 4 - both.max(axis=1, keepdims=True)
    doubt: Array = (rises / np.reshape(allowed, (2, 1))).max(axis=0)
    return doubt


def _needed(looked: Looked, whole: tuple[float, float], left: Excess) -> tuple[NDArray[np.bool_], Excess]:
    """Which places must join the samples, the worst where an end oversteps limits too far, and what is left then."""
    shares = [_overstepped(rows, known, whole) for rows, known in looked]
    order = np.concatenate([(-known.lower, known.upper) for _, known in looked], axis=1)
    share, kept, added = np.concatenate(shares, axis=1), np.ones((2, 1)), np.zeros(order.shape[1], dtype=bool)
    for side, c2 in enumerate(whole):
        if share[side].max() > left.tolerance:
            kept[side] = 0.0
            added[np.where(share[side] > 0, order[side], np.inf).argmin()] = True
            if any(known.several for _, known in looked):
                added[share[side].argmax()] = True
        elif not np.isfinite(c2) and np.isfinite(order[side].min()):
            added[order[side].argmin()] = True
    for (_, known), own in zip(looked, shares, strict=True):
        left = _worse(left, known, kept * own)
    return added, left
