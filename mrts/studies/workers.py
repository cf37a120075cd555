# SPDX-License-Identifier: MIT
"""The chunks of a study through workers, each solved whatever becomes of its worker.

They are processes of this machine (joblib's loky) or of a Dask cluster, both executors of `concurrent.futures`. Needs
the extra 'study' (joblib), for a cluster 'cluster' (dask, distributed).
"""

import logging
import os
import pickle
import re
import signal
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from itertools import islice
from multiprocessing.resource_tracker import ensure_running
from queue import Empty
from types import NoneType
from typing import Any

from mrts.base.errors import InputError, MrtsError, SolverError, check_type, require_extra
from mrts.base.held_interrupt import held_interrupt
from mrts.base.version import __version__
from mrts.studies.study import Study
from mrts.studies.variants import FAILED, Columns, columns_of, solve_one_by_one, solve_variants

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""For processes that share the cores among them."""

WATCH_PERIOD = 1.0
"""Between two looks of a worker whether its driver still lives [s]."""

GONE = "is gone, or has dropped this study's work: the same command goes on with what is not solved yet."

CONNECT_TIMEOUT = 10.0
"""For a scheduler to answer [s]."""

ADDRESS = re.compile(r"(\w+://)?\S+:\d{1,5}|inproc://\S+")
"""What may be a scheduler's: Dask leaves a traceback about anything else."""

CHUNKS_A_WORKER = 2
"""In flight: one at work, one that waits."""

MAX_DEATHS = 2
"""Of workers that solve a chunk with no other beside it; then it is solved variant by variant."""

logger = logging.getLogger("mrts")


@dataclass(frozen=True)
class WorkerPool:
    """Workers: what gives one a call, how many there are now, and what is raised where one ended with its call."""

    submit: Callable[..., Future[Any]]
    size: Callable[[], int]
    deaths: tuple[type[Exception], ...]


def check_workers(workers: int | None, scheduler: str | None) -> None:
    """Check what `worker_pool` is to be asked, before any work.

    Raises:
        InputError: If a package lacks, or the two make no sense.
    """
    check_type("workers", workers, int, NoneType)
    check_type("scheduler", scheduler, str, NoneType)
    if workers is not None and workers < 1:
        raise InputError("workers", "must be at least 1.", value=workers)
    if scheduler is not None and workers is not None:
        raise InputError("workers", "goes with processes of this machine: a cluster has its own.", value=workers)
    if scheduler is None:
        require_extra("workers", "study", "joblib")
    else:
        require_extra("scheduler", "cluster", "distributed", value=scheduler)


def worker_pool(workers: int | None, scheduler: str | None) -> AbstractContextManager[WorkerPool]:
    """The workers of a study, gone when the block ends.

    Raises:
        InputError: If no scheduler answers, or it goes away.
    """
    return _local_processes(workers) if scheduler is None else _dask_cluster(scheduler)


@contextmanager
def _local_processes(workers: int | None) -> Iterator[WorkerPool]:
    from joblib import cpu_count  # noqa: PLC0415 (an extra)
    from joblib.externals.loky import ProcessPoolExecutor  # noqa: PLC0415 (likewise)

    workers = workers or cpu_count()
    executor: Any = ProcessPoolExecutor(workers, env=ONE_THREAD, initializer=_leave_with, initargs=(os.getpid(),))

    def submit(function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        try:
            with _without_interrupts():
                future: Future[Any] = executor.submit(function, *arguments)
        except OSError as error:  # a worker that is killed while it is started
            raise BrokenProcessPool(str(error)) from None
        return future

    try:
        yield WorkerPool(submit, lambda: workers, (BrokenProcessPool,))
    finally:
        # loky forgets the calls that wait and then looks up those whose numbers are still queued: a KeyError
        with held_interrupt(), suppress(Empty):
            while True:
                executor._work_ids.get_nowait()  # noqa: SLF001 (it has no other way)
        with held_interrupt():
            executor.shutdown(kill_workers=True)


@contextmanager
def _dask_cluster(scheduler: str) -> Iterator[WorkerPool]:
    if not ADDRESS.fullmatch(scheduler):
        rule = "no Dask scheduler answers there: it is no address. Name one as tcp://HOST:PORT."
        raise InputError("scheduler", rule, value=scheduler)
    distributed = import_module("distributed")
    with ExitStack() as stack:
        for talkative in map(logging.getLogger, ("distributed", "distributed.client")):  # workers that come and go
            stack.callback(talkative.setLevel, talkative.level)
            talkative.setLevel(logging.CRITICAL)
        try:
            client = distributed.Client(scheduler, timeout=CONNECT_TIMEOUT, set_as_default=False)
        except (OSError, ValueError) as error:
            rule = f"no Dask scheduler answers there: {error}. Start one, or name it as tcp://HOST:PORT."
            raise InputError("scheduler", rule, value=scheduler) from None
        stack.callback(held_interrupt()(client.close))
        if not client.nthreads():
            logger.warning("the cluster at %s has no workers: waiting for them", scheduler)
        submit = client.get_executor(pure=False).submit
        try:
            yield WorkerPool(submit, lambda: sum(client.nthreads().values()), (distributed.scheduler.KilledWorker,))
        except (OSError, RuntimeError, CancelledError):
            raise InputError("scheduler", GONE, value=scheduler) from None


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Start processes that Ctrl-C does not reach: it is typed to all of a terminal, and the driver ends its workers."""
    ensure_running()  # it comes with the first process, and lets interrupts through as it is started
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _leave_with(driver: int) -> None:
    """Let a worker end when its driver is gone, even if that was killed."""

    def watch() -> None:
        while os.getppid() == driver:
            time.sleep(WATCH_PERIOD)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


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
    suspects: list[range] = []  # in flight, now or when a worker ended
    while not complete:
        running: dict[Future[list[Columns]], range] = {}
        with worker_pool(workers, scheduler) as pool, suppress(*pool.deaths):
            while not complete:
                for chunk in islice(coming, max(0, CHUNKS_A_WORKER * max(1, pool.size()) - len(running))):
                    suspects.append(chunk)
                    running[pool.submit(solve_chunk, pickled, __version__, chunk)] = chunk
                complete = not running
                for future in wait(running, return_when=FIRST_COMPLETED).done if running else ():
                    pieces = future.result()
                    chunk = running.pop(future)
                    suspects.remove(chunk)
                    yield chunk, pieces
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
