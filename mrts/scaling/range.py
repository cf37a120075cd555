# SPDX-License-Identifier: MIT
"""The admissible range of c² over the whole motion: the intersection of the ranges of all samples."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from mrts.base.load_box import LoadPoint
from mrts.base.words import interval_text
from mrts.limits.rows import RATES, ActiveRow, Side, row_labels, rows_text
from mrts.program.range_ends import MOST_INTERVALS
from mrts.program.range_status import RangeStatus
from mrts.program.sample_ranges import POINT_TOLERANCE, SIDES, SampleRanges, first_least


@dataclass(frozen=True)
class RangeEnd:
    """One end of the range over the motion.

    Attributes:
        c2: Its value; infinity if nothing limits it.
        sample: Where it is reached, None if nothing limits it.
        time: Of that sample [s], None if nothing limits it.
        named: The rows that bind there, or what finds them: to name all of them takes linear programs.
        load: The load that sets it, if the load is uncertain.
    """

    c2: float
    sample: int | None
    time: float | None
    named: tuple[ActiveRow, ...] | Callable[[], tuple[ActiveRow, ...]] = field(default=(), repr=False, compare=False)
    load: LoadPoint | None = None

    @cached_property
    def rows(self) -> tuple[ActiveRow, ...]:
        """The rows that bind there."""
        return self.named() if callable(self.named) else self.named

    def to_json(self) -> dict[str, Any] | None:
        """Entry of "binding" in the JSON result; None if nothing limits this end."""
        if self.time is None:
            return None
        entry: dict[str, Any] = {"time": self.time, "rows": [row.to_json() for row in self.rows]}
        return entry if self.load is None else entry | {"load": self.load.to_json()}

    def place(self) -> str:
        """When, with which load and by which rows this end is set, in words."""
        of_load = self.load is not None and any(row.name.of_load for row in self.rows)
        load = f" with {self.load}" if of_load else ""
        return f"at t = {self.time:.4g} s{load} by {rows_text(self.rows)}"


@dataclass(frozen=True, repr=False)
class ScalingRange:
    """The range over the whole motion.

    Attributes:
        status: The outcome.
        lower: c²⁻, None if infeasible.
        upper: c²⁺, None if infeasible. Empty if below `lower`.
        samples: The ranges that were intersected.
    """

    status: RangeStatus
    lower: RangeEnd | None
    upper: RangeEnd | None
    samples: SampleRanges

    @property
    def c2_upper(self) -> float:
        """c²⁺; infinity if nothing limits it, minus infinity if no c² is admissible."""
        return self.upper.c2 if self.upper is not None and self.status.admits_motion else -np.inf

    def __repr__(self) -> str:
        ends = f"c² ∈ {self.text()}, " if self.lower and self.upper else ""
        return f"<ScalingRange {self.status.value}: {ends}{len(self.samples.time)} samples>"

    def text(self, digits: int = 4) -> str:
        """Both ends in words, such as `[0, 3.062]`; empty where there are none."""
        return interval_text(self.lower.c2, self.upper.c2, digits=digits) if self.lower and self.upper else ""

    def admitted(self, c2: float, tolerance: float) -> float | None:
        """The c² of the range that a given one stands for: itself, or the end that it misses by a share; else None."""
        if not self.status.admits_motion or self.lower is None or self.upper is None:
            return None
        low, high = self.lower.c2, self.upper.c2
        return min(max(c2, low), high) if low * (1 - tolerance) <= c2 <= high * (1 + tolerance) else None

    def ends_at(self, c2: float, tolerance: float = 0.0) -> Iterator[tuple[Side, RangeEnd]]:
        """The ends at which a c² is, to a share of an end, and of which side each is; not those that nothing sets."""
        ends: tuple[tuple[Side, RangeEnd | None], ...] = (("lower", self.lower), ("upper", self.upper))
        for side, end in ends if self.status.admits_motion else ():
            if end is not None and end.time is not None and abs(c2 - end.c2) <= tolerance * end.c2:
                yield side, end

    def binding(self, sample: int, side: Side) -> tuple[ActiveRow, ...]:
        """Rows that bind at one end of a sample; all of them where it sets the range."""
        end = self.lower if side == "lower" else self.upper
        own = float((self.samples.lower if side == "lower" else self.samples.upper)[sample])
        sets = end is not None and end.sample == sample and end.c2 == own
        return end.rows if end is not None and sets else self.samples.binding(sample, side)

    def to_json(self) -> dict[str, Any]:
        """Status, both ends and what sets them; None stands for an end that does not exist."""
        ends = {"lower": self.lower, "upper": self.upper}
        return {
            "status": self.status.value,
            "c2": {side: end.c2 if end and np.isfinite(end.c2) else None for side, end in ends.items()},
            "binding": {side: end.to_json() if end else None for side, end in ends.items()},
        }

    def reason(self) -> str:
        """Why no c² is admissible, in a few words; empty if some is."""
        conflicts = self.samples.conflicts
        if self.status is RangeStatus.INFEASIBLE:
            worst = max(conflicts, key=lambda conflict: conflict.widening)
            where = f"at {len(conflicts)} of {len(self.samples.time)} samples"
            return f"{where}; at t = {worst.time:.4g} s{worst.with_load} {row_labels(worst.rows)} conflict"
        return self._contradiction().rstrip(".")

    def explain(self) -> str:
        """Why no c² is admissible (the message of step 3.2); empty if some is."""
        conflicts, text = self.samples.conflicts, self._contradiction()
        if self.status is RangeStatus.INFEASIBLE:
            worst = max(conflicts, key=lambda conflict: conflict.widening)
            text = f"{len(conflicts)} of {len(self.samples.time)} samples are infeasible. The worst: {worst}."
        elif text and self.samples.several:
            text += " Of several intervals of a sample its highest is meant: lower ones have nothing in common either."
        return text and f"{text} {self.status.advice}"

    def _contradiction(self) -> str:
        """Why no c² is in all ranges: the least of one sample is above the largest of another; empty if some is."""
        slow, fast = self.lower, self.upper
        if self.status is not RangeStatus.EMPTY or slow is None or fast is None:
            return ""
        text = f"c² must be at least {slow.c2:.6g} {slow.place()}, but at most {fast.c2:.6g} {fast.place()}."
        rated = any(row.name.kind in RATES for row in (*slow.rows, *fast.rows))
        return f"a rate is too small: {text}" if rated else text


def intersect(samples: SampleRanges) -> ScalingRange:
    """Eq. (30): the intersection of the ranges of all samples (step 2 of MMTSF)."""
    if samples.conflicts:
        return ScalingRange(RangeStatus.INFEASIBLE, None, None, samples)
    at_low, at_high = int(first_least(-samples.lower)), int(first_least(samples.upper))
    low, high = float(np.max(samples.lower)), float(np.min(samples.upper))
    ends = []
    for side, sample, c2 in zip(SIDES, (at_low, at_high), (low, high), strict=True):
        rows, load = partial(samples.all_binding, sample, side), samples.load_at(sample, side)
        named = RangeEnd(c2, sample, float(samples.time[sample]), rows, load)
        ends.append(named if np.isfinite(c2) else RangeEnd(c2, None, None))
    return range_between(ends[0], ends[1], samples)


def range_between(lower: RangeEnd, upper: RangeEnd, samples: SampleRanges) -> ScalingRange:
    """The range between two ends; what rounding turned inside out is a point."""
    if upper.c2 < lower.c2 <= upper.c2 * (1 + POINT_TOLERANCE):
        lower = replace(lower, c2=upper.c2)
    status = RangeStatus.UNBOUNDED if np.isinf(upper.c2) else RangeStatus.FEASIBLE
    return ScalingRange(RangeStatus.EMPTY if lower.c2 > upper.c2 else status, lower, upper, samples)


def common_range(find: Callable[[float], SampleRanges], high: float = np.inf) -> ScalingRange:
    """The highest interval of c² that all samples admit, of those that do not begin above a c².

    Where intervals of single samples lie above what all others admit, their next lower ones are looked at.

    Returns:
        Where the samples have nothing in common: an empty range, of their highest intervals.
    """
    first = found = find(high)
    for _ in range(MOST_INTERVALS):
        top = float(np.min(found.upper)) * (1 + POINT_TOLERANCE)
        if not found.several or found.conflicts or not np.any(found.lower > top):
            return intersect(found)
        found = find(top)
        if np.any(found.lower > top):
            break
    return intersect(first)
