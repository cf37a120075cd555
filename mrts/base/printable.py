# SPDX-License-Identifier: MIT
"""Text that came from outside, made safe to show: escaped, and cut where it is very long."""

import re
from html import escape

LONGEST_WORD = 300

LONGEST_MESSAGE = 4000


def printable(text: str, *, lines: bool = False) -> str:
    r"""Text without control characters, marks of direction, and signs that cannot be seen: written as \u001b.

    The escapes are those of JSON, so that JSON stays JSON.
    """
    if text.isprintable():
        return text
    return "".join(letter if letter.isprintable() or (lines and letter == "\n") else _escape(letter) for letter in text)


def message_text(text: str, *, lines: bool = False) -> str:
    """A message for people: printable, and without the middle of what is very long."""
    words = re.sub(rf"\S{{{LONGEST_WORD + 1},}}", lambda word: cut(word.group(), LONGEST_WORD), text)
    return printable(cut(words, LONGEST_MESSAGE), lines=lines)


def cut(text: str, longest: int) -> str:
    """Text whose middle is left out where it is too long."""
    return text if len(text) <= longest else f"{text[: longest // 2]}…{text[-(longest // 2 - 1) :]}"


def _escape(letter: str) -> str:
    short = {"\n": "\\n", "\r": "\\r", "\t": "\\t"}.get(letter)
    if short is not None:
        return short
    units = letter.encode("utf-16-be", "surrogatepass")
    return "".join(f"\\u{units[at : at + 2].hex()}" for at in range(0, len(units), 2))


def html_text(text: str) -> str:
    """Text for the content of an HTML element or between quotes in a tag: without markup, printable."""
    return escape(printable(text, lines=True))
