# SPDX-License-Identifier: MIT
"""Where between the samples a range of c² would be narrower, and which samples must be added for that."""

from collections.abc import Callable
from dataclasses import dataclass, replace
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
from mrts.program.sample_ranges import SIDES, SampleRanges, joined

BETWEEN = 1e-4
"""Share of a limit by which it may be overstepped between samples, unless told otherwise."""

LEAST_BETWEEN = 1e-5
"""Least share that can be asked for: joints between samples are known as well as that."""

LARGEST_BETWEEN = 1.0
"""Largest share: twice the limit."""

RowOrFinder = ActiveRow | Callable[[], ActiveRow | None]
"""A limit, or what finds it."""


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
    named: RowOrFinder | None = None

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

Looked = tuple[MotionRows, SampleRanges]
"""Places between the samples: the rows of the motion there and at both ends of the given one, and the ranges at the
places alone."""


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
    motion = given.motion
    known, none = found, Excess(0.0, tolerance)
    if whole[1] <= 0:
        return motion, lambda _c2: none
    looked: Looked | None = None
    allowed, left = _allowed(given, known, tolerance), none
    for turn in range(MOST_ROUNDS):
        everywhere = turn == 0 and (motion.samples < COARSE or allowed is None or found.several)
        gaps = _doubtful(known, allowed, everywhere=everywhere)
        if not len(gaps):
            break
        inside = CLOSE if len(gaps) <= FEW else WIDE
        if len(known.time) + len(gaps) * len(inside) > max(FEWEST_PLACES, MOST_PLACES * motion.samples):
            left = _left(known, allowed, none)
            break
        at = (known.time[gaps][:, None] + np.diff(known.time)[gaps][:, None] * inside).ravel()
        there = between_samples(given.cell, motion, at)
        rows = given.along(there)
        inner = np.arange(1, there.samples - 1, dtype=np.intp)
        new = ranges(rows).at(inner)
        known = joined(known, new)
        if looked is not None:
            rows = given.along(denser(looked[0].motion, there, inner))
            new = joined(looked[1], new)
        looked = rows, new
        if not (new.upper > 0).all():
            break  # nothing moves there: that settles the outcome
        allowed = allowed or _allowed(rows, new, tolerance, first=1)
    if looked is None:
        return motion, lambda _c2: left
    added, left = _needed(looked, whole, left)
    if len(added):
        motion = denser(motion, looked[0].motion, added + 1)
    return motion, partial(_excess, looked, left, whole)


def _excess(looked: Looked, left: Excess, whole: tuple[float, float], c2: float) -> Excess:
    """How far limits are overstepped at a c², given what is left at the ends of the range."""
    if c2 in whole:
        return left
    worst = left if left.passes else Excess(0.0, left.tolerance)
    return _worse(worst, looked[1], *_overstepped(looked, (c2, c2)))


def _loads(known: SampleRanges, side: NDArray[np.intp], places: NDArray[np.intp]) -> Array | None:
    """Loads that set the lower (0) or the upper end (1) at k places, Shape (k, 10); None where the load is known."""
    if known.loads is None:
        return None
    return np.array([known.loads[end][place].load for end, place in zip(side.tolist(), places.tolist(), strict=True)])


def _overstepped(looked: Looked, ends: tuple[float, float]) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Where the range at a place does not reach the lower (0) or the upper one (1) of two c², and by how much.

    Outside of the interval that is known a c² may lie in another where there are several.

    Returns:
        Sides and places, and by how much limits must move for that c² there, each Shape (k,); of finite ones.
    """
    rows, known = looked
    c2 = np.reshape(ends, (2, 1))
    above, below = known.lower > c2, known.upper < c2
    beyond = np.array([above[0], below[1]]) | (known.gaps & (above | below))
    side, places = np.nonzero(beyond & np.isfinite(c2))
    share = motion_widening(rows, c2[side, 0], _loads(known, side, places), places + 1)
    return side, places, share


def _worse(
    worst: Excess, known: SampleRanges, side: NDArray[np.intp], places: NDArray[np.intp], share: Array
) -> Excess:
    """The worst of `_overstepped`, if it is more."""
    if share.max(initial=0.0) <= worst.share:
        return worst
    most = int(np.argmax(share))
    place = int(places[most])
    rows = known.binding(place, SIDES[side[most]])
    return Excess(float(share[most]), worst.tolerance, float(known.time[place]), rows[0] if rows else None)


def _allowed(rows: MotionRows, known: SampleRanges, tolerance: float, first: int = 0) -> tuple[float, float] | None:
    """By how much 1 / c²⁺ and c²⁻ may rise before a limit is overstepped by the tolerance; None without a c²⁺."""
    low, high = float(known.lower.max()), float(known.upper.min())
    if not np.isfinite(high):
        return None
    places = np.array([np.argmax(known.lower), np.argmin(known.upper)])
    c2 = np.array([low * (1 - NUDGE), high * (1 + NUDGE)])
    slow, fast = motion_widening(rows, c2, _loads(known, np.arange(2), places), places + first) / NUDGE
    rise = tolerance / fast if fast > 0 else np.inf
    return float(rise / high), float(tolerance / slow * low if slow > 0 else tolerance * high)


def _doubtful(known: SampleRanges, allowed: tuple[float, float] | None, *, everywhere: bool) -> NDArray[np.intp]:
    """Gaps in which an end of the range may lie."""
    if everywhere:
        return np.arange(len(known.time) - 1)
    if allowed is None:
        return np.zeros(0, dtype=np.intp)
    beyond = (_possible_rises(known) > np.array(allowed)[:, None]).any(axis=0)
    return np.flatnonzero(beyond & (known.time[1:] - known.time[:-1] > RESOLUTION * known.time[-1]))


def _possible_rises(known: SampleRanges) -> Array:
    """By how much 1 / c²⁺ and c²⁻ may exceed their largest sample in each gap between N >= 2, Shape (2, N - 1).

    A quantity that turns inside a gap, smoothly or at a corner, lies above its samples by at most a quarter of the gap
    times the change of slope around it.
    """
    with np.errstate(divide="ignore"):
        both = np.array([1 / known.upper, known.lower])
    step = known.time[1:] - known.time[:-1]
    slope = (both[:, 1:] - both[:, :-1]) / step
    change = np.abs(slope[:, 1:] - slope[:, :-1])
    if len(step) == 1:
        return np.full((2, 1), np.inf)
    around = np.concatenate([change[:, :1], change], axis=1) + np.concatenate([change, change[:, -1:]], axis=1)
    rises: Array = np.maximum(both[:, :-1], both[:, 1:]) + step * around / 4 - both.max(axis=1, keepdims=True)
    return rises


def _left(known: SampleRanges, allowed: tuple[float, float] | None, none: Excess) -> Excess:
    """What may be overstepped in the gap that is most doubtful."""
    share = none.tolerance * _possible_rises(known) / np.reshape(allowed or (np.inf, np.inf), (2, 1))
    gap = int(np.argmax(np.max(share, axis=0)))
    if not np.max(share) > 0:
        return none
    return replace(none, share=float(np.max(share)), time=float(known.time[gap : gap + 2].mean()))


def _needed(looked: Looked, whole: tuple[float, float], left: Excess) -> tuple[NDArray[np.intp], Excess]:
    """Places that must join the samples, the worst where an end oversteps limits too far, and what is left then."""
    known, added = looked[1], set[int]()
    sides, found, shares = _overstepped(looked, whole)
    for side, (c2, order) in enumerate(zip(whole, (-known.lower, known.upper), strict=True)):
        own = sides == side
        places, share = found[own], shares[own]
        if not np.isfinite(c2):
            added |= {int(np.argmin(order))} if np.isfinite(np.min(order)) else set()
        elif share.max(initial=0.0) > left.tolerance:
            added.add(int(places[np.argmin(order[places])]))
            if known.several:
                added.add(int(places[np.argmax(share)]))
        else:
            left = _worse(left, known, sides[own], places, share)
    return np.array(sorted(added), dtype=np.intp), left
