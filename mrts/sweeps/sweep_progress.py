# SPDX-License-Identifier: MIT
"""How far a sweep is."""

import time
from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from mrts.studies.dry_run import time_text

TALLIED = ("variant", "status", "duration")
"""Columns that a tally reads."""


@dataclass(frozen=True)
class SweepProgress:
    """How far a sweep is.

    Attributes:
        variants: Of the study.
        done: How many of them are solved, by earlier runs as well.
        rate: Of this run, in variants a second; 0 while it has solved none.
        best: The shortest duration so far [s]; None while no variant is feasible.
        best_variant: Which one has it.
    """

    variants: int
    done: int
    rate: float
    best: float | None
    best_variant: int | None

    @property
    def remaining(self) -> float | None:
        """Time until all are solved, at this rate [s]; None while there is no rate."""
        return (self.variants - self.done) / self.rate if self.rate else None

    def __str__(self) -> str:
        left = self.remaining
        rate = "" if left is None else f"{self.rate:.3g} a second, {time_text(left)} left"
        best = "" if self.best is None else f"best {self.best:.4g} s"
        return "; ".join(part for part in (rate, best) if part)


class Tally:
    """Counts rows as they come.

    Args:
        variants: Of the study.
    """

    def __init__(self, variants: int) -> None:
        self.statuses: Counter[str] = Counter()
        self._variants = variants
        self._before, self._begun = 0, time.monotonic()
        self._best: tuple[float, int] | None = None

    def add(self, rows: Any) -> None:
        """Count rows that are solved."""
        self.statuses.update(rows["status"].to_pylist())
        durations = np.asarray(rows["duration"], dtype=np.float64)
        if np.isfinite(durations).any():
            row = int(np.nanargmin(durations))
            found = float(durations[row]), int(rows["variant"][row].as_py())
            self._best = found if self._best is None else min(self._best, found)

    def begin(self) -> None:
        """From here on rows count for the rate."""
        self._before, self._begun = self.statuses.total(), time.monotonic()

    def progress(self) -> SweepProgress:
        """How far it is."""
        done = self.statuses.total()
        taken = time.monotonic() - self._begun
        rate = (done - self._before) / taken if taken else 0.0
        return SweepProgress(self._variants, done, rate, *(self._best or (None, None)))
