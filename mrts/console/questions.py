# SPDX-License-Identifier: MIT
"""Questions at a terminal; where there is none, nobody is asked."""

import sys

from mrts.base.errors import InputError
from mrts.base.printable import printable
from mrts.console.terminal import QUIET


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
    try:
        typed = input(printable(shown, lines=True)).strip()
    except EOFError:
        raise InputError("standard input", "ended before the question was answered.") from None
    return typed or default
