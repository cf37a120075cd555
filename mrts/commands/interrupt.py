# SPDX-License-Identifier: MIT
"""Ctrl-C that arrives."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SOON = 0.02
"""Until an interrupt inside CasADi is tried again [s]."""

AGAIN = 0.2
"""Until an interrupt that somebody swallowed is raised again [s]: longer than tidying up takes."""


@contextmanager
def persistent_interrupt() -> Iterator[None]:
    """Let Ctrl-C end the block, whatever library is at work.

    Python's own interrupt is swallowed by every bare `except:`. CasADi's operators have them, and go on with another
    meaning of the operands, so it is not raised there; scipy has them while it is imported, so it is raised again.

    Raises:
        KeyboardInterrupt: If Ctrl-C is pressed.
    """
    pressed = False

    def interrupt(_number: int, frame: FrameType | None) -> None:
        nonlocal pressed
        pressed = True
        inside = _inside_casadi(frame)
        signal.setitimer(signal.ITIMER_REAL, SOON if inside else AGAIN)
        if not inside:
            raise KeyboardInterrupt

    def press_again(_number: int, _frame: FrameType | None) -> None:
        signal.raise_signal(signal.SIGINT)  # not `interrupt` itself: whoever holds SIGINT back now is asked

    before = signal.signal(signal.SIGINT, interrupt), signal.signal(signal.SIGALRM, press_again)
    try:
        yield
    except Exception:
        if pressed:  # it arrived as the cause of something else
            raise KeyboardInterrupt from None
        raise
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGINT, before[0])
        signal.signal(signal.SIGALRM, before[1])
    if pressed:
        raise KeyboardInterrupt


def _inside_casadi(frame: FrameType | None) -> bool:
    while frame is not None:
        if str(frame.f_globals.get("__name__")).partition(".")[0] == "casadi":
            return True
        frame = frame.f_back
    return False
