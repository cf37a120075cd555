# SPDX-License-Identifier: MIT
"""What native calls found of many variants, as the columns of a study's table."""

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.following.variant_tracking import TrackedVariants
from mrts.kernel.programs import INFEASIBLE, OPTIMAL
from mrts.kernel.tracking import REFUSED
from mrts.limits.rows import ActiveRow
from mrts.program.range_status import RangeStatus
from mrts.program.sample_ranges import POINT_TOLERANCE
from mrts.scaling.range import RangeEnd, contradiction
from mrts.studies.at_once.variant_limits import VariantLimits
from mrts.studies.variant_rows import UNREACHABLE, Row, limit_text


class VariantAnswers:
    """The rows of the table of some variants, as far as they are settled.

    Args:
        limits: Of their cell.
        given: What the native calls took, by name, with V or 1 first.
        tracked: What they gave.
        found: Ranges, of `mrts.kernel.variants.range_record`.

    Attributes:
        found: Likewise.
    """

    def __init__(
        self,
        limits: VariantLimits,
        given: Mapping[str, Array],
        tracked: TrackedVariants,
        found: NDArray[np.void],
    ) -> None:
        self._limits, self._given, self._tracked, self.found = limits, given, tracked, found

    def row(self, variant: int) -> Row | None:
        """The row of one variant, without its number and its parameters; None where it is not settled.

        Args:
            variant: Place in the arrays.
        """
        failure = self._tracked.failure(variant)
        if failure is not None:
            return {"status": UNREACHABLE, "reason": failure.message}
        if self._tracked.joints.outcome[variant, 0]["code"] == REFUSED:
            return None
        status = int(self.found[variant]["status"])
        if status == INFEASIBLE:
            return self._infeasible(variant)
        return self._range(variant) if status == OPTIMAL else None

    def _of(self, name: str, variant: int) -> Array:
        values = self._given[name]
        one: Array = values[variant if len(values) > 1 else 0]
        return one

    def _infeasible(self, variant: int) -> Row:
        found, status = self.found[variant], RangeStatus.INFEASIBLE
        rows = self._named(variant, 0)
        sample = int(found["sample"][0])
        reason = (
            f"at t = {self._of('time', variant)[sample]:.4g} s (sample {sample}) no torques carry the object at any "
            f"speed: these limits conflict: {'; '.join(map(str, rows))}. {status.advice}"
        )
        return {"status": status.value, "reason": reason}

    def _range(self, variant: int) -> Row:
        """As `mrts.studies.variant_rows.range_row` has it."""
        low, high = self.found[variant]["c2"].tolist()
        if high < low <= high * (1 + POINT_TOLERANCE):
            low = high
        if low > high:
            text = contradiction(self._end(variant, 0, low), self._end(variant, 1, high))
            return {"status": RangeStatus.EMPTY.value, "reason": f"{text} {RangeStatus.EMPTY.advice}"}
        row: Row = {"status": RangeStatus.FEASIBLE.value, "c2_lower": low}
        if low > 0:
            row["lower_limit"] = self._limit(variant, 0, low)
        if np.isinf(high):
            return row | {"status": RangeStatus.UNBOUNDED.value, "reason": RangeStatus.UNBOUNDED.advice}
        duration = self._of("time", variant)[-1] / np.sqrt(high)
        return row | {"c2_upper": high, "upper_limit": self._limit(variant, 1, high), "duration": float(duration)}

    def _end(self, variant: int, end: int, c2: float) -> RangeEnd:
        sample = int(self.found[variant]["sample"][end])
        return RangeEnd(c2, sample, float(self._of("time", variant)[sample]), self._rows(variant, end))

    def _limit(self, variant: int, end: int, c2: float) -> str:
        at = self._end(variant, end, c2)
        return limit_text(at.rows, at.time or 0.0)

    def _rows(self, variant: int, end: int) -> tuple[ActiveRow, ...]:
        """What sets an end."""
        rows = self._named(variant, end)
        if end and self.found[variant]["capped"]:
            rows += self._velocities[variant]
        return tuple(rows)

    @cached_property
    def _velocities(self) -> dict[int, list[ActiveRow]]:
        """By variant that velocities bound: those that do the most."""
        settled = self._tracked.joints.followed & (self.found["status"] == OPTIMAL)
        capped = np.flatnonzero(settled & (self.found["capped"] != 0))
        sample = self.found["sample"][capped, 1]
        twist, limit = (np.broadcast_to(each, (len(self.found), *each.shape[1:])) for each in
                        (self._given["twist"], self._given["velocity"]))  # fmt: skip
        rows = self._limits.velocities_at(self._tracked.joints.dq[capped, sample], twist[capped, sample], limit[capped])
        return dict(zip(capped.tolist(), rows, strict=True))

    def _named(self, variant: int, end: int) -> list[ActiveRow]:
        found = self.found[variant]
        sides = self._of("lower", variant), self._of("upper", variant)
        return self._limits.named(found["rows"][end, : found["count"][end]], *sides)
