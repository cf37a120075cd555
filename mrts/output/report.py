# SPDX-License-Identifier: MIT
"""An HTML document with plots: everything in one file that fetches nothing."""

import gzip
import json
from base64 import b85encode
from functools import cache
from importlib.resources import files
from typing import Any

from mrts.base.errors import printable, require_extra
from mrts.plots.plot import Plot, one_panel
from mrts.plots.plotly_drawer import plotly_figure


@cache
def plot_library() -> str:
    """The text of plotly.js, packed: it is nearly all of a page."""
    from plotly.offline import get_plotlyjs  # noqa: PLC0415 (the extra 'report')

    return packed(get_plotlyjs())


def packed(text: str) -> str:
    """Text for a script element of the page: base 85 of gzip, with "," for "<", which could end it."""
    return b85encode(gzip.compress(text.encode(), mtime=0)).decode().replace("<", ",")


def document(template: str, title: str, data: dict[str, Any], **context: Any) -> str:
    """A document that opens offline; the same parts give the same text.

    `template` has its head and its sections, `data` is what its script needs beside the plots, `context` what the
    template names.

    Raises:
        InputError: If plotly or Jinja is not installed.
    """
    require_extra("report", "report", "jinja2", "plotly")
    from jinja2 import Environment, PackageLoader, StrictUndefined  # noqa: PLC0415 (the extra 'report')

    plots: dict[str, dict[str, Any]] = {}

    def place(name: str, drawn: dict[str, Any]) -> str:
        """The identifier of a figure's place; it becomes one of the document."""
        plots[f"plot-{name}"] = drawn
        return f"plot-{name}"

    def packed_data() -> str:
        return packed(json.dumps({"plots": plots, **data}, allow_nan=False, separators=(",", ":")))

    environment = Environment(
        loader=PackageLoader("mrts.output"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        extensions=["jinja2.ext.do"],
        finalize=lambda value: printable(value, lines=True) if type(value) is str else value,  # else it is HTML
    )
    environment.filters["sentence"] = _sentence
    return environment.get_template(template).render(
        title=title,
        contents=[],
        style=_file("report.css"),
        script=_file("report.js"),
        library=plot_library(),
        data=packed_data,
        place=place,
        plotly_figure=plotly_figure,
        separate=_separate,
        **context,
    )


def _separate(plot: Plot) -> list[Plot]:
    """Each panel by itself, unless they share their x axis."""
    panels = [panel for row in plot.rows for panel in row]
    if plot.shared or len(panels) == 1:
        return [plot]
    return [one_panel(f"{plot.name}-{number}", panel, plot.clock) for number, panel in enumerate(panels)]


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}." if text else ""


def _file(name: str) -> str:
    return (files("mrts") / "output" / name).read_text(encoding="utf-8")
