# SPDX-License-Identifier: MIT
"""The admissible range of c² over the whole motion: the intersection of the ranges of all samples."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mrts.base.interval_text import interval_text
from mrts.base.load_box import LoadPoint
from mrts.limits.rows import ActiveRow
from mrts.samples.range_status import RangeStatus
from mrts.samples.sample_ranges import POINT_TOLERANCE, SampleRanges, first_least


@dataclass(frozen=True)
class RangeEnd:
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
    rows: tuple[ActiveRow, ...]
    load: LoadPoint | None = None

    def to_json(self) -> dict[str, Any] | None:
        """Entry of "binding" in the JSON result; None if nothing limits this end."""
        if self.time is None:
            return None
        entry: dict[str, Any] = {"time": self.time, "rows": [row.to_json() for row in self.rows]}
        return entry if self.load is None else entry | {"load": self.load.to_json()}

    def place(self) -> str:
        """When, with which load and by which rows this end is set, in words."""
        of_load = self.load is not None and any(row.name.kind != "velocity" for row in self.rows)
        load = f" with {self.load}" if of_load else ""
        return f"at t = {self.time:.4g} s{load} by {', '.join(str(row) for row in self.rows)}"


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

    def __repr__(self) -> str:
        ends = f"c² ∈ {interval_text(self.lower.c2, self.upper.c2)}, " if self.lower and self.upper else ""
        return f"<ScalingRange {self.status.value}: {ends}{len(self.samples.time)} samples>"

    def to_json(self) -> dict[str, Any]:
        """Status, both ends and what sets them; None stands for an end that does not exist."""
        ends = {"lower": self.lower, "upper": self.upper}
        return {
            "status": self.status.value,
            "c2": {side: end.c2 if end and np.isfinite(end.c2) else None for side, end in ends.items()},
            "binding": {side: end.to_json() if end else None for side, end in ends.items()},
        }

    def explain(self) -> str:
        """Why no c² is admissible (the message of step 3.2); empty if some is."""
        if self.status is RangeStatus.INFEASIBLE:
            conflicts = self.samples.conflicts
            worst = max(conflicts, key=lambda conflict: conflict.widening)
            text = f"{len(conflicts)} of {len(self.samples.time)} samples are infeasible. The worst: {worst}."
        elif self.status is RangeStatus.EMPTY and self.lower and self.upper:
            slow, fast = self.lower, self.upper
            text = f"c² must be at least {slow.c2:.6g} {slow.place()}, but at most {fast.c2:.6g} {fast.place()}."
        else:
            return ""
        return f"{text} {self.status.advice}"


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
        return ScalingRange(RangeStatus.UNBOUNDED, lower, RangeEnd(high, None, None, ()), samples)
    upper = _end(samples, at_high, high, samples.upper_rows, samples.upper_loads)
    status = RangeStatus.FEASIBLE if low <= high else RangeStatus.EMPTY
    return ScalingRange(status, lower, upper, samples)


def _end(
    samples: SampleRanges,
    sample: int,
    c2: float,
    rows: Sequence[tuple[ActiveRow, ...]],
    loads: Sequence[LoadPoint] | None,
) -> RangeEnd:
    return RangeEnd(c2, sample, float(samples.time[sample]), rows[sample], loads[sample] if loads else None)
