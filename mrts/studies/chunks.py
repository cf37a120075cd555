# SPDX-License-Identifier: MIT
"""The chunks of a study through workers: a few in flight at a time, each solved whatever becomes of its worker."""

import pickle
from collections.abc import Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import suppress
from functools import lru_cache
from itertools import islice

from mrts.base.errors import InputError, MrtsError, SolverError
from mrts.base.version import __version__
from mrts.studies.study import Study
from mrts.studies.variant_rows import FAILED, Columns, columns_of, solve_one_by_one, solve_variants
from mrts.studies.worker_pools import worker_pool

CHUNKS_A_WORKER = 2
"""In flight: one at work, one that waits."""

MAX_DEATHS = 2
"""Of workers that solve a chunk with no other beside it; then it is solved variant by variant."""


def solve_chunk(pickled: bytes, version: str, chunk: range) -> list[Columns]:
    """Solve variants in a worker: rows in one piece or, around a defect, more.

    Raises:
        InputError: If this is another mrts: rows of two would stand side by side.
    """
    if version != __version__:
        raise InputError("worker", f"runs mrts {__version__}, the sweep {version}: install the same on all machines.")
    study = _study(pickled)
    try:
        return [solve_variants(study, chunk.start, chunk.stop)]
    except MrtsError:
        raise
    except Exception:  # noqa: BLE001 (a defect in one variant must not take the others with it)
        return [solve_one_by_one(study, study.points(each, each + 1), each) for each in chunk]


@lru_cache(maxsize=1)
def _study(pickled: bytes) -> Study:
    """The study of a worker, which binds its functions once."""
    study: Study = pickle.loads(pickled)  # noqa: S301 (from the driver, as the call itself)
    return study


def solved_chunks(
    study: Study, chunks: Iterable[range], workers: int | None, scheduler: str | None
) -> Generator[tuple[range, list[Columns]]]:
    """Every chunk of variants with the columns of its rows, in one piece or more in order, as they get done.

    Raises:
        InputError: If a limit of the study cannot be sent to workers.
        MrtsError: If a worker cannot work at all, such as one of another version.
    """
    try:
        pickled = pickle.dumps(study)
    except (pickle.PicklingError, AttributeError):
        rule = "must be functions of a module that workers can import, not of another function, and no lambda."
        raise InputError("study: limits", rule) from None
    coming, complete = iter(chunks), False
    suspects: list[range] = []  # in flight when a worker ended
    while not complete:
        started: set[range] = set()
        running: dict[Future[list[Columns]], range] = {}
        with worker_pool(workers, scheduler) as pool:
            try:
                while not complete:
                    for chunk in islice(coming, max(0, CHUNKS_A_WORKER * max(1, pool.size()) - len(running))):
                        started.add(chunk)
                        running[pool.submit(solve_chunk, pickled, __version__, chunk)] = chunk
                    complete = not running
                    for future in wait(running, return_when=FIRST_COMPLETED).done if running else ():
                        pieces = future.result()
                        chunk = running.pop(future)
                        started.remove(chunk)
                        yield chunk, pieces
            except pool.deaths:
                suspects += started
    for chunk in suspects:
        yield chunk, _alone(study, pickled, (workers, scheduler), chunk)


def _alone(study: Study, pickled: bytes, where: tuple[int | None, str | None], chunk: range) -> list[Columns]:
    """Rows that may end their worker: those that do are found variant by variant."""
    for _ in range(MAX_DEATHS):
        with worker_pool(*where) as pool:
            try:
                pool.submit(_study, pickled).result()
            except pool.deaths:
                raise SolverError("workers end before they are ready: see what ends them.") from None
            with suppress(*pool.deaths):
                pieces: list[Columns] = pool.submit(solve_chunk, pickled, __version__, chunk).result()
                return pieces
    if len(chunk) > 1:
        return [piece for each in chunk for piece in _alone(study, pickled, where, range(each, each + 1))]
    lost = {"status": FAILED, "reason": "the process that solved it ended each time: out of memory, or a crash"}
    return [columns_of(study, study.points(chunk.start, chunk.stop), chunk.start, [lost])]
