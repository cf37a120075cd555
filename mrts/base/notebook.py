# SPDX-License-Identifier: MIT
"""A class whose values a notebook shows as a sentence and tables."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mrts.base.errors import html_text

MOST_ROWS = 24


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

    Without more, these are what Python shows of it, and no table.
    """

    def _repr_html_(self) -> str:
        return notebook_html(self.notebook_words(), self.notebook_tables())

    def notebook_words(self) -> list[str]:
        """The answer, a paragraph each."""
        return [repr(self).removeprefix("<").removesuffix(">")]

    def notebook_tables(self) -> Iterator[NotebookTable]:
        """Tables below it."""
        yield from ()


def notebook_html(words: Sequence[str], tables: Iterator[NotebookTable]) -> str:
    """Paragraphs and tables, escaped."""
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
