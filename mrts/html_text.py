# SPDX-License-Identifier: MIT
"""Text from anywhere as HTML."""

from html import escape

from mrts.printable import printable


def html_text(text: str) -> str:
    """Text for the content of an element or between quotes in a tag: without markup, printable."""
    return escape(printable(text, lines=True))
