# SPDX-License-Identifier: MIT
"""Ctrl-C that arrives."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

AGAIN = 0.2
"""Until a swallowed interrupt is raised again [s]: longer than tidying up takes."""


@contextmanager
def persistent_interrupt() -> Iterator[None]:
    """Raise Ctrl-C again until it leaves the block: CasADi and scipy swallow every exception while they are imported.

    Raises:
        KeyboardInterrupt: If Ctrl-C is pressed.
    """

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        signal.setitimer(signal.ITIMER_REAL, AGAIN)
        raise KeyboardInterrupt

    def press_again(_number: int, _frame: FrameType | None) -> None:
        signal.raise_signal(signal.SIGINT)  # not `interrupt` itself: whoever holds SIGINT back now is asked

    before = signal.signal(signal.SIGINT, interrupt), signal.signal(signal.SIGALRM, press_again)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGINT, before[0])
        signal.signal(signal.SIGALRM, before[1])
