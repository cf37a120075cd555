# SPDX-License-Identifier: MIT
"""Questions at a terminal; where there is none, nobody is asked."""

import select
import sys

from mrts.base.errors import InputError
from mrts.base.printable import printable
from mrts.console.terminal import QUIET

LOOK_UP = 0.1
"""Until a question that waits looks whether it is to end [s]."""


def can_ask() -> bool:
    """Whether somebody sits there to answer."""
    return sys.stdin.isatty() and sys.stdout.isatty() and not QUIET.get()


def ask(question: str, default: str = "") -> str:
    """What a user types; the default if nothing.

    Args:
        question: Without a question mark or colon at its end.
        default: Shown in brackets.

    Raises:
        InputError: If the input ends.
    """
    shown = f"{question} [{default}]: " if default else f"{question}: "
    sys.stdout.write(printable(shown, lines=True))
    sys.stdout.flush()
    while not select.select([sys.stdin], [], [], LOOK_UP)[0]:
        pass  # Python's own input() would wait on, if Ctrl-C came just before it waits
    line = sys.stdin.readline()
    if not line:
        raise InputError("standard input", "ended before the question was answered.")
    return line.strip() or default
