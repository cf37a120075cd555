# SPDX-License-Identifier: MIT
"""Arrays that C reads and writes, and threads that share the samples of a call among them."""

import ctypes
import os
import threading
from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

INFINITY = 1e300
"""What an absent limit is in C, or its negative; `MRTS_INFINITY` of numbers.h."""

MOST_THREADS = 2
"""More than this gains little: the work of a sample is a few microseconds."""


KNOWN_SIZES = 1024
"""Sizes of work arrays that are kept, of the libraries asked last: each call would ask C for its own again."""


FREED = 1 << 24
"""Bytes of the block that is freed once. The system's C library keeps twice as many for later arrays."""


def keep_freed_memory() -> None:
    """Let memory that arrays give back serve the next ones: fresh pages cost as much as what is computed into them.

    glibc gives memory back to the system at once until a large block has been freed, then it keeps twice that size
    (mallopt(3), M_MMAP_THRESHOLD). Elsewhere nothing changes.
    """
    np.empty(FREED, dtype=np.uint8)  # nobody writes to it, so it takes no page


def work_arrays(library: ctypes.CDLL, function: str, *sizes: int) -> list[NDArray[Any]]:
    """The work arrays, reals and ints, that a function of the kernel says it wants.

    Args:
        library: Holds the function and its `_work`.
        function: Its name.
        sizes: What its `_work` takes.
    """
    reals, ints = _work(library, function, sizes)
    return [np.zeros(reals), np.zeros(ints, dtype=np.int32)]


@lru_cache(maxsize=KNOWN_SIZES)
def _work(library: ctypes.CDLL, function: str, sizes: tuple[int, ...]) -> tuple[int, int]:
    reals, ints = ctypes.c_longlong(), ctypes.c_longlong()
    getattr(library, f"{function}_work")(*sizes, ctypes.byref(reals), ctypes.byref(ints))
    return reals.value, ints.value


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def over_chunks(library: ctypes.CDLL, samples: int, run: Callable[[int, int], None]) -> None:
    """Deal whole chunks of samples to a few threads: foreign calls let others run.

    The kernel starts cold at each chunk, so the number of threads does not change a result.

    Args:
        library: Says how long a chunk is.
        samples: N.
        run: Takes the first sample of a piece and how many it has; what it raises is raised here.
    """
    chunk = int(library.mrts_chunk())
    chunks = -(-samples // chunk)
    threads = max(1, min(MOST_THREADS, _processors(), chunks))
    bounds = [min(samples, chunk * (chunks * part // threads)) for part in range(threads + 1)]
    pieces = [(first, last - first) for first, last in pairwise(bounds) if last > first]
    failures: list[BaseException] = []

    def guarded(first: int, count: int) -> None:
        try:
            run(first, count)
        except BaseException as error:  # noqa: BLE001 (raised again below, in the caller's thread)
            failures.append(error)

    workers = [threading.Thread(target=guarded, args=piece) for piece in pieces[1:]]
    for worker in workers:
        worker.start()
    for piece in pieces[:1]:
        guarded(*piece)
    for worker in workers:
        worker.join()
    if failures:
        raise failures[0]


def interruptible(call: Callable[[], int]) -> int:
    """What a foreign call returns, where Ctrl-C need not wait for it.

    Python runs handlers of signals between its own instructions, so a long call runs in a thread of its own, which an
    interrupt leaves behind: it may finish, in memory that it keeps.
    """
    returned: list[int] = []
    worker = threading.Thread(target=lambda: returned.append(call()), daemon=True)
    worker.start()
    worker.join()
    return returned[0]
