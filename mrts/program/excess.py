# SPDX-License-Identifier: MIT
"""How far limits are overstepped between samples, as every result says it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from mrts.base.argument_types import is_number
from mrts.base.errors import InputError
from mrts.limits.rows import ActiveRow

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
        return self.named if self.named is None or isinstance(self.named, ActiveRow) else self.named()

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
        rule = (
            f"must be a share of a limit from {LEAST_BETWEEN:g} to {LARGEST_BETWEEN:g}, or None for the bare samples."
        )
        raise InputError("between", rule, value=between)
    return float(between)  # type: ignore[arg-type]  # is_number has seen to it
