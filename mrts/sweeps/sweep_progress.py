# SPDX-License-Identifier: MIT
"""How far a sweep is."""

import time
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mrts.studies.dry_run import time_text

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
        self._best: float | None = None
        self._best_variant: int | None = None

    def add(self, rows: Any) -> None:
        """Count rows that are solved.

        Args:
            rows: A table or a batch of records with the columns in `TALLIED`.
        """
        self.statuses.update(rows["status"].to_pylist())
        duration = numbers(rows["duration"])
        k = int(np.argmin(duration)) if len(duration) else 0
        if not len(duration) or not np.isfinite(duration[k]):
            return
        found = float(duration[k]), int(rows["variant"][k].as_py())
        if self._best is None or found < (self._best, self._best_variant):  # of equals the lower number
            self._best, self._best_variant = found

    def begin(self) -> None:
        """From here on rows count for the rate."""
        self._before, self._begun = self.statuses.total(), time.monotonic()

    def progress(self) -> SweepProgress:
        """How far it is."""
        done = self.statuses.total()
        taken = time.monotonic() - self._begun
        rate = (done - self._before) / taken if taken else 0.0
        return SweepProgress(self._variants, done, rate, self._best, self._best_variant)


def numbers(column: "pa.ChunkedArray | pa.Array") -> Any:
    """A column, infinite where there is no number."""
    import pyarrow.compute as pc  # noqa: PLC0415 (an extra)

    return np.asarray(pc.fill_null(column, np.inf), dtype=np.float64)
