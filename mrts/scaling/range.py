# SPDX-License-Identifier: MIT
"""The admissible range of c² over the whole motion: the intersection of the ranges of all samples."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from mrts.base.interval_text import interval_text
from mrts.base.load_box import LoadPoint
from mrts.base.notebook.in_notebooks import InNotebooks, NotebookTable
from mrts.limits.rows import ActiveRow, Side
from mrts.samples.end_rows import RowsWhenAsked
from mrts.samples.range_ends import Gap, pieces
from mrts.samples.range_status import RangeStatus
from mrts.samples.sample_ranges import POINT_TOLERANCE, SampleRanges, first_least
from mrts.scaling.result_tables import range_ends

if TYPE_CHECKING:
    from mrts.smooth.constant_rates import RatedFactors, RatesAtEnd

RATES = {"torque rate", "wrench rate", "jerk"}
"""Kinds of rows that limit how fast something changes."""

SPEEDS = {"velocity", "motor speed"}
"""Kinds of rows that a load does not move."""

LOST_WITH_SPEED = "what motors lose with the speed (viscous friction, torque-speed curves)"
"""What gaps between intervals are from: inertia makes up for it at a higher speed only."""


@dataclass(frozen=True)
class RangeEnd(InNotebooks):
    """One end of the range over the motion.

    Attributes:
        c2: Its value; infinity if nothing limits it.
        sample: Where it is reached, None if nothing limits it.
        time: Of that sample [s], None if nothing limits it.
        rows: Rows that bind there.
        load: The load that sets it, if the load is uncertain.
    """

    c2: float
    sample: int | None
    time: float | None
    rows: Sequence[ActiveRow]
    load: LoadPoint | None = None

    def to_json(self) -> dict[str, Any] | None:
        """Entry of "binding" in the JSON result; None if nothing limits this end."""
        if self.time is None:
            return None
        entry: dict[str, Any] = {"time": self.time, "rows": [row.to_json() for row in self.rows]}
        return entry if self.load is None else entry | {"load": self.load.to_json()}

    def place(self) -> str:
        """When, with which load and by which rows this end is set, in words."""
        of_load = self.load is not None and any(row.name.kind not in SPEEDS for row in self.rows)
        load = f" with {self.load}" if of_load else ""
        return f"at t = {self.time:.4g} s{load} by {', '.join(str(row) for row in self.rows)}"


@dataclass(frozen=True, repr=False)
class ScalingRange(InNotebooks):
    """The range over the whole motion.

    Attributes:
        status: The outcome.
        lower: c²⁻, None if infeasible.
        upper: c²⁺, None if infeasible. Empty if below `lower`.
        samples: The ranges that were intersected.
        intervals: Ends of all intervals of admissible c², ascending; none where no c² is admissible. There are several
            only where viscous friction or a motor's torque-speed curve stand beside inertia that helps; `lower` and
            `upper` are then the ends of the last one, of the largest speeds.
    """

    status: RangeStatus
    lower: RangeEnd | None
    upper: RangeEnd | None
    samples: SampleRanges
    intervals: tuple[tuple[RangeEnd, RangeEnd], ...] = ()

    def __repr__(self) -> str:
        ends = f"c² ∈ {self.text()}, " if self.lower and self.upper else ""
        return f"<ScalingRange {self.status.value}: {ends}{len(self.samples.time)} samples>"

    def notebook_tables(self) -> Iterator[NotebookTable]:
        """Both ends and what sets them."""
        yield range_ends(self)

    def notebook_words(self) -> list[str]:
        """The outcome."""
        return [repr(self).strip("<>"), *filter(None, [self.explain()])]

    def text(self, digits: int = 4) -> str:
        """All intervals in words, such as `[0, 3.062]` or `[0, 0.51] or [1.2, 3.062]`; empty where there are no ends.

        Args:
            digits: Significant digits.
        """
        if self.intervals:
            return " or ".join(interval_text(low.c2, high.c2, digits=digits) for low, high in self.intervals)
        return interval_text(self.lower.c2, self.upper.c2, digits=digits) if self.lower and self.upper else ""

    def admitted(self, c2: float, tolerance: float) -> float | None:
        """The admissible c² that a given one stands for: itself, or the end that it misses by rounding; else None.

        Args:
            c2: c².
            tolerance: Share of an end that is rounding.
        """
        for low, high in self.intervals:
            if low.c2 * (1 - tolerance) <= c2 <= high.c2 * (1 + tolerance):
                return min(max(c2, low.c2), high.c2)
        return None

    def ends_at(self, c2: float, tolerance: float = 0.0) -> Iterator[tuple[Side, RangeEnd]]:
        """The ends of all intervals at which a c² is, and of which side each is; not those that nothing sets.

        Args:
            c2: c².
            tolerance: Share of an end that is rounding.
        """
        sides: tuple[Side, Side] = ("lower", "upper")
        for pair in self.intervals:
            for side, end in zip(sides, pair, strict=True):
                if end.time is not None and abs(c2 - end.c2) <= tolerance * end.c2:
                    yield side, end

    def to_json(self) -> dict[str, Any]:
        """Status, both ends, all intervals and what sets them; None stands for an end that does not exist."""
        ends = {"lower": self.lower, "upper": self.upper}
        return {
            "status": self.status.value,
            "c2": {side: end.c2 if end and np.isfinite(end.c2) else None for side, end in ends.items()},
            "intervals": [[end.c2 if np.isfinite(end.c2) else None for end in pair] for pair in self.intervals],
            "binding": {side: end.to_json() if end else None for side, end in ends.items()},
        }

    def explain(self) -> str:
        """Why no c² is admissible (the message of step 3.2); empty if some is."""
        if self.status is RangeStatus.INFEASIBLE:
            conflicts = self.samples.conflicts
            worst = max(conflicts, key=lambda conflict: conflict.widening)
            text = f"{len(conflicts)} of {len(self.samples.time)} samples are infeasible. The worst: {worst}."
        elif self.status is RangeStatus.EMPTY and (exclusions := self._exclusions()):
            text = exclusions
        elif self.status is RangeStatus.EMPTY and self.lower and self.upper:
            text = contradiction(self.lower, self.upper)
        else:
            return ""
        return f"{text} {self.status.advice}"

    def _exclusions(self) -> str:
        """Which gaps of single samples leave nothing of what lies between all samples' ends; empty if no gap does."""
        lower, upper = float(np.max(self.samples.lower)), float(np.min(self.samples.upper))
        covering: list[Gap] = []
        reached = lower
        while reached <= upper:
            reaching = [gap for gap in self.samples.gaps if gap.lower <= reached < gap.upper]
            if not reaching:
                return ""
            covering.append(max(reaching, key=lambda gap: gap.upper))
            reached = covering[-1].upper
        parts = [f"none from {gap.lower:.6g} to {gap.upper:.6g} {gap_place(self.samples, gap)}" for gap in covering]
        return (
            f"of c² ∈ {interval_text(lower, upper)} single samples leave nothing: {'; '.join(parts)}." if parts else ""
        )


class RangeWhenAsked(ScalingRange):
    """A range that is found when something of it is read.

    Args:
        find: Finds it.
        known: Fields of a range that is known, as `dataclasses.replace` gives them.
    """

    def __init__(self, find: Callable[[], ScalingRange] | None = None, **known: Any) -> None:
        vars(self).update({"found": ScalingRange(**known)} if find is None else {"find": find})

    @cached_property
    def found(self) -> ScalingRange:
        """The range.

        Raises:
            SolverError: If no solver answers.
        """
        found: ScalingRange = vars(self)["find"]()
        return found

    def __eq__(self, other: object) -> bool:
        return self.found == (other.found if isinstance(other, RangeWhenAsked) else other)

    def __hash__(self) -> int:
        return hash(self.found)


for _field in fields(ScalingRange):
    setattr(RangeWhenAsked, _field.name, property(attrgetter(f"found.{_field.name}")))


def contradiction(slow: RangeEnd, fast: RangeEnd) -> str:
    """Why no c² is in all ranges, where the least of one sample is above the largest of another.

    Args:
        slow: The least c².
        fast: The largest.
    """
    text = f"c² must be at least {slow.c2:.6g} {slow.place()}, but at most {fast.c2:.6g} {fast.place()}."
    rated = any(row.name.kind in RATES for row in (*slow.rows, *fast.rows))
    return f"a rate is too small: {text}" if rated else text


def gap_place(samples: SampleRanges, gap: Gap) -> str:
    """When a gap is, and which rows set its ends, in words.

    Args:
        samples: Of which it is one.
        gap: The gap.
    """
    slower, faster = (", ".join(str(row) for row in rows) for rows in (gap.lower_rows, gap.upper_rows))
    load = f" with {gap.upper_load}" if gap.upper_load else ""
    return f"at t = {samples.time[gap.sample]:.4g} s{load} (from below by {slower}; from above by {faster})"


def intersect(samples: SampleRanges) -> ScalingRange:
    """Eq. (30): the intersection of the ranges of all samples (step 2 of MMTSF).

    Args:
        samples: Ranges of all samples.
    """
    if samples.conflicts:
        return ScalingRange(RangeStatus.INFEASIBLE, None, None, samples)
    at_low, at_high = int(first_least(-samples.lower)), int(first_least(samples.upper))
    low, high = float(np.max(samples.lower)), float(np.min(samples.upper))
    if high < low <= high * (1 + POINT_TOLERANCE):
        low = high
    lower = _end(samples, at_low, low, samples.lower_rows, samples.lower_loads)
    if np.isinf(high):
        upper = RangeEnd(high, None, None, ())
    else:
        upper = _end(samples, at_high, high, samples.upper_rows, samples.upper_loads)
    if low > high:
        return ScalingRange(RangeStatus.EMPTY, lower, upper, samples)
    if not samples.gaps:
        intervals: tuple[tuple[RangeEnd, RangeEnd], ...] = ((lower, upper),)
    else:
        intervals = tuple(
            (
                lower if piece.after is None else _end_of_gap(samples, piece.after, "upper"),
                upper if piece.before is None else _end_of_gap(samples, piece.before, "lower"),
            )
            for piece in pieces(low, high, samples.gaps)
        )
    if not intervals:  # from the end of the highest gap on c² would do again
        last = max((gap for gap in samples.gaps if gap.lower < high), key=lambda gap: gap.upper)
        return ScalingRange(RangeStatus.EMPTY, _end_of_gap(samples, last, "upper"), upper, samples)
    status = RangeStatus.UNBOUNDED if np.isinf(intervals[-1][1].c2) else RangeStatus.FEASIBLE
    return ScalingRange(status, *intervals[-1], samples, intervals)


def within_rates(
    found: ScalingRange, factors: "RatedFactors", loads: Sequence[LoadPoint | None] = (None,)
) -> ScalingRange:
    """What limits of rates leave of a range that admits motion: the ends of every interval, which they move inward.

    Args:
        found: The range.
        factors: What the rates admit.
        loads: Those of the factors; None where the load is known.
    """

    def end(at: "RatesAtEnd") -> RangeEnd:
        load = None if at.load is None else loads[at.load]
        return RangeEnd(at.c2, at.sample, float(found.samples.time[at.sample]), at.rows, load)

    kept: list[tuple[RangeEnd, RangeEnd]] = []
    refused: tuple[RangeEnd, RangeEnd] | None = None
    for low, high in reversed(found.intervals):
        c2, fast = factors.fastest(low.c2, high.c2)
        top = high if fast is None else end(fast)
        if c2 < low.c2:
            refused = refused or (low, top)
            continue
        _, slow = factors.slowest(low.c2, c2)
        kept.insert(0, (low if slow is None else end(slow), top))
    if kept:
        status = RangeStatus.UNBOUNDED if np.isinf(kept[-1][1].c2) else RangeStatus.FEASIBLE
        return ScalingRange(status, *kept[-1], found.samples, tuple(kept))
    assert refused is not None  # noqa: S101 (there was an interval)
    return ScalingRange(RangeStatus.EMPTY, *refused, found.samples)


def _end_of_gap(samples: SampleRanges, gap: Gap, side: Side) -> RangeEnd:
    """An end of an interval that a gap sets: its lower one ends an interval, its upper one begins one."""
    c2, rows, load = (
        (gap.lower, gap.lower_rows, gap.lower_load) if side == "lower" else (gap.upper, gap.upper_rows, gap.upper_load)
    )
    return RangeEnd(c2, gap.sample, float(samples.time[gap.sample]), tuple(rows), load)


def _end(
    samples: SampleRanges,
    sample: int,
    c2: float,
    rows: Sequence[tuple[ActiveRow, ...]],
    loads: Sequence[LoadPoint] | None,
) -> RangeEnd:
    named = RowsWhenAsked(rows, sample)
    return RangeEnd(c2, sample, float(samples.time[sample]), named, loads[sample] if loads else None)
