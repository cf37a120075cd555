# SPDX-License-Identifier: MIT
"""Who solves the chunks of a study: processes of this machine (joblib's loky), or workers of a Dask cluster.

Both are executors of `concurrent.futures`; what differs is how they start, how many chunks they may hold, and what is
lost when a worker dies. Needs the extra 'study' (joblib), for a cluster 'cluster' (dask, distributed).
"""

import logging
import os
import re
import signal
import threading
import time
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, suppress
from importlib import import_module
from importlib.util import find_spec
from multiprocessing.resource_tracker import ensure_running
from queue import Empty
from types import NoneType
from typing import Any, TypeVar

from mrts.base.argument_types import check_type
from mrts.base.errors import InputError
from mrts.program.held_interrupt import held_interrupt

CHUNKS_A_WORKER = 2
"""In flight: one at work, one that waits."""

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""For processes that share the cores among them."""

WATCH_PERIOD = 1.0
"""Between two looks of a worker whether its driver still lives [s]."""

GONE = "is gone, or has dropped this study's work: the same command goes on with what is not solved yet."

CONNECT_TIMEOUT = 10.0
"""For a scheduler to answer [s]."""

REMINDER_PERIOD = 60.0
"""Between two reminders that a cluster has no workers [s]."""

ADDRESS = re.compile(r"(\w+://)?\S+:\d{1,5}|inproc://\S+")
"""What may be a scheduler's: Dask leaves a traceback about anything else."""

LOCAL = "local"
"""Name of a Dask cluster of this machine's processes, made for one study."""

ANY_PORT = "127.0.0.1:0"

Result = TypeVar("Result")
logger = logging.getLogger("mrts")


class LocalProcesses:
    """Processes of this machine; where one dies, all start anew.

    Args:
        workers: How many processes.
    """

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._executor: Any = None

    def slots(self) -> int:
        """How many chunks may be in flight."""
        return CHUNKS_A_WORKER * self._workers

    def submit(self, function: Callable[..., Result], *arguments: Any) -> "Future[Result]":
        """Give a call to a worker; where none can take it any more, the call has died."""
        from joblib.externals.loky import ProcessPoolExecutor  # noqa: PLC0415 (an extra)

        if self._executor is None:
            self._executor = ProcessPoolExecutor(
                self._workers, env=ONE_THREAD, initializer=_leave_with, initargs=(os.getpid(),)
            )
        try:
            with _without_interrupts():
                future: Future[Result] = self._executor.submit(function, *arguments)
        except (BrokenProcessPool, OSError) as error:  # killed before it took the call, or while it was started
            future = Future()
            future.set_exception(BrokenProcessPool(str(error)))
        return future

    def ended(self, running: "Collection[Future[Result]]") -> "Collection[Future[Result]]":
        """Wait until calls have ended: with a worker that dies all that are in flight."""
        done, _ = wait(running, return_when=FIRST_COMPLETED)
        if not any(map(self.died, done)):
            return done
        self.close()
        return list(running)

    def died(self, future: "Future[Any]") -> bool:
        """Whether a call has ended because a worker is gone."""
        from joblib.externals.loky.process_executor import ShutdownExecutorError  # noqa: PLC0415 (an extra)

        return isinstance(future.exception(), BrokenProcessPool | ShutdownExecutorError)

    def close(self) -> None:
        """End the processes, whatever they do."""
        executor, self._executor = self._executor, None
        if executor is not None:
            # loky forgets the calls that wait and then looks up those whose numbers are still queued: a KeyError
            with suppress(Empty):
                while True:
                    executor._work_ids.get_nowait()  # noqa: SLF001 (it has no other way)
            executor.shutdown(kill_workers=True)


class DaskCluster:
    """Workers of a Dask cluster, which starts a lost call elsewhere by itself, some times.

    Args:
        client: Of the scheduler.
        address: For messages.
    """

    def __init__(self, client: Any, address: str) -> None:
        self._client, self._address = client, address
        self._executor = client.get_executor(pure=False)

    def slots(self) -> int:
        """How many chunks may be in flight; workers may come and go."""
        return CHUNKS_A_WORKER * max(1, self._threads())

    def submit(self, function: Callable[..., Result], *arguments: Any) -> "Future[Result]":
        """Give a call to a worker."""
        with self._told_if_gone():
            future: Future[Result] = self._executor.submit(function, *arguments)
            return future

    def ended(self, running: "Collection[Future[Result]]") -> "Collection[Future[Result]]":
        """Wait until calls have ended; now and then say that there are no workers."""
        while not (done := wait(running, REMINDER_PERIOD, FIRST_COMPLETED)[0]):
            if not self._threads():
                logger.warning("the cluster at %s has no workers: waiting for them", self._address)
        if any(future.cancelled() for future in done):  # not by us
            raise InputError("scheduler", GONE, value=self._address)
        return done

    def died(self, future: "Future[Any]") -> bool:
        """Whether a call has ended because workers are gone, as many as the scheduler's `allowed-failures`."""
        from distributed.scheduler import KilledWorker  # noqa: PLC0415 (an extra)

        return isinstance(future.exception(), KilledWorker)

    def _threads(self) -> int:
        with self._told_if_gone():
            return sum(self._client.nthreads().values())

    @contextmanager
    def _told_if_gone(self) -> Iterator[None]:
        """Say that the scheduler is gone, in place of what Dask raises where it is asked for something."""
        try:
            yield
        except (OSError, RuntimeError):
            raise InputError("scheduler", GONE, value=self._address) from None


WorkerPool = LocalProcesses | DaskCluster


def check_workers(workers: int | None, scheduler: str | None) -> None:
    """Check what `worker_pool` is to be asked, before any work.

    Raises:
        InputError: If a package lacks, or the two make no sense.
    """
    check_type("workers", workers, int, NoneType)
    check_type("scheduler", scheduler, str, NoneType)
    if workers is not None and workers < 1:
        raise InputError("workers", "must be at least 1.", value=workers)
    if scheduler not in {None, LOCAL} and workers is not None:
        raise InputError("workers", "goes with processes of this machine: a cluster has its own.", value=workers)
    package, extra = ("joblib", "study") if scheduler is None else ("distributed", "cluster")
    if find_spec(package) is None:
        where = "workers" if scheduler is None else "scheduler"
        raise InputError(where, f"needs {package}: pip install 'mrts[{extra}]'.", value=scheduler)


@contextmanager
def worker_pool(workers: int | None, scheduler: str | None) -> Iterator[WorkerPool]:
    """The workers of a study, gone when the block ends.

    Args:
        workers: How many processes; None for one a core. Not for a cluster that is there already.
        scheduler: Address of a Dask scheduler; `LOCAL` starts one with workers on this machine; None takes loky.

    Raises:
        InputError: If no scheduler answers.
    """
    with ExitStack() as stack:
        if scheduler is None:
            from joblib import cpu_count  # noqa: PLC0415 (an extra)

            pool = LocalProcesses(workers or cpu_count())
            stack.callback(_uninterrupted, pool.close)
            yield pool
        else:
            yield _dask_cluster(stack, workers, scheduler)


def _dask_cluster(stack: ExitStack, workers: int | None, scheduler: str) -> DaskCluster:
    """The workers of a cluster, made first for `LOCAL`."""
    if scheduler != LOCAL and not ADDRESS.fullmatch(scheduler):
        rule = "no Dask scheduler answers there: it is no address. Name one as tcp://HOST:PORT, or local."
        raise InputError("scheduler", rule, value=scheduler)
    dask, distributed = import_module("dask"), import_module("distributed")
    for talkative in map(logging.getLogger, ("distributed", "distributed.client")):  # workers that come and go
        stack.callback(talkative.setLevel, talkative.level)
        talkative.setLevel(logging.CRITICAL)
    address: Any = scheduler
    if scheduler == LOCAL:
        # a worker that dies again and again would else be given up
        stack.enter_context(dask.config.set({"distributed.deploy.lost-worker-timeout": "1 day"}))
        with _without_interrupts():
            address = distributed.LocalCluster(
                n_workers=workers, threads_per_worker=1, dashboard_address=ANY_PORT, silence_logs=logging.CRITICAL
            )
        stack.callback(_uninterrupted, address.close)
    try:
        client = distributed.Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            "scheduler", f"no Dask scheduler answers there: {error}. Start one, or name it as tcp://HOST:PORT.",
            value=scheduler,
        ) from None  # fmt: skip
    stack.callback(_uninterrupted, client.close)
    return DaskCluster(client, scheduler)


def _uninterrupted(close: Callable[[], None]) -> None:
    with held_interrupt():
        close()


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
