# SPDX-License-Identifier: MIT
"""The phase plane of a retimed path; needs the extra 'plot' (matplotlib)."""

from typing import Any

from matplotlib.axes import Axes

from mrts.drawing.colours import COLOURS
from mrts.drawing.phase_plane import XTITLE, YTITLE, CurveKind, phase_plane
from mrts.figures.style import NotebookFigure, finish, legend_below, plain_text
from mrts.timing.result import RetimingResult

STYLES: dict[CurveKind, dict[str, Any]] = {
    "most": {"color": COLOURS[6], "linewidth": 1, "linestyle": ":"},
    "fastest": {"color": COLOURS[1], "linestyle": "-"},
    "smooth": {"color": COLOURS[4], "linestyle": "-"},
    "constant": {"color": COLOURS[0], "linestyle": "--"},
}


def phase_plane_figure(found: RetimingResult) -> NotebookFigure:
    """Speed along the path: the maximum velocity curve, the fastest profile, the smooth one, the best constant factor.

    Args:
        found: A result with a profile.

    Raises:
        ValueError: If there is none.
    """
    figure = NotebookFigure(figsize=(7.0, 4.6), layout="constrained")
    figure.suptitle(plain_text(f"{found.cell.name}: speed along the path"), fontsize="medium")
    draw_phase_plane(figure.subplots(), found)
    return figure


def draw_phase_plane(axes: Axes, found: RetimingResult) -> None:
    """The same into axes of yours.

    Args:
        axes: Where.
        found: A result with a profile.

    Raises:
        ValueError: If there is none.
    """
    plane = phase_plane(found)
    for number, band in enumerate(plane.controllable):
        axes.fill_between(*band, color=COLOURS[2], alpha=0.15, label="_" if number else "controllable")
    for curve in plane.curves:
        for number, (s, speed) in enumerate(zip(curve.along, curve.speeds, strict=True)):
            axes.plot(s, speed, label=(not number and curve.label) or "_", **STYLES[curve.kind])
    for stop in plane.stops:
        axes.axvline(stop, color=COLOURS[6], alpha=0.3, linewidth=1)
    axes.set_ylim(0, plane.top)
    finish(axes, XTITLE, YTITLE)
    legend_below(axes, columns=2)
