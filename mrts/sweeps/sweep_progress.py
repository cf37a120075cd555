# SPDX-License-Identifier: MIT
"""How far a sweep is."""

import time
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.studies.dry_run import time_text
from mrts.studies.ranking import fastest_first

if TYPE_CHECKING:
    import pyarrow as pa

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
        self._before = 0
        self._begun = time.monotonic()
        self._best = np.zeros(0, dtype=int), np.zeros(0)

    def add(self, rows: Any) -> None:
        """Count rows that are solved.

        Args:
            rows: A table or a batch of records with the columns in `TALLIED`.
        """
        self.statuses.update(rows["status"].to_pylist())
        variant, duration = map(np.append, self._best, ranked_columns(rows))
        best = fastest_first(variant, duration)[:1]
        self._best = variant[best], duration[best]

    def begin(self) -> None:
        """From here on rows count for the rate."""
        self._before, self._begun = self.statuses.total(), time.monotonic()

    def progress(self) -> SweepProgress:
        """How far it is."""
        done = self.statuses.total()
        taken = time.monotonic() - self._begun
        rate = (done - self._before) / taken if taken else 0.0
        variant, duration = self._best
        best = (float(duration[0]), int(variant[0])) if len(variant) else (None, None)
        return SweepProgress(self._variants, done, rate, *best)


def ranked_columns(rows: "pa.Table | pa.RecordBatch") -> tuple[NDArray[np.int_], Array]:
    """Number and duration of each variant, which `mrts.studies.ranking.fastest_first` takes.

    Args:
        rows: With the columns `variant` and `duration`.
    """
    variant, duration = (np.asarray(rows[name]) for name in ("variant", "duration"))
    return variant.astype(int), duration.astype(float)
