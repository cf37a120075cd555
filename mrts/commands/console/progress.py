# SPDX-License-Identifier: MIT
"""A sign of life at a terminal while something takes long; gone when it is done."""

import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from mrts.base.printable import printable
from mrts.commands.console.terminal import CLEAR_LINE, QUIET, is_terminal

PATIENCE = 1.0
"""Work that is done sooner shows nothing [s]."""

PERIOD = 0.2
"""Between two writings of the line [s]."""


@contextmanager
def working(what: str) -> Iterator[Callable[..., None]]:
    """Show on standard error, if that is a terminal, that work goes on, once it has taken a second.

    Yields:
        To be told how many of how many pieces are done, and a note; where nobody tells, time alone is shown.
    """
    if QUIET.get() or not is_terminal(sys.stderr):
        yield lambda *_: None
        return
    line = _Line(printable(what))
    line.start()
    from mrts.base.held_interrupt import held_interrupt

    try:
        yield line.update
    finally:
        with held_interrupt():  # Ctrl-C comes again until it is obeyed: the line is taken away all the same
            line.done.set()
            line.join()


class _Line(threading.Thread):
    def __init__(self, what: str) -> None:
        super().__init__(daemon=True)
        self.what, self.count, self.done = what, "", threading.Event()

    def update(self, done: int, total: int, note: str = "") -> None:
        self.count = f" {done} of {total};{f' {note};' if note else ''}"

    def run(self) -> None:
        begun, pause = time.monotonic(), PATIENCE
        while not self.done.wait(pause):
            pause = PERIOD
            text = f"{self.what} …{self.count} {time.monotonic() - begun:.0f} s"
            self._write(text[: shutil.get_terminal_size().columns - 1])  # a second line would stay
        if pause == PERIOD:
            self._write("")

    def _write(self, text: str) -> None:
        sys.stderr.write(CLEAR_LINE + text)
        sys.stderr.flush()
