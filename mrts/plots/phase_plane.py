# SPDX-License-Identifier: MIT
"""The phase plane of a retimed path: speed along its arc length."""

from collections.abc import Sequence

import numpy as np

from mrts.base.arrays import Array
from mrts.base.colours import COLOURS
from mrts.plots.plot import ADMISSIBLE, Axis, Band, Item, Line, Panel, Plot, one_panel, upright
from mrts.timing.result import RetimingResult, TimedPiece

HEADROOM = 1.35
"""The maximum velocity curve goes out of the picture above this multiple of the profile."""


def phase_plane_plot(found: RetimingResult) -> Plot:
    """The maximum velocity curve, the fastest profile, the smooth one, the best constant factor.

    Raises:
        ValueError: If there is no profile.
    """
    if not found.pieces:
        raise ValueError("there is no profile to draw")
    smooth, best, along = found.smooth, found.factor, way(found.pieces)
    lines: list[Item] = []
    fastest = found.pieces if smooth is None else smooth.fastest
    if fastest:
        label = f"fastest, {found.duration:.4g} s"
        if smooth is not None:
            label = f"fastest without limits of rates, {smooth.bound:.4g} s"
        lines.append(_line(label, way(fastest), [part.along_arc(part.x) for part in fastest], COLOURS[1]))
    if smooth is not None:
        speeds = [part.along_arc(part.x) for part in found.pieces]
        lines.append(_line(f"{found.what}, {found.duration:.4g} s", along, speeds, COLOURS[4], width=2.4))
    if best.c2 is not None:
        speeds = [np.sqrt(best.c2) * part.piece.speed for part in found.pieces]
        lines.append(_line(f"best constant c, {best.duration:.4g} s", along, speeds, COLOURS[0], dash=1))
    top = HEADROOM * max(float(np.nanmax(line.y)) for line in lines if isinstance(line, Line))
    items: list[Item] = []
    profiles = [part.profile for part in fastest if part.profile]
    for s, part, profile in zip(way(fastest), fastest, profiles, strict=True):
        sides = part.along_arc(profile.lower), part.along_arc(profile.upper)
        label = "" if items else "controllable"
        items.append(Band(x=s, lower=sides[0], upper=sides[1], label=label, color=ADMISSIBLE, opacity=0.15))
    if fastest:
        items += _most(fastest, [profile.regions.upper for profile in profiles], top)
    x = Axis(label="path s (rms over the joints) [rad or m]", hover="s = {}")
    y = Axis(label="speed ṡ [rad/s or m/s]", ends=(0.0, top))
    items += [*lines, *(upright(float(s[0]), y) for s in along[1:])]
    title = f"{found.cell.name}: speed along the path (phase plane)"
    return one_panel("phase_plane", Panel(title=title, x=x, y=y, items=items), "way")


def way(pieces: Sequence[TimedPiece]) -> list[Array]:
    """Way from the start of the motion at the samples of every piece of the path."""
    starts = np.cumsum([0.0, *(part.piece.arc[-1] for part in pieces)])
    return [start + part.piece.arc for start, part in zip(starts, pieces, strict=False)]


def played_way(found: RetimingResult) -> Array:
    """Way along the path at the samples of the retimed motion, Shape (N,)."""
    first, *others = way(found.pieces)
    return np.concatenate([first, *(part[1:] for part in others)])


def _most(pieces: Sequence[TimedPiece], bounds: Sequence[Array], top: float) -> list[Item]:
    finite = [np.where(np.isfinite(most), most, np.nan) for most in bounds]
    speeds = [part.along_arc(most) for part, most in zip(pieces, finite, strict=True)]
    seen = any(bool(np.any(speed <= top)) for speed in speeds)
    return [_line("maximum velocity curve", way(pieces), speeds, COLOURS[6], dash=3, width=1.0)] if seen else []


def _line(
    label: str, s: Sequence[Array], speeds: Sequence[Array], color: str, dash: int = 0, width: float = 1.5
) -> Line:
    x, y = (np.concatenate([np.append(part, np.nan) for part in parts])[:-1] for parts in (s, speeds))
    return Line(x=x, y=y, label=label, color=color, dash=dash, width=width)
