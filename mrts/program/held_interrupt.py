# SPDX-License-Identifier: MIT
"""Ctrl-C held back while a library works that would swallow it."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def held_interrupt() -> Iterator[None]:
    """Let an interrupt take effect when the block ends: inside IPOPT, CasADi takes it for a failed evaluation.

    Raises:
        KeyboardInterrupt: At the end, if Ctrl-C was pressed inside.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals arrive in the main thread only
        return
    pressed: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _frame: pressed.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed:
        raise KeyboardInterrupt
