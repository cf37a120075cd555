# SPDX-License-Identifier: MIT
"""Ctrl-C held back while a library works that would swallow it."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def held_interrupt() -> Iterator[list[int]]:
    """Let an interrupt take effect when the block ends: inside IPOPT, CasADi takes it for a failed evaluation.

    Yields:
        The interrupts so far, in the main thread, where signals arrive; a block that obeys them clears it.

    Raises:
        KeyboardInterrupt: At the end, if some are left.
    """
    pressed: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield pressed
        return
    before = signal.signal(signal.SIGINT, lambda number, _frame: pressed.append(number))
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed:
        raise KeyboardInterrupt
