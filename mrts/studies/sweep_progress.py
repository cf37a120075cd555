# SPDX-License-Identifier: MIT
"""How far a sweep is."""

import time
from collections import Counter
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from mrts.studies.dry_run import time_text

TALLIED = ("variant", "status", "duration")
"""Columns that are counted."""


@dataclass(frozen=True)
class SweepProgress:
    """How far a sweep is.

    Attributes:
        variants: Of the study.
        statuses: How many that are solved have each status, by earlier runs as well.
        best: The shortest duration so far [s]; None while no variant is feasible.
        best_variant: Which one has it; of equals, that with the lower number.
        rate: Of this run, in variants a second; 0 while it has solved none.
        begun: When this run began, by `time.monotonic` [s], and how many were solved before it.
    """

    variants: int
    statuses: Counter[str] = field(default_factory=Counter)
    best: float | None = None
    best_variant: int | None = None
    rate: float = 0.0
    begun: tuple[float, int] | None = None

    @property
    def done(self) -> int:
        """How many are solved, by earlier runs as well."""
        return self.statuses.total()

    @property
    def remaining(self) -> float | None:
        """Time until all are solved, at this rate [s]; None while there is no rate."""
        return (self.variants - self.done) / self.rate if self.rate else None

    def __str__(self) -> str:
        left = self.remaining
        rate = "" if left is None else f"{self.rate:.3g} a second, {time_text(left)} left"
        best = "" if self.best is None else f"best {self.best:.4g} s"
        return "; ".join(part for part in (rate, best) if part)

    def after(self, rows: Any) -> Self:
        """The progress after more rows with the columns `TALLIED`; those before `begin` are of earlier runs."""
        found = replace(self, statuses=self.statuses + Counter(rows["status"].to_pylist()))
        durations = np.asarray(rows["duration"], dtype=np.float64)
        if np.isfinite(durations).any():
            row = int(np.nanargmin(durations))
            best = float(durations[row]), int(rows["variant"][row].as_py())
            if self.best is None or best < (self.best, self.best_variant):
                found = replace(found, best=best[0], best_variant=best[1])
        if found.begun is None:
            return found
        taken = time.monotonic() - found.begun[0]
        return replace(found, rate=(found.done - found.begun[1]) / taken if taken else 0.0)

    def begin(self) -> Self:
        """From here on rows count for the rate."""
        return replace(self, begun=(time.monotonic(), self.done))
