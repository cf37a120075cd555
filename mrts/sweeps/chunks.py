# SPDX-License-Identifier: MIT
"""The chunks of a study through a pool of workers: a few in flight at a time, each solved whatever becomes of them."""

import pickle
from collections import Counter, deque
from collections.abc import Generator, Iterable
from concurrent.futures import Future
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, MrtsError, SolverError
from mrts.base.version import __version__
from mrts.studies.study import Study
from mrts.studies.variant_rows import solve_variants
from mrts.sweeps.worker_pools import WorkerPool

Columns = dict[str, list[Any] | Array]
"""Rows of variants, by name of the column."""

LIVES = 5
"""Times that a chunk may be in flight when a worker dies, before it is solved with no other beside it."""

TRIES = 4
"""Times that a variant is tried by itself before it is said to end its worker; more than one are halved instead."""

STARTS = 100
"""Times that a worker is started before it is said that none gets ready, whatever it is to solve."""


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


def solve_chunk(pickled: bytes, version: str, first: int, last: int) -> Columns:
    """Solve variants: what a worker does.

    Args:
        pickled: The study.
        version: Of the mrts that asks.
        first: The first variant.
        last: The one after the last.

    Raises:
        InputError: If this is another mrts: rows of two would stand side by side.
    """
    if version != __version__:
        raise InputError("worker", f"runs mrts {__version__}, the sweep {version}: install the same on all machines.")
    return solve_variants(_study(pickled), first, last)


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


class ChunkSolver:
    """Solves chunks of a study.

    Args:
        study: The study.
        pool: Its workers.
    """

    def __init__(self, study: Study, pool: WorkerPool) -> None:
        self._study = study
        try:
            self._pickled = pickle.dumps(study)
        except (pickle.PicklingError, AttributeError):
            rule = "must be functions of a module that workers can import, not of another function, and no lambda."
            raise InputError("study: limits", rule) from None
        self._pool = pool

    def solved(self, chunks: Iterable[Chunk]) -> Generator[tuple[Chunk, list[Columns]]]:
        """Every chunk once, as they get done, with its rows in one piece or more.

        Args:
            chunks: What is to be solved, taken as workers get free.

        Yields:
            A chunk and the columns of its rows, in order.

        Raises:
            MrtsError: If a worker cannot work at all, such as one of another version.
        """
        coming = iter(chunks)
        again: deque[Chunk] = deque()
        alone: list[Chunk] = []
        deaths: Counter[int] = Counter()
        running: dict[Future[Columns], Chunk] = {}
        while True:
            while len(running) < self._pool.slots() and (chunk := again.popleft() if again else next(coming, None)):
                running[self._submit(chunk.first, chunk.last)] = chunk
            if not running:
                break
            for future in self._pool.ended(running):
                chunk, error = running.pop(future), future.exception()
                if error is None:
                    yield chunk, [future.result()]
                elif isinstance(error, MrtsError):
                    raise error
                elif self._pool.died(error) and deaths[chunk.number] < LIVES - 1:
                    deaths[chunk.number] += 1
                    again.append(chunk)
                else:
                    alone.append(chunk)
        for chunk in alone:
            yield chunk, self._apart(chunk.first, chunk.last)

    def _submit(self, first: int, last: int) -> "Future[Columns]":
        return self._pool.submit(solve_chunk, self._pickled, __version__, first, last)

    def _apart(self, first: int, last: int) -> list[Columns]:
        """Rows that end their worker, or stumble over a defect: halved until those that do it are found."""
        reason = ""
        for _ in range(TRIES if last - first == 1 else 1):
            self._wait_for_a_worker()
            future = self._submit(first, last)
            self._pool.ended([future])
            error = future.exception()
            if error is None:
                return [future.result()]
            if isinstance(error, MrtsError):
                raise error
            reason = _reason(error, died=self._pool.died(error))
            if not self._pool.died(error):
                break  # it would stumble again
        if last - first == 1:
            return [self._failed(first, reason)]
        middle = (first + last) // 2
        return [*self._apart(first, middle), *self._apart(middle, last)]

    def _wait_for_a_worker(self) -> None:
        """Have a worker that is ready, so that its death tells something of what it solves.

        Raises:
            SolverError: If none gets ready.
        """
        for _ in range(STARTS):
            future = self._pool.submit(get_ready, self._pickled)
            self._pool.ended([future])
            error = future.exception()
            if error is None:
                return
            if not self._pool.died(error):
                raise error
        raise SolverError(f"{STARTS} workers were started, and all ended before they were ready: see what ends them.")

    def _failed(self, variant: int, reason: str) -> Columns:
        """The row of a variant that no worker survives."""
        point = self._study.points(variant, variant + 1)[0]
        numbers = dict(zip((each.path for each in self._study.parameters), np.atleast_2d(point).T, strict=True))
        return {"variant": [variant], **numbers, "status": ["failed"], "reason": [reason]}


def _reason(error: BaseException, *, died: bool) -> str:
    if died:
        return "the process that solved it ended each time: out of memory, or a crash"
    said = " ".join(str(error).split())
    return f"internal error: {type(error).__name__}: {said}"
