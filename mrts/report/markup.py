# SPDX-License-Identifier: MIT
"""Pieces of HTML. What comes from a user is escaped here: pieces take text and give HTML."""

from collections.abc import Iterable, Sequence

from mrts.base.printable import html_text


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


class Section(Html):
    """A section of the page, which the contents list.

    Attributes:
        name: Its identifier in the page.
        heading: Its heading.
    """

    __slots__ = ("heading", "name")
    heading: str
    name: str


def section(name: str, title: str, *content: str) -> Section:
    """A section with its heading."""
    whole = Section(element("section", joined([element("h2", title), *content]), id=name))
    whole.name, whole.heading = name, title
    return whole


def contents(pieces: Iterable[str]) -> Html:
    """The list of the sections among pieces of a page, each a link.

    Args:
        pieces: In their order.
    """
    links = [element("a", piece.heading, href=f"#{piece.name}") for piece in pieces if isinstance(piece, Section)]
    return element("nav", element("ul", joined(element("li", link) for link in links)), id="contents")


def bar(share: float, digits: int = 0, words: str = "", state: str = "") -> Html:
    """A share as a bar with its percentage.

    Args:
        share: 1 fills it.
        digits: Decimals of the percentage.
        words: What is written instead of it.
        state: A class of its filling.
    """
    filled = element("div", "", class_=f"fill {state}".rstrip(), style=f"width:{100 * min(share, 1):.1f}%")
    return joined([element("div", filled, class_="bar"), html(words or f"{100 * share:.{digits}f} %")])


def plot_place(name: str, title: str, height: int) -> Html:
    """Where a plot of the page goes, under its heading.

    Args:
        name: Of the plot.
        title: The heading.
        height: [px].
    """
    place = element("div", "", id=name, style=f"height:{height}px")
    return element("figure", joined([element("figcaption", title), place]))
