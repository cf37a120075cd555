# SPDX-License-Identifier: MIT
"""An HTML document with plots: everything in one file that fetches nothing."""

import gzip
import json
from base64 import b85encode
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any

from mrts.base.errors import InputError
from mrts.plots.plot import Plot
from mrts.plots.plotly_drawer import plotly_figure
from mrts.report.markup import Html, contents, element, html, joined, plot_place

Plots = dict[str, dict[str, Any]]
"""What a document draws, as plotly reads it, by its place."""


@cache
def plot_library() -> str:
    """The text of plotly.js, packed: it is nearly all of a page.

    Raises:
        InputError: If plotly is not installed.
    """
    try:
        from plotly.offline import get_plotlyjs  # noqa: PLC0415 (the extra 'report')
    except ModuleNotFoundError:
        raise InputError("report", "needs plotly: pip install 'mrts[report]'.") from None
    return packed(get_plotlyjs())


def packed(text: str) -> str:
    """Text for a script element of the page, compressed: base 85 of gzip, with "," for "<", which could end it.

    Args:
        text: Any.

    Returns:
        The same for the same text.
    """
    return b85encode(gzip.compress(text.encode(), mtime=0)).decode().replace("<", ",")


def placed(plots: Plots, *drawn: Plot) -> Html:
    """Plots beside each other, which become those of the document.

    Args:
        plots: Of the document.
        *drawn: What is added to them.
    """
    return element("div", joined(place_figure(plots, plot.name, plot.title, plotly_figure(plot)) for plot in drawn),
                   class_="plots")  # fmt: skip


def place_figure(plots: Plots, name: str, title: str, figure: dict[str, Any]) -> Html:
    """Where a figure of plotly goes, which becomes one of the document."""
    plots[f"plot-{name}"] = figure
    return plot_place(f"plot-{name}", title, figure["layout"]["height"])


def document(
    title: str,
    head: str,
    pieces: Sequence[str],
    plots: Plots,
    **data: Mapping[str, Any],
) -> str:
    """A document that opens offline; the same parts give the same text.

    Args:
        title: Of the window.
        head: What stands above all, HTML.
        pieces: HTML; the sections among them are listed.
        plots: What is drawn into their places of the body.
        **data: What its script needs beside the plots.

    Raises:
        InputError: If plotly is not installed.
    """
    library = plot_library()
    text = packed(json.dumps({"plots": plots, **data}, allow_nan=False, separators=(",", ":")))
    compiles = any(trace.get("type") == "parcoords" for plot in plots.values() for trace in plot["data"])
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy(compiles=compiles)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="generator" content="mrts">
<title>{html(title)}</title>
<style>
{_file("report.css")}</style>
</head>
<body>
<header>
<button id="theme" type="button" hidden>Dark</button>
{html(head)}
<p id="drawing" class="note">Plots are drawn by a browser of 2024 or later that may run scripts.</p>
</header>
{contents(pieces)}
<main>
{joined(pieces)}
</main>
<script type="text/plain" id="plot-library">{library}</script>
<script type="text/plain" id="report-data">{text}</script>
<script>
{_file("report.js")}</script>
</body>
</html>
"""


def policy(*, compiles: bool) -> str:
    """What the browser lets the page do: nothing from outside.

    Args:
        compiles: Whether the page may compile scripts: plotly's parallel coordinates do.
    """
    scripts = "'unsafe-inline' 'unsafe-eval'" if compiles else "'unsafe-inline'"
    return f"default-src 'none'; script-src {scripts}; style-src 'unsafe-inline'; img-src data: blob:"


def _file(name: str) -> str:
    return (files("mrts") / "report" / name).read_text(encoding="utf-8")
