# SPDX-License-Identifier: MIT
"""Ctrl-C that asks a search to come to its end, and a second one that means it."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def stop_request() -> Iterator[list[int]]:
    """Note the first interrupt instead of raising it; the next does what it did before.

    Yields:
        The number of the signal, once it has arrived; empty before. Signals arrive in the main thread only.
    """
    asked: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield asked
        return
    before = signal.getsignal(signal.SIGINT)

    def interrupt(number: int, frame: FrameType | None) -> None:
        if not asked:
            asked.append(number)
        elif callable(before):
            before(number, frame)

    signal.signal(signal.SIGINT, interrupt)
    try:
        yield asked
    finally:
        signal.signal(signal.SIGINT, before)
