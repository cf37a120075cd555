# SPDX-License-Identifier: MIT
"""What a retimed motion answers: what it saves, what limits it for how long, the phase plane."""

import numpy as np

from mrts.base.arrays import Array
from mrts.drawing.colours import ADMISSIBLE, COLOURS
from mrts.drawing.labels import shortened
from mrts.drawing.phase_plane import YTITLE, CurveKind, phase_plane, way
from mrts.report.document import Place
from mrts.report.markup import Html, Section, bar, element, section, table
from mrts.report.plots import Plot, layout, line
from mrts.timing.result import RetimingResult

MOST_LIMITS = 12
"""Limits that are listed; the rest is counted."""

PHASE_HEIGHT = 420
"""[px]."""

TITLE = "Speed along the path s, the root mean square of the joints' way (phase plane)"

LOOKS: dict[CurveKind, dict[str, object]] = {
    "most": {"color": COLOURS[6], "dash": "dot", "width": 1},
    "fastest": {"color": COLOURS[1], "dash": "solid"},
    "smooth": {"color": COLOURS[4], "dash": "solid"},
    "constant": {"color": COLOURS[0], "dash": "dash"},
}


def timing_section(found: RetimingResult, place: Place) -> Section:
    """The timing beside the best constant factor, what limits it, and the phase plane.

    Args:
        found: A result with a profile.
        place: Where plots are put.
    """
    heads = ("timing", "duration", "of the given time", "")
    note = element("p", _note(found), class_="note")
    plane = place(phase_plane_plot(found))
    return section("timing", "The timing", table(heads, _durations(found)), *_limits(found), note, plane)


def _durations(found: RetimingResult) -> list[tuple[str, ...]]:
    given, best, smooth = float(found.motion.object.time[-1]), found.factor, found.smooth
    longest = max(given, found.duration or 0.0, best.duration or 0.0)

    def row(name: str, duration: float | None, more: str = "") -> tuple[str, ...]:
        if duration is None:
            return (name, "none", "", more)
        return (name, f"{duration:.4g} s", bar(duration / longest, words=f"{100 * duration / given:.4g} %"), more)

    rows = [row(smooth.what if smooth is not None else "fastest timing", found.duration, _saving(found))]
    if smooth is not None and smooth.bound is not None:
        rows.append(row("fastest without limits of rates", smooth.bound, "no timing takes less"))
    at = "" if best.c2 is None else f"c² = {best.c2:.4g}"
    return [*rows, row("best constant factor", best.duration, at), row("as given", given)]


def _saving(found: RetimingResult) -> str:
    if found.saving is None:
        return ""
    less = "less" if found.saving >= 0 else "more"
    return f"{100 * abs(found.saving):.3g} % {less} than the best constant factor"


def _limits(found: RetimingResult) -> list[Html]:
    rows = [(name, bar(share)) for name, share in found.limits[:MOST_LIMITS]]
    rest = len(found.limits) - MOST_LIMITS
    more = [element("p", f"… and {rest} more limits.")] if rest > 0 else []
    return [table(("what limits the speed", "for this share of the duration"), rows), *more] if rows else []


def _note(found: RetimingResult) -> str:
    stops = f" It stops {len(found.stops)} times on its way." if len(found.stops) > 1 else ""
    return f"Several limits may bind at once.{stops} Below: the speed along the path."


def phase_plane_plot(found: RetimingResult) -> Plot:
    """Speed along the path, as `mrts.figures.phase_plane_figure`.

    Args:
        found: A result with a profile.
    """
    plane = phase_plane(found)
    traces = []
    for number, (s, lower, upper) in enumerate(plane.controllable):
        sides = [line(s, side, "controllable", 0, None, width=0) | {"legendgroup": "sides"} for side in (lower, upper)]
        sides[0] |= {"showlegend": False}
        sides[1] |= {"showlegend": not number, "fill": "tonexty", "fillcolor": f"{ADMISSIBLE}26"}
        traces += sides
    for curve in plane.curves:
        s, speed = _joined(curve.along), _joined(curve.speeds)
        named = line(s, speed, shortened(curve.label), 0, "", **LOOKS[curve.kind])
        traces.append(named | {"showlegend": bool(curve.label), "connectgaps": False})
    shape = layout("path s [rad or m]", YTITLE, (0.0, plane.top))
    shape["xaxis"]["unifiedhovertitle"] = {"text": "s = %{x:.4g}"}
    stop = {"type": "line", "yref": "paper", "y0": 0, "y1": 1, "layer": "below", "line": {"width": 1, "color": "#888"}}
    shape["shapes"] = [stop | {"x0": at, "x1": at} for at in plane.stops]
    return Plot("phase-plane", TITLE, traces, shape, PHASE_HEIGHT, "way")


def played_way(found: RetimingResult) -> Array:
    """Way along the path at the samples of the retimed motion, Shape (N,).

    Args:
        found: A result with a profile.
    """
    first, *others = way(found.pieces)
    return np.concatenate([first, *(part[1:] for part in others)])


def _joined(parts: tuple[Array, ...]) -> Array:
    """Values of pieces one after the other, with a gap between them."""
    return np.concatenate([np.append(part, np.nan) for part in parts])[:-1]
