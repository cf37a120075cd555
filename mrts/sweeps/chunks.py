# SPDX-License-Identifier: MIT
"""The chunks of a study through workers: a few in flight at a time, each solved whatever becomes of its worker."""

import pickle
from collections import Counter
from collections.abc import Generator, Iterable
from concurrent.futures import Future
from functools import lru_cache
from typing import NamedTuple

from mrts.base.errors import InputError, MrtsError, SolverError
from mrts.base.version import __version__
from mrts.studies.study import Study
from mrts.studies.variant_rows import FAILED, Columns, columns_of, solve_variants
from mrts.sweeps.worker_pools import WorkerPool

MAX_DEATHS = 2
"""Of workers that solve a chunk; then it is solved with no other beside it, and then variant by variant."""

MAX_STARTS = 10
"""Of workers that end before they are ready, whatever they are to solve."""


class Chunk(NamedTuple):
    """Variants that are solved in one call.

    Attributes:
        number: Of the part that they make.
        first: The first variant.
        last: The one after the last.
    """

    number: int
    first: int
    last: int


def solve_chunk(pickled: bytes, version: str, first: int, last: int) -> list[Columns]:
    """Solve variants: what a worker does.

    Args:
        pickled: The study.
        version: Of the mrts that asks.
        first: The first variant.
        last: The one after the last.

    Returns:
        Rows in one piece or, around a defect, more; a variant that meets one has no values of its parameters.

    Raises:
        InputError: If this is another mrts: rows of two would stand side by side.
    """
    if version != __version__:
        raise InputError("worker", f"runs mrts {__version__}, the sweep {version}: install the same on all machines.")
    try:
        return [solve_variants(_study(pickled), first, last)]
    except MrtsError:
        raise
    except Exception as error:  # noqa: BLE001 (a defect in one variant must not take the others with it)
        if last - first == 1:
            said = " ".join(str(error).split())
            return [_failed(first, f"internal error: {type(error).__name__}: {said}")]
        alone = (solve_chunk(pickled, version, variant, variant + 1) for variant in range(first, last))
        return [piece for pieces in alone for piece in pieces]


def get_ready(pickled: bytes) -> None:
    """Read the study: a worker that is ended before that was not ended by a variant.

    Args:
        pickled: The study.
    """
    _study(pickled)


@lru_cache(maxsize=1)
def _study(pickled: bytes) -> Study:
    """The study of a worker, which binds its functions once."""
    study: Study = pickle.loads(pickled)  # noqa: S301 (from the driver, as the call itself)
    return study


def _failed(variant: int, reason: str) -> Columns:
    return {"variant": [variant], "status": [FAILED], "reason": [reason]}


def solved_chunks(study: Study, pool: WorkerPool, chunks: Iterable[Chunk]) -> Generator[tuple[Chunk, list[Columns]]]:
    """Every chunk once, as they get done.

    Args:
        study: The study.
        pool: Its workers.
        chunks: What is to be solved, taken as workers get free.

    Yields:
        A chunk and the columns of its rows in one piece or more, in order.

    Raises:
        InputError: If a limit of the study cannot be sent to workers.
        MrtsError: If a worker cannot work at all, such as one of another version.
    """
    try:
        pickled = pickle.dumps(study)
    except (pickle.PicklingError, AttributeError):
        rule = "must be functions of a module that workers can import, not of another function, and no lambda."
        raise InputError("study: limits", rule) from None
    coming, deaths = iter(chunks), Counter[int]()
    again: list[Chunk] = []
    alone: list[Chunk] = []
    running: dict[Future[list[Columns]], Chunk] = {}
    while True:
        slots = pool.slots()
        while len(running) < slots and (chunk := again.pop() if again else next(coming, None)):
            running[pool.submit(solve_chunk, pickled, __version__, chunk.first, chunk.last)] = chunk
        if not running:
            break
        for future in pool.ended(running):
            chunk = running.pop(future)
            if not pool.died(future):
                yield chunk, _whole(study, future.result())
                continue
            deaths[chunk.number] += 1
            (again if deaths[chunk.number] < MAX_DEATHS else alone).append(chunk)
    if alone:
        _check_ready(pool, pickled)
    for chunk in alone:
        yield chunk, _whole(study, _alone(pool, pickled, chunk.first, chunk.last))


def _alone(pool: WorkerPool, pickled: bytes, first: int, last: int) -> list[Columns]:
    """Rows that may end their worker: those that do are found variant by variant."""
    for _ in range(MAX_DEATHS):
        future = pool.submit(solve_chunk, pickled, __version__, first, last)
        pool.ended([future])
        if not pool.died(future):
            return future.result()
    if last - first == 1:
        return [_failed(first, "the process that solved it ended each time: out of memory, or a crash")]
    return [piece for variant in range(first, last) for piece in _alone(pool, pickled, variant, variant + 1)]


def _check_ready(pool: WorkerPool, pickled: bytes) -> None:
    """Check that workers live at all, so that their death tells something of what they solve."""
    for _ in range(MAX_STARTS):
        future = pool.submit(get_ready, pickled)
        pool.ended([future])
        if not pool.died(future):
            return
    raise SolverError(f"{MAX_STARTS} workers were started, and all ended before they were ready: see what ends them.")


def _whole(study: Study, pieces: list[Columns]) -> list[Columns]:
    """The pieces, with all columns where a variant failed."""
    return [piece if piece["status"] != [FAILED] else _row(study, piece["variant"][0], piece) for piece in pieces]


def _row(study: Study, variant: int, failed: Columns) -> Columns:
    row = {name: failed[name][0] for name in ("status", "reason")}
    return columns_of(study, study.points(variant, variant + 1), variant, [row])
