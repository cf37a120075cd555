# SPDX-License-Identifier: MIT
"""What the command line prints: answers on standard output, remarks and errors on standard error.

Whatever a user's files hold, only printable text, line breaks and the escapes of this file reach the terminal.
"""

import logging
import os
import sys
from contextvars import ContextVar
from typing import Literal, TextIO

from mrts.printable import printable

Style = Literal["plain", "strong", "bad", "note"]

CODES: dict[Style, str] = {"strong": "\x1b[1m", "bad": "\x1b[1;31m", "note": "\x1b[33m"}
"""ANSI escapes; "plain" has none."""

CLEAR_LINE = "\r\x1b[K"

QUIET: ContextVar[bool] = ContextVar("quiet", default=False)
"""Whether only errors are printed, and what was asked for by `-`."""


def say(text: str, style: Style = "plain") -> None:
    """Print a line of the answer for people; nothing with --quiet."""
    if not QUIET.get():
        print(_painted(printable(text, lines=True), style, sys.stdout))


def put(text: str) -> None:
    """Print what was asked for by `-` in place of a file, with --quiet as well."""
    print(printable(text, lines=True))


def warn(text: str) -> None:
    """Print a remark beside the answer; nothing with --quiet."""
    if not QUIET.get():
        _remark(f"mrts: {text}", "note")


def fail(text: str) -> None:
    """Print why there is no answer."""
    _remark(f"mrts: {text}", "bad")


class RemarkHandler(logging.Handler):
    """Prints what the library logs as remarks."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print a record."""
        warn(record.getMessage())


def is_terminal(stream: TextIO) -> bool:
    """Whether a stream is a terminal that understands escapes."""
    return stream.isatty() and os.environ.get("TERM") != "dumb"


def _remark(text: str, style: Style) -> None:
    start = CLEAR_LINE if is_terminal(sys.stderr) else ""  # what progress or a typed ^C left there
    print(start + _painted(printable(text, lines=True), style, sys.stderr), file=sys.stderr)


def _painted(text: str, style: Style, stream: TextIO) -> str:
    if style == "plain" or "NO_COLOR" in os.environ or not is_terminal(stream):
        return text
    return f"{CODES[style]}{text}\x1b[0m"
