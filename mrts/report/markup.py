# SPDX-License-Identifier: MIT
"""Pieces of HTML. What comes from a user is escaped here: pieces take text and give HTML."""

from collections.abc import Iterable, Sequence
from html import escape

from mrts.base.printable import html_text, printable


class Html(str):
    """Text that is HTML already."""

    __slots__ = ()


def html(value: str) -> Html:
    """Text as HTML, printable; what is HTML already stays."""
    return value if isinstance(value, Html) else Html(html_text(value))


def element(tag: str, content: str, **attributes: str) -> Html:
    """An element; `class_` and `for_` stand for the attributes `class` and `for`."""
    words = "".join(f' {name.rstrip("_")}="{html_text(value)}"' for name, value in attributes.items())
    return Html(f"<{tag}{words}>{html(content)}</{tag}>")


def joined(pieces: Iterable[str]) -> Html:
    """Pieces one after the other."""
    return Html("\n".join(html(piece) for piece in pieces))


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Html:
    """A table that scrolls sideways where it is too wide.

    Args:
        head: Titles of the columns.
        rows: Cells of each row.
    """
    titles = element("tr", joined(element("th", title, scope="col") for title in head))
    lines = joined(element("tr", joined(element("td", cell) for cell in row)) for row in rows)
    whole = element("table", joined([element("thead", titles), element("tbody", lines)]))
    return element("div", whole, class_="scroll")


def section(name: str, title: str, *content: str) -> Html:
    """A section with its heading."""
    return element("section", joined([element("h2", title), *content]), id=name)


def plot_place(name: str, title: str, height: int) -> Html:
    """Where a plot of the page goes, under its heading.

    Args:
        name: Of the plot.
        title: The heading.
        height: [px].
    """
    place = element("div", "", id=name, style=f"height:{height}px")
    return element("figure", joined([element("figcaption", title), place]))


def plot_text(text: str) -> str:
    """Text for plotly, which reads some HTML in names and labels, and TeX between two $."""
    return escape(printable(text, lines=True), quote=False).replace("$", "&#36;")
