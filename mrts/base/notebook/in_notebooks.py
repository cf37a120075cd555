# SPDX-License-Identifier: MIT
"""A class whose values a notebook shows as a sentence and tables."""

import inspect
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cache

from mrts.base.notebook.value_text import value_text, words_of
from mrts.base.printable import html_text

MOST_ROWS = 24
"""Of a table; the rest is counted."""


@dataclass(frozen=True)
class NotebookTable:
    """A table of texts.

    Attributes:
        head: Titles of the columns.
        rows: Texts of each row, the first of which names it.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[str]]


class InNotebooks:
    """What Jupyter shows: what `notebook_words` says, and the tables of `notebook_tables`.

    Without more, these are the object in words, and its attributes, each with what its class says of it.
    """

    def _repr_html_(self) -> str:
        return notebook_html(self.notebook_words(), self.notebook_tables())

    def notebook_words(self) -> list[str]:
        """The answer, a paragraph each."""
        name, words = type(self).__name__, words_of(self)
        return [words if words.startswith(name) else ": ".join(filter(None, [name, words]))]

    def notebook_tables(self) -> Iterator[NotebookTable]:
        """Tables below it."""
        meanings = attribute_meanings(inspect.getdoc(type(self)) or "")
        own: list[str] = [entry.name for entry in fields(self)] if is_dataclass(self) else []
        rows = [(name, value_text(getattr(self, name)), meanings[name]) for name in own if name in meanings]
        yield NotebookTable(("attribute", "value", "meaning"), rows)


def notebook_html(words: Sequence[str], tables: Iterator[NotebookTable]) -> str:
    """Paragraphs and tables, escaped.

    Args:
        words: A text each paragraph.
        tables: Below them.
    """
    paragraphs = "".join(f"<p style='max-width:50em'>{html_text(text)}</p>" for text in words)
    return f"<div>{paragraphs}{''.join(map(_table, tables))}</div>"


def _table(table: NotebookTable) -> str:
    hidden = len(table.rows) - MOST_ROWS
    rows = [_row("td", row) for row in table.rows[:MOST_ROWS]]
    more = f"<p>… and {hidden} more</p>" if hidden > 0 else ""
    head = _row("th", table.head) if any(table.head) else ""
    return f"<table>{head}{''.join(rows)}</table>{more}"


def _row(tag: str, texts: Sequence[str]) -> str:
    first, *others = texts
    left = "style='text-align:left'"
    cells = "".join(f"<{tag} {left}>{html_text(text)}</{tag}>" for text in others)
    return f"<tr><th {left}>{html_text(first)}</th>{cells}</tr>"


@cache
def attribute_meanings(docstring: str) -> dict[str, str]:
    """What the docstring of a class says of each attribute.

    Args:
        docstring: In Google style, as `inspect.getdoc` gives it.
    """
    _, _, listed = docstring.partition("Attributes:\n")
    meanings: dict[str, str] = {}
    name = ""
    for line in listed.splitlines():
        if not line.startswith("    "):
            break
        entry = re.fullmatch(r" {4}(\w+): (.+)", line)
        if entry:
            name = entry[1]
            meanings[name] = entry[2]
        elif name:
            meanings[name] += f" {line.strip()}"
    return meanings
