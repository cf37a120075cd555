# SPDX-License-Identifier: MIT
"""How a command speaks: answers on standard output or in files; remarks, errors and progress on standard error.

Whatever a user's files hold, only printable text, line breaks and the escapes of this file reach the terminal.
"""

import io
import logging
import os
import shutil
import sys
import textwrap
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import MappingProxyType
from typing import Literal, TextIO

from mrts.base.atomic_file import JsonOutput
from mrts.base.errors import InputError, MrtsError, printable
from mrts.base.regular_file import FILES_READ

FEASIBLE, INFEASIBLE, BAD_INPUT = 0, 1, 2
"""Exit codes; `mrts.cli` has those of commands that end without an answer."""

NOTES = ("note:", "warning:", "hint:")
"""How a line of an answer begins that is a note."""

Style = Literal["plain", "strong", "bad", "note"]

CODES: dict[Style, str] = {"strong": "\x1b[1m", "bad": "\x1b[1;31m", "note": "\x1b[33m"}
"""ANSI escapes; "plain" has none."""

CLEAR_LINE = "\r\x1b[K"

LEAST_WIDTH = 40
"""A terminal that says it is narrower is written as if it were this wide [columns]."""

HANGING = "  "
"""Before what a line goes on with."""

QUIET: ContextVar[bool] = ContextVar("quiet", default=False)
"""Whether only errors are printed, and what was asked for by `-`."""

PATIENCE = 1.0
"""Work that is done sooner shows no progress [s]."""

PERIOD = 0.2
"""Between two writings of progress [s]."""

DEBUG: ContextVar[bool] = ContextVar("debug", default=False)
"""Whether the traceback of a defect is printed."""


def open_closed_streams() -> None:
    """Give a process that was started without standard streams (`>&-`) ones again, in order.

    A file that is opened later would else become the standard output, and the answer would go into it. Writing to a
    closed standard output fails as it would in any program; to a closed standard error, it is lost.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            os.open(os.devnull, os.O_WRONLY if name == "stderr" else os.O_RDONLY)  # its number is the lowest free one
            mode = "r" if name == "stdin" else "w"
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115 (as Python's own)


def encode_anything() -> None:
    """Let the streams print `?` for what their encoding lacks."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def say(text: str, style: Style = "plain") -> None:
    """Print lines of the answer for people, on a terminal with breaks between words; nothing with --quiet."""
    if not QUIET.get():
        _write(_dressed(text, style, sys.stdout), sys.stdout)


def put(text: str) -> None:
    """Print what was asked for by `-` in place of a file, with --quiet as well.

    Raises:
        InputError: If standard output cannot be written.
        BrokenPipeError: If its reader went away.
    """
    _write(printable(text, lines=True), sys.stdout)


def warn(text: str) -> None:
    """Print a remark beside the answer; nothing with --quiet."""
    if not QUIET.get():
        _remark(text, "note")


def fail(text: str) -> None:
    """Print why there is no answer."""
    _remark(text, "bad")


def fail_raw(text: str) -> None:
    """Print text as it is, such as a traceback that was asked for."""
    _write(text, sys.stderr)


def _remark(text: str, style: Style) -> None:
    start = CLEAR_LINE if is_terminal(sys.stderr) else ""  # what progress or a typed ^C left there
    _write(start + _dressed(f"mrts: {text}", style, sys.stderr), sys.stderr)


def _dressed(text: str, style: Style, stream: TextIO) -> str:
    """The text as a terminal shows it: in its style, and in lines that are broken between words only."""
    text = printable(text, lines=True)
    if stream.isatty():
        width = max(LEAST_WIDTH, shutil.get_terminal_size().columns)
        lines = []
        for line in text.split("\n"):
            start = line[: len(line) - len(line.lstrip())] + HANGING
            wrap = textwrap.TextWrapper(width, subsequent_indent=start, break_long_words=False, break_on_hyphens=False)
            lines.append(line if len(line) <= width else wrap.fill(line))
        text = "\n".join(lines)
    if style == "plain" or "NO_COLOR" in os.environ or not is_terminal(stream):
        return text
    return f"{CODES[style]}{text}\x1b[0m"


def _write(text: str, stream: TextIO) -> None:
    """Print now; what cannot be written to standard error is lost: there is no other place to say so."""
    try:
        print(text, file=stream, flush=True)
    except OSError as error:
        nowhere = os.open(os.devnull, os.O_WRONLY)  # Python would else complain when it flushes the rest at its end
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
        if stream is sys.stderr:
            return
        if isinstance(error, BrokenPipeError):
            raise
        raise InputError("standard output", f"cannot be written: {error.strerror}.") from None


class RemarkHandler(logging.Handler):
    """Prints what the library logs as remarks, each once: a cell that is not compiled yet is read twice."""

    def __init__(self) -> None:
        super().__init__()
        self.said: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        """Print a record; not of the reader of meshes, which tells how it parses a URDF that mrts has read already."""
        text = record.getMessage()
        if not record.name.startswith("yourdfpy") and text not in self.said:
            self.said.add(text)
            warn(text)


def is_terminal(stream: TextIO) -> bool:
    """Whether a stream is a terminal that understands escapes."""
    return stream.isatty() and os.environ.get("TERM") != "dumb"


@contextmanager
def working(what: str) -> Iterator[Callable[..., None]]:
    """Show on standard error, if that is a terminal, that work goes on, once it has taken a second.

    Yields:
        To be told how many of how many pieces are done, and a note; where nobody tells, time alone is shown.
    """
    if QUIET.get() or not is_terminal(sys.stderr):
        yield lambda *_: None
        return
    from mrts.base.held_interrupt import held_interrupt

    line = _Progress(printable(what))
    line.start()
    try:
        yield line.update
    finally:
        with held_interrupt():  # Ctrl-C comes again until it is obeyed: the line is taken away all the same
            line.done.set()
            line.join()


class _Progress(threading.Thread):
    """A line that is written again and again, and gone when work is done."""

    def __init__(self, what: str) -> None:
        super().__init__(daemon=True)
        self.what, self.count, self.done = what, "", threading.Event()

    def update(self, done: int, total: int, note: str = "") -> None:
        self.count = f" {done} of {total};{f' {note};' if note else ''}"

    def run(self) -> None:
        begun, text = time.monotonic(), ""
        while not self.done.wait(PERIOD if text else PATIENCE):
            text = f"{self.what} …{self.count} {time.monotonic() - begun:.0f} s"
            self._write(text[: shutil.get_terminal_size().columns - 1])  # a second line would stay
        if text:
            self._write("")

    def _write(self, text: str) -> None:
        sys.stderr.write(CLEAR_LINE + text)
        sys.stderr.flush()


def check_not_read(path: Path) -> None:
    """Check that an output is no file that the command has read."""
    if os.path.realpath(path) in FILES_READ:
        raise InputError(path, "is a file that this command has read: not written. Name another.")


class Outputs:
    """The outputs of a command, each written whatever becomes of the others.

    Args:
        found: The answer, of a command that has `--json`.
        json: What `--json` names; a file is written now.
    """

    def __init__(self, found: JsonOutput | None = None, json: Path | None = None) -> None:
        self.failed = False
        self.written: list[Path] = []
        self.json_text = found.json_text if found is not None and str(json) == "-" else None
        if found is not None and json is not None and self.json_text is None:
            self.write(json, found.write_json)

    def write(self, path: Path, write: Callable[[Path], object]) -> None:
        """Write one output, a file or a folder; if that fails, say so and go on."""
        try:
            check_not_read(path)
            write(path)
            self.written.append(path)
        except MrtsError as error:
            self.failed = True
            fail(f"error: {error}")

    def answer(self, lines: Iterable[str], outcome: int, styles: Mapping[str, Style] = MappingProxyType({})) -> int:
        """Print the answer in words with what was written, or as JSON where `--json -` asks for that; the exit code.

        Args:
            lines: In words, the outcome first.
            outcome: The exit code if all outputs were written.
            styles: Of lines that have one of their own.
        """
        if self.json_text is not None:
            put(self.json_text())
        else:
            first: Style = "strong" if outcome == FEASIBLE else "bad"
            told = list(lines)
            for number, line in enumerate(told):
                say(line, first if number == 0 else "note" if line.startswith(NOTES) else styles.get(line, "plain"))
            if self.written:
                say("\n".join([*([""] if told else []), "written:", *(f"  {path}" for path in self.written)]))
        return BAD_INPUT if self.failed else outcome
