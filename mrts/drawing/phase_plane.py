# SPDX-License-Identifier: MIT
"""The curves of the phase plane of a retimed path: speed along its arc length."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.timing.result import RetimingResult
from mrts.timing.retimed_motion import FastestPiece, TimedPiece
from mrts.timing.smooth_piece import fastest_pieces

HEADROOM = 1.35
"""The maximum velocity curve goes out of the picture above this multiple of the profile."""

XTITLE = "path s (root mean square of the joints' way) [rad or m]"
YTITLE = "speed ṡ [rad/s or m/s]"

CurveKind = Literal["most", "fastest", "smooth", "constant"]


@dataclass(frozen=True)
class PhaseCurve:
    """One curve, in pieces from stop to stop.

    Attributes:
        kind: The maximum velocity curve, the fastest profile, the smooth one, or the best constant factor.
        label: Its name; empty where nothing of it is in the picture.
        along: Way from the start of the motion at the samples of each piece.
        speeds: ṡ there; NaN where nothing bounds it.
    """

    kind: CurveKind
    label: str
    along: tuple[Array, ...]
    speeds: tuple[Array, ...]


@dataclass(frozen=True)
class PhasePlane:
    """What the picture shows.

    Attributes:
        curves: From the back to the front.
        controllable: Way, least and largest controllable ṡ at the samples of each piece; empty where not known.
        stops: Where the motion stops on its way.
        top: Largest ṡ of the picture.
    """

    curves: tuple[PhaseCurve, ...]
    controllable: tuple[tuple[Array, Array, Array], ...]
    stops: tuple[float, ...]
    top: float


def phase_plane(found: RetimingResult) -> PhasePlane:
    """The maximum velocity curve, the fastest profile, the smooth one, the best constant factor.

    Args:
        found: A result with a profile.

    Raises:
        ValueError: If there is none.
    """
    if not found.pieces:
        raise ValueError("there is no profile to draw")
    smooth, best, along = found.smooth, found.factor, way(found.pieces)
    curves: list[PhaseCurve] = []
    fastest = fastest_pieces(found.pieces) if smooth is None else smooth.fastest
    if fastest:
        label = f"fastest, {found.duration:.4g} s"
        if smooth is not None:
            label = f"fastest without limits of rates, {smooth.bound:.4g} s"
        curves += [_most(fastest), _speeds("fastest", label, fastest)]
    if smooth is not None:
        curves.append(_speeds("smooth", f"{smooth.what}, {found.duration:.4g} s", found.pieces))
    if best.c2 is not None:
        speeds = tuple(np.sqrt(best.c2) * part.piece.speed for part in found.pieces)
        curves.append(PhaseCurve("constant", f"best constant c, {best.duration:.4g} s", along, speeds))
    top = HEADROOM * max(float(np.max(part)) for curve in curves if curve.kind != "most" for part in curve.speeds)
    controllable = tuple(
        (s, part.along_arc(part.profile.lower), part.along_arc(part.profile.upper))
        for s, part in zip(way(fastest), fastest, strict=True)
    )
    return PhasePlane(tuple(curves), controllable, tuple(float(s[0]) for s in along[1:]), top)


def way(pieces: Sequence[TimedPiece]) -> tuple[Array, ...]:
    """Way from the start of the motion at the samples of every piece.

    Args:
        pieces: The path from stop to stop.
    """
    starts = np.cumsum([0.0, *(part.piece.arc[-1] for part in pieces)])
    return tuple(start + part.piece.arc for start, part in zip(starts, pieces, strict=False))


def _speeds(kind: CurveKind, label: str, pieces: Sequence[TimedPiece]) -> PhaseCurve:
    return PhaseCurve(kind, label, way(pieces), tuple(part.arc_speed for part in pieces))


def _most(pieces: Sequence[FastestPiece]) -> PhaseCurve:
    top = HEADROOM * max(float(np.max(part.arc_speed)) for part in pieces)
    bounds = [(part, part.profile.regions.upper) for part in pieces]
    speeds = tuple(part.along_arc(np.where(np.isfinite(most), most, np.nan)) for part, most in bounds)
    seen = any(bool(np.any(speed <= top)) for speed in speeds)
    return PhaseCurve("most", "maximum velocity curve" if seen else "", way(pieces), speeds)
