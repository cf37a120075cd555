# SPDX-License-Identifier: MIT
"""Arrays that C reads and writes, and calls that an interrupt leaves."""

import ctypes
import threading
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

INFINITY = 1e300
"""What an absent limit is in C, or its negative; `MRTS_INFINITY` of numbers.h."""

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
