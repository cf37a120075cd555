# SPDX-License-Identifier: MIT
"""All variants of a study, solved chunk by chunk into a folder; needs the extra 'study' (joblib, pyarrow)."""

import tempfile
from contextlib import closing, nullcontext
from os import PathLike
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING

from mrts.base.errors import Progress, as_path, check_callable, check_type, require_extra
from mrts.studies.study import Study, read_study
from mrts.studies.study_folder import StudyFolder, opened_study_folder
from mrts.studies.variants import batch_for
from mrts.studies.workers import check_workers, solved_chunks

if TYPE_CHECKING:
    import pyarrow as pa

AT_ONCE, ALONE = 1000, 50
"""Variants of a chunk where they are solved at once, and one by one: about a second of a worker. So little is lost with
it, and little time goes into passing them."""


def sweep(
    study: Study | Path | str,
    folder: Path | str | None = None,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress = lambda _done, _total: None,
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
        progress: Told how many of how many variants are solved, after each chunk.

    Returns:
        One row a variant, in order, as a `pyarrow.Table`; its `to_pandas()` is a data frame.

    Raises:
        InputError: If the study breaks a rule, the folder is of another study or at work, a package lacks, no
            scheduler answers, or a file cannot be written.
    """
    check_type("folder", folder, str, PathLike, NoneType)
    wanted = study if isinstance(study, Study) else read_study(as_path("study", study))
    with nullcontext(folder) if folder is not None else tempfile.TemporaryDirectory(prefix="mrts-study-") as path:
        return solve_study(wanted, as_path("folder", path), workers, scheduler, progress).table()


def solve_study(
    study: Study,
    path: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress = lambda _done, _total: None,
) -> StudyFolder:
    """Solve what a folder does not hold yet of a study; the arguments are those of `sweep`.

    Raises:
        InputError: As `sweep` does.
    """
    require_extra("study", "study", "pyarrow")
    check_workers(workers, scheduler)
    check_callable("progress", progress)
    with opened_study_folder(path, study, lambda: chunk_size(study)) as folder:
        solved = folder.parts()
        missing = [folder.variants_of(number) for number in range(folder.chunks) if number not in solved]
        done = folder.variants - sum(map(len, missing))
        progress(done, folder.variants)
        if missing:
            with closing(solved_chunks(study, missing, workers, scheduler)) as coming:
                for chunk, pieces in coming:
                    folder.write(chunk.start // folder.chunk, pieces)
                    done += len(chunk)
                    progress(done, folder.variants)
        return folder


def best_variants(folder: StudyFolder, count: int) -> dict[int, float]:
    """The duration [s] of the best variants, the shortest first."""
    rows = folder.table(["variant", "duration"]).drop_null()
    best = rows.sort_by([("duration", "ascending"), ("variant", "ascending")]).slice(0, count)
    return dict(zip(best["variant"].to_pylist(), best["duration"].to_pylist(), strict=True))


def chunk_size(study: Study) -> int:
    """Variants of a chunk."""
    return min(study.variants, ALONE if batch_for(study) is None else AT_ONCE)
