# SPDX-License-Identifier: MIT
"""All variants of a study, solved chunk by chunk into a folder; needs the extra 'study' (joblib, pyarrow)."""

import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import closing, nullcontext
from dataclasses import dataclass, field, replace
from datetime import timedelta
from os import PathLike
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from mrts.base.argument_types import as_path, check_callable, check_type, require_extra
from mrts.base.errors import InputError
from mrts.studies.study import Study, read_study
from mrts.studies.study_folder import StudyFolder, opened_study_folder
from mrts.studies.variant_batch import batch_for
from mrts.studies.variant_rows import fastest_first
from mrts.studies.workers import check_workers, solved_chunks

if TYPE_CHECKING:
    import pyarrow as pa

AT_ONCE, ALONE = 1000, 50
"""Variants of a chunk where they are solved at once, and one by one: about a second of a worker. So little is lost with
it, and little time goes into passing them."""

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
    """

    variants: int
    statuses: Counter[str] = field(default_factory=Counter)
    best: float | None = None
    best_variant: int | None = None
    rate: float = 0.0

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
        rate = "" if left is None else f"{self.rate:.3g} a second, {timedelta(seconds=round(left))} left"
        best = "" if self.best is None else f"best {self.best:.4g} s"
        return "; ".join(part for part in (rate, best) if part)

    def after(self, rows: Any) -> Self:
        """The progress after more rows with the columns `TALLIED`."""
        found = replace(self, statuses=self.statuses + Counter(rows["status"].to_pylist()))
        durations = np.asarray(rows["duration"], dtype=np.float64)
        if np.isfinite(durations).any():
            row = int(np.nanargmin(durations))
            best = float(durations[row]), int(rows["variant"][row].as_py())
            if self.best is None or best < (self.best, self.best_variant):
                found = replace(found, best=best[0], best_variant=best[1])
        return found


def sweep(
    study: Study | Path | str,
    folder: Path | str | None = None,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    top: int = 0,
    progress: Callable[[SweepProgress], None] = lambda _progress: None,
) -> "pa.Table":
    """Solve all variants of a study, or those that a folder does not hold yet.

    The table is the same whoever solves it: whatever the number of workers, on one machine or many, in one go or in
    several that were ended at any moment.

    Args:
        study: A study, or its file.
        folder: For `study.json` and the rows, a file a chunk; one that this study has begun is gone on with. None keeps
            them only until they are returned.
        workers: Number of processes on this machine; None for one a core.
        scheduler: Address of a Dask scheduler whose workers solve the study, such as tcp://HOST:8786; None for
            processes of this machine.
        top: How many of the best variants are written as files into folders best-1, best-2, … of the folder.
        progress: Told how far it is, after each chunk.

    Returns:
        One row a variant, in order, as a `pyarrow.Table`; its `to_pandas()` is a data frame.

    Raises:
        InputError: If the study breaks a rule, the folder is of another study or at work, a package lacks, no
            scheduler answers, or a file cannot be written.
    """
    check_type("folder", folder, str, PathLike, NoneType)
    check_type("top", top, int)
    if top < 0 or (top > 0 and folder is None):
        raise InputError("top", "must be at least 0, and takes a folder where it is more.", value=top)
    wanted = study if isinstance(study, Study) else read_study(as_path("study", study))
    with nullcontext(folder) if folder is not None else tempfile.TemporaryDirectory(prefix="mrts-study-") as path:
        solved, _ = solve_study(wanted, as_path("folder", path), workers, scheduler, progress)
        if top:
            write_best(wanted, solved, top)
        return solved.table()


def solve_study(
    study: Study,
    path: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[SweepProgress], None] = lambda _progress: None,
) -> tuple[StudyFolder, SweepProgress]:
    """Solve what a folder does not hold yet of a study; the arguments are those of `sweep`.

    Returns:
        The folder, complete, and what became of the variants.

    Raises:
        InputError: As `sweep` does.
    """
    require_extra("study", "study", "pyarrow")
    check_workers(workers, scheduler)
    check_callable("progress", progress)
    with opened_study_folder(path, study, lambda: chunk_size(study)) as folder:
        so_far = SweepProgress(folder.variants)
        for batch in folder.dataset().to_batches(columns=[*TALLIED]):
            so_far = so_far.after(batch)
        solved = folder.parts()
        missing = [folder.variants_of(number) for number in range(folder.chunks) if number not in solved]
        progress(so_far)
        before, begun = so_far.done, time.monotonic()
        if missing:
            with closing(solved_chunks(study, missing, workers, scheduler)) as coming:
                for chunk, pieces in coming:
                    rows = folder.rows(pieces)
                    folder.write(chunk.start // folder.chunk, rows)
                    so_far = so_far.after(rows)
                    so_far = replace(so_far, rate=(so_far.done - before) / (time.monotonic() - begun))
                    progress(so_far)
        return folder, so_far


def write_best(study: Study, folder: StudyFolder, count: int) -> None:
    """Write the best variants as files into folders best-1, best-2 and so on.

    Raises:
        InputError: If a file cannot be written.
    """
    rows = folder.table(["variant", "duration"])
    variants, durations = np.asarray(rows["variant"], dtype=int), np.asarray(rows["duration"], dtype=np.float64)
    for rank, variant in enumerate(variants[fastest_first(variants, durations)[:count]].tolist(), start=1):
        study.write_variant(variant, folder.path / f"best-{rank}")


def chunk_size(study: Study) -> int:
    """Variants of a chunk."""
    return min(study.variants, ALONE if batch_for(study) is None else AT_ONCE)
