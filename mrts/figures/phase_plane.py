# SPDX-License-Identifier: MIT
"""The phase plane of a retimed path; needs the extra 'plot' (matplotlib)."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mrts.base.arrays import Array
from mrts.drawing.colours import COLOURS
from mrts.figures.style import finish, legend_below
from mrts.retiming.result import RetimingResult
from mrts.retiming.retimed_motion import FastestPiece, TimedPiece
from mrts.retiming.smooth_piece import fastest_pieces

HEADROOM = 1.35
"""The maximum velocity curve goes out of the picture above this multiple of the profile."""


def phase_plane_figure(found: RetimingResult) -> Figure:
    """Speed along the path: the maximum velocity curve, the fastest profile, the smooth one, the best constant factor.

    Args:
        found: A result with a profile.

    Raises:
        ValueError: If there is none.
    """
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    figure.suptitle(f"{found.cell.name}: speed along the path", fontsize="medium")
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
    if not found.pieces:
        raise ValueError("there is no profile to draw")
    smooth, tops = found.smooth, []
    if smooth is None:
        fastest = fastest_pieces(found.pieces)
        tops.append(_draw_fastest(axes, fastest, f"fastest, {found.duration:.4g} s"))
    else:
        if smooth.fastest:
            label = f"fastest without limits of rates, {smooth.bound:.4g} s"
            tops.append(_draw_fastest(axes, smooth.fastest, label))
        speeds = [part.arc_speed for part in found.pieces]
        what = f"{smooth.what}, {found.duration:.4g} s"
        tops.append(_draw_speeds(axes, found.pieces, speeds, what, COLOURS[4], "-"))
    best = found.factor
    if best.c2 is not None:
        speeds = [np.sqrt(best.c2) * part.piece.speed for part in found.pieces]
        label = f"best constant c, {best.duration:.4g} s"
        tops.append(_draw_speeds(axes, found.pieces, speeds, label, COLOURS[0], "--"))
    for s in _along(found.pieces)[1:]:
        axes.axvline(float(s[0]), color=COLOURS[6], alpha=0.3, linewidth=1)
    axes.set_ylim(0, HEADROOM * max(tops))
    finish(axes, "path s (root mean square of the joints' way) [rad or m]", "speed ṡ [rad/s or m/s]")
    legend_below(axes, columns=2)


def _along(pieces: Sequence[TimedPiece]) -> list[Array]:
    """Way from the start of the motion at the samples of every piece."""
    starts = np.cumsum([0.0, *(part.arc[-1] for part in pieces)])
    return [start + part.arc for start, part in zip(starts, pieces, strict=False)]


def _draw_speeds(
    axes: Axes, pieces: Sequence[TimedPiece], speeds: Sequence[Array], label: str, colour: str, dashes: str
) -> float:
    """Speeds of all pieces as one curve of the legend; the largest of them."""
    for number, (s, speed) in enumerate(zip(_along(pieces), speeds, strict=True)):
        axes.plot(s, speed, color=colour, linestyle=dashes, label="_" if number else label)
    return max(float(np.max(speed)) for speed in speeds)


def _draw_fastest(axes: Axes, pieces: Sequence[FastestPiece], label: str) -> float:
    """The fastest profile with what limits it; its largest speed."""
    curve = _in_view(pieces)
    for number, (s, part) in enumerate(zip(_along(pieces), pieces, strict=True)):
        first = number == 0
        most = part.along_arc(np.where(np.isfinite(part.regions.upper), part.regions.upper, np.nan))
        shown = "maximum velocity curve" if first and curve else "_"
        axes.plot(s, most, color=COLOURS[6], linewidth=1, linestyle=":", label=shown)
        sides = part.along_arc(part.profile.lower), part.along_arc(part.profile.upper)
        axes.fill_between(s, *sides, color=COLOURS[2], alpha=0.15, label="controllable" if first else "_")
    return _draw_speeds(axes, pieces, [part.arc_speed for part in pieces], label, COLOURS[1], "-")


def _in_view(pieces: Sequence[FastestPiece]) -> bool:
    """Whether some of the maximum velocity curve is within the picture."""
    top = max(float(np.max(part.arc_speed)) for part in pieces)
    return any(bool(np.any(part.along_arc(part.regions.upper) <= HEADROOM * top)) for part in pieces)
