# SPDX-License-Identifier: MIT
"""Signs of life at a terminal while something takes long; gone when it is done."""

import shutil
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, Protocol

from mrts.base.printable import printable
from mrts.console.terminal import CLEAR_LINE, QUIET, is_terminal

if TYPE_CHECKING:
    from rich.progress import Progress

PATIENCE = 1.0
"""Work that is done sooner shows nothing [s]."""


class Update(Protocol):
    """To be told how many of how many pieces are done, and what else is worth a few words."""

    def __call__(self, done: int, total: int, note: str = "") -> None:
        """Tell."""


@contextmanager
def working(what: str) -> Iterator[Update]:
    """Show on standard error, if that is a terminal, that work goes on, once it has taken a second.

    Args:
        what: What is done: "scaling lift.yaml".

    Yields:
        To be told how many of how many pieces are done; where nobody tells, time alone is shown.
    """
    if QUIET.get() or not is_terminal(sys.stderr):
        yield lambda done, total, note="": None  # noqa: ARG005 (names of a protocol)
        return
    display: _Display = (_Line if find_spec("rich") is None else _Bar)(printable(what))
    timer = threading.Timer(PATIENCE, display.start)
    timer.daemon = True
    timer.start()
    from mrts.program.held_interrupt import held_interrupt

    try:
        yield display.update
    finally:
        with (
            held_interrupt()
        ):  # Ctrl-C comes again until it is obeyed: a bar that just begins is taken away all the same
            timer.cancel()
            timer.join()
            display.stop()


def _count(done: int, total: int, note: str) -> str:
    return f"{done} of {total}; {note}" if note else f"{done} of {total}"


class _Display(Protocol):
    def start(self) -> None: ...
    def update(self, done: int, total: int, note: str = "") -> None: ...
    def stop(self) -> None: ...


class _Bar:
    """A bar by rich, which is imported only when it is shown."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.done: int = 0
        self.total: int | None = None
        self.progress: Progress | None = None

    def start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        columns = (
            SpinnerColumn(),
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            TextColumn("{task.fields[count]}"),
            TimeElapsedColumn(),
        )
        progress = Progress(*columns, console=Console(stderr=True), transient=True)
        progress.add_task(self.what, completed=self.done, total=self.total, count="")
        progress.start()
        self.progress = progress

    def update(self, done: int, total: int, note: str = "") -> None:
        self.done, self.total = done, total
        if self.progress is not None:
            task = self.progress.task_ids[0]
            self.progress.update(task, completed=done, total=total, count=_count(done, total, note))

    def stop(self) -> None:
        if self.progress is not None:
            self.progress.stop()


class _Line:
    """One line, rewritten, where rich is not installed."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.count = "…"
        self.shown = False

    def start(self) -> None:
        self.shown = True
        text = f"{self.what} {self.count}"[: shutil.get_terminal_size().columns - 1]  # a second line would stay
        sys.stderr.write(CLEAR_LINE + text)
        sys.stderr.flush()

    def update(self, done: int, total: int, note: str = "") -> None:
        self.count = f"… {_count(done, total, note)}"
        if self.shown:
            self.start()

    def stop(self) -> None:
        if self.shown:
            sys.stderr.write(CLEAR_LINE)
            sys.stderr.flush()
