# SPDX-License-Identifier: MIT
"""What a plot shows, as data: matplotlib draws it for files (`matplotlib_drawer`), plotly for pages (`plotly_drawer`).

Texts are as a user gave them: the drawers make them printable. A `label` stands in the legend unless it is empty,
`texts` are told under the mouse, one a value; of points they stand beside them. Colours are those of the web,
`#rrggbb`; arrays have Shape (N,) unless another is told.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.colours import COLOURS
from mrts.base.errors import cut, printable

ADMISSIBLE, CONFLICT = COLOURS[2], COLOURS[6]
END_COLOURS = {"upper": COLOURS[1], "lower": COLOURS[0], "conflict": CONFLICT}
"""Of c²⁺(t), c²⁻(t), and limits that conflict."""

FARTHEST_LIMIT = 4.0
"""Limits beyond this many times the largest value are left outside: the values would be flat lines."""

RULE: dict[str, Any] = {"color": "#888", "width": 1.0}
"""Look of straight lines across a panel."""

MARGIN = 0.06
"""Left free above and below, as a share of what is shown."""

LONGEST_LABEL = 44
"""Letters of a label."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Line:
    """A curve, with its limits as thin lines of the same look.

    `y`, `lower` and `upper` have gaps where they are not finite. `dash` is the number of its dashes, `width` in pt.
    Without a `unit` (None) it does not answer hovering. Of `steps` a value holds until the next x.
    """

    x: Array
    y: Array
    label: str = ""
    color: str = COLOURS[0]
    dash: int = 0
    width: float = 1.5
    unit: str | None = ""
    lower: Array | None = None
    upper: Array | None = None
    steps: bool = False
    texts: Sequence[str] = ()

    @property
    def limits(self) -> list[Array]:
        """Those that are finite somewhere."""
        return [limit for limit in (self.lower, self.upper) if limit is not None and np.any(np.isfinite(limit))]


@dataclass(frozen=True, eq=False, kw_only=True)
class Points:
    """Marks, each with a text beside it: "circle", "dot" (a small one), "cross" or "star"."""

    x: Array
    y: Array
    symbol: str = "circle"
    label: str = ""
    color: str = COLOURS[0]
    texts: Sequence[str] = ()
    below: bool = False


@dataclass(frozen=True, eq=False, kw_only=True)
class Band:
    """The area between two curves, with a gap where x is NaN."""

    x: Array
    lower: Array
    upper: Array
    label: str = ""
    color: str = "#ddd"
    opacity: float = 1.0


Item = Line | Points | Band


@dataclass(frozen=True, kw_only=True)
class Axis:
    """What an axis counts, or the names along it at 0, 1, … from the top.

    Without `ends` all there is is shown. `colors` and `strong` (bold) are of the names; `hover` is what a value under
    the mouse is called, such as "t = {} s".
    """

    label: str = ""
    ends: tuple[float, float] | None = None
    names: Sequence[str] = ()
    colors: Sequence[str] = ()
    strong: Sequence[bool] = ()
    hover: str = "{}"


@dataclass(frozen=True, kw_only=True)
class Panel:
    """One pair of axes: items are drawn in order, the last one on top; `note` stands in the middle."""

    x: Axis = Axis()
    y: Axis = Axis()
    items: Sequence[Item] = ()
    title: str = ""
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A figure: panels beside each other, in rows below each other; `name` is that of its file or its place in a page.

    Of `shared` the panels of a column have one x axis. `clock` is what that counts in a report, for the cursor:
    "played" is the time of the trajectory, "given" that of the given motion, "way" that along the path.
    """

    name: str
    title: str
    rows: Sequence[Sequence[Panel]]
    shared: bool = False
    clock: str = ""

    def _repr_mimebundle_(self, **_: object) -> dict[str, Any]:
        """For notebooks that can draw with plotly; others, and panels beside each other, have the picture."""
        from mrts.plots.plotly_drawer import plotly_figure  # noqa: PLC0415 (it draws plots)

        if any(len(row) > 1 for row in self.rows):
            return {}
        drawn = plotly_figure(self)
        return {"application/vnd.plotly.v1+json": {"data": drawn["data"], "layout": drawn["layout"]}}

    def _repr_png_(self) -> bytes:
        from mrts.plots.matplotlib_drawer import png  # noqa: PLC0415 (the extra 'plot')

        return png(self)


def shortened(name: str, longest: int = LONGEST_LABEL) -> str:
    """A printable name whose middle is left out where it is too long to stand beside a plot."""
    return cut(printable(name), longest)


def time_axis(time: Array, label: str = "time [s]") -> Axis:
    """An axis of samples at some times, Shape (N,) [s]."""
    return Axis(label=label, ends=(float(time[0]), float(time[-1])), hover="t = {} s")


def upright(at: float, y: Axis, **looks: Any) -> Line:
    """A straight line across a panel, whose y axis has ends, at an x."""
    assert y.ends is not None  # noqa: S101 (it is asked for)
    return Line(x=np.full(2, at), y=np.array(y.ends), unit=None, **RULE | looks)


def level(at: float, x: Axis, **looks: Any) -> Line:
    """A straight line across a panel, whose x axis has ends, at a y."""
    assert x.ends is not None  # noqa: S101 (likewise)
    return Line(x=np.array(x.ends), y=np.full(2, at), unit=None, **RULE | looks)


def rectangles(spans: Sequence[tuple[float, float]], lower: Array | float, upper: Array | float, **looks: Any) -> Band:
    """Areas from a start to an end along x, each between its sides."""
    x = np.insert(np.array(spans, dtype=np.float64), 2, np.nan, axis=1).ravel()
    low, high = (np.repeat(np.broadcast_to(side, len(spans)), 3) for side in (lower, upper))
    return Band(x=x, lower=low, upper=high, **looks)


def one_panel(name: str, panel: Panel, clock: str = "") -> Plot:
    """A plot of one panel, with its title."""
    return Plot(name=name, title=panel.title, rows=[[panel]], clock=clock)


def curves_panel(title: str, label: str, lines: Sequence[Line], below: Sequence[Item] = ()) -> Panel:
    """Curves along time, over other items, on an axis that shows all of them, and limits as far as these are near."""
    sides = [side for line in lines for side in (line.lower, line.upper) if side is not None]
    ends = value_ends(np.concatenate([line.y for line in lines]), np.concatenate([np.empty(0), *sides]))
    return Panel(title=title, x=time_axis(lines[0].x), y=Axis(label=label, ends=ends), items=[*below, *lines])


def look(index: int) -> dict[str, Any]:
    """Colour and dashes of the line with this number."""
    return {"color": COLOURS[index % len(COLOURS)], "dash": index + index // len(COLOURS)}


def value_ends(values: Array, limits: Array) -> tuple[float, float]:
    """Ends of an axis that shows values and their limits."""
    size = float(np.max(np.abs(values), initial=0.0))
    near = limits[np.isfinite(limits) & ((np.abs(limits) <= FARTHEST_LIMIT * size) | (size == 0))]
    shown = np.concatenate([values.ravel(), near.ravel(), [0.0]])
    low, high = float(np.min(shown)), float(np.max(shown))
    margin = MARGIN * (high - low) or 1.0
    return low - margin, high + margin
