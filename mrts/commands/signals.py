# SPDX-License-Identifier: MIT
"""Ctrl-C that arrives, and the other signals that ask a program to end."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SOON = 0.02
"""Until an interrupt inside CasADi is tried again [s]."""

AGAIN = 0.5
"""Until an interrupt that somebody swallowed is raised again [s]: longer than tidying up takes on a busy machine."""

LIKE_INTERRUPT = (signal.SIGTERM, signal.SIGHUP)
"""End the work as Ctrl-C does, with files tidied up; SIGHUP comes when a terminal is closed."""


@contextmanager
def persistent_interrupt() -> Iterator[None]:
    """Let Ctrl-C end the block, whatever library is at work, and `LIKE_INTERRUPT` as well.

    Python's own interrupt is swallowed by every bare `except:`. CasADi's operators have them, and go on with another
    meaning of the operands, so it is not raised there; scipy has them while it is imported, so it is raised again.

    Raises:
        KeyboardInterrupt: If a signal asks for the end, with its number.
    """
    asked: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        asked.append(number)
        inside = _inside_casadi(frame)
        signal.setitimer(signal.ITIMER_REAL, SOON if inside else AGAIN)
        if not inside:
            raise KeyboardInterrupt

    def press_again(_number: int, _frame: FrameType | None) -> None:
        signal.raise_signal(signal.SIGINT)  # not `interrupt` itself: whoever holds SIGINT back now is asked

    def end(number: int, _frame: FrameType | None) -> None:
        asked.append(number)
        signal.raise_signal(signal.SIGINT)  # likewise

    handlers = {signal.SIGINT: interrupt, signal.SIGALRM: press_again}
    handlers |= {each: end for each in LIKE_INTERRUPT if signal.getsignal(each) is not signal.SIG_IGN}  # as nohup asks
    before = {each: signal.signal(each, handler) for each, handler in handlers.items()}
    try:
        yield
    except (Exception, KeyboardInterrupt, SystemExit):
        if asked:  # it may have arrived as the cause of something else
            raise KeyboardInterrupt(asked[0]) from None
        raise
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        for each, handler in before.items():
            signal.signal(each, handler)
    if asked:
        raise KeyboardInterrupt(asked[0])


def _inside_casadi(frame: FrameType | None) -> bool:
    while frame is not None:
        if str(frame.f_globals.get("__name__")).partition(".")[0] == "casadi":
            return True
        frame = frame.f_back
    return False
