# SPDX-License-Identifier: MIT
"""What the command line prints: answers on standard output, remarks and errors on standard error.

Whatever a user's files hold, only printable text, line breaks and the escapes of this file reach the terminal.
"""

import codecs
import io
import logging
import os
import shutil
import sys
import textwrap
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Literal, TextIO

from mrts.base.errors import InputError
from mrts.base.printable import printable

Style = Literal["plain", "strong", "bad", "note"]

CODES: dict[Style, str] = {"strong": "\x1b[1m", "bad": "\x1b[1;31m", "note": "\x1b[33m"}
"""ANSI escapes; "plain" has none."""

CLEAR_LINE = "\r\x1b[K"

SPELT_OUT = str.maketrans({"²": "^2", "∈": "in", "×": "x", "≤": "<=", "≥": ">=", "∞": "inf", "−": "-"})
"""What stands for a letter in ASCII, where Unicode knows none."""

LEAST_WIDTH = 40
"""A terminal that says it is narrower is written as if it were this wide [columns]."""

HANGING = "  "
"""Before what a line goes on with."""

QUIET: ContextVar[bool] = ContextVar("quiet", default=False)
"""Whether only errors are printed, and what was asked for by `-`."""

DEBUG: ContextVar[bool] = ContextVar("debug", default=False)
"""Whether the traceback of a defect is printed."""


def open_closed_streams() -> None:
    """Give a process that was started without standard streams (`>&-`) ones again, in order.

    A file that is opened later would else become the standard output, and the answer would go into it. Writing to a
    closed standard output fails as it would in any program; to a closed standard error, it is lost.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            opened = os.open(os.devnull, os.O_WRONLY if name == "stderr" else os.O_RDONLY)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
            mode = "r" if name == "stdin" else "w"
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115 (as Python's own)


def encode_anything() -> None:
    """Let the streams print what their encoding lacks in ASCII: c^2 for c², `?` for what has none."""
    codecs.register_error("mrts_ascii", _in_ascii)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="mrts_ascii")


def _in_ascii(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = unicodedata.normalize("NFKD", error.object[error.start : error.end].translate(SPELT_OUT))
    return "".join(letter if letter.isascii() else "?" for letter in text), error.end


def say(text: str, style: Style = "plain") -> None:
    """Print lines of the answer for people, on a terminal with breaks between words; nothing with --quiet."""
    if not QUIET.get():
        _print(_painted(_wrapped(printable(text, lines=True), sys.stdout), style, sys.stdout))


def _wrapped(text: str, stream: TextIO) -> str:
    """The text in lines that a terminal can hold, each broken between words only; as it is for another reader."""
    if not stream.isatty():
        return text
    width = max(LEAST_WIDTH, shutil.get_terminal_size().columns)
    lines = []
    for line in text.split("\n"):
        start = line[: len(line) - len(line.lstrip())] + HANGING
        wrap = textwrap.TextWrapper(width, subsequent_indent=start, break_long_words=False, break_on_hyphens=False)
        lines.append(line if len(line) <= width else wrap.fill(line))
    return "\n".join(lines)


def put(text: str) -> None:
    """Print what was asked for by `-` in place of a file, with --quiet as well.

    Raises:
        InputError: If standard output cannot be written.
        BrokenPipeError: If its reader went away.
    """
    _print(printable(text, lines=True))


def _print(text: str) -> None:
    with _standard_output():
        print(text)


def flush_answer() -> None:
    """Hand over what has been printed; raises as `put`."""
    with _standard_output():
        sys.stdout.flush()


def warn(text: str) -> None:
    """Print a remark beside the answer; nothing with --quiet."""
    if not QUIET.get():
        _remark(f"mrts: {text}", "note")


def fail(text: str) -> None:
    """Print why there is no answer."""
    _remark(f"mrts: {text}", "bad")


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


def fail_raw(text: str) -> None:
    """Print text as it is, such as a traceback that was asked for."""
    with _lost_if_closed():
        print(text, file=sys.stderr)


def is_terminal(stream: TextIO) -> bool:
    """Whether a stream is a terminal that understands escapes."""
    return stream.isatty() and os.environ.get("TERM") != "dumb"


@contextmanager
def _standard_output() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        _discard(sys.stdout)
        if isinstance(error, BrokenPipeError):
            raise
        raise InputError("standard output", f"cannot be written: {error.strerror}.") from None


@contextmanager
def _lost_if_closed() -> Iterator[None]:
    """What cannot be written to standard error is lost: there is no other place to say so."""
    try:
        yield
        sys.stderr.flush()
    except OSError:
        _discard(sys.stderr)


def _discard(stream: TextIO) -> None:
    """Let all further output go nowhere: Python would else complain when it flushes the rest at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def _remark(text: str, style: Style) -> None:
    start = CLEAR_LINE if is_terminal(sys.stderr) else ""  # what progress or a typed ^C left there
    with _lost_if_closed():
        print(start + _painted(_wrapped(printable(text, lines=True), sys.stderr), style, sys.stderr), file=sys.stderr)


def _painted(text: str, style: Style, stream: TextIO) -> str:
    if style == "plain" or "NO_COLOR" in os.environ or not is_terminal(stream):
        return text
    return f"{CODES[style]}{text}\x1b[0m"
