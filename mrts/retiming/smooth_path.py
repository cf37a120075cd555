# SPDX-License-Identifier: MIT
"""A path by a parameter in which a timing from rest with limited rates is regular: the time of a quintic."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.coordination.denser_motion import between_samples, denser
from mrts.motion.object_motion import ObjectMotion
from mrts.retiming.path_pieces import NoPath, PathPiece, path_pieces
from mrts.samples.motor_terms import travel_directions

LEAST_NODES = 60
"""Nodes of a piece where the given motion has fewer samples."""

FINE = 32
"""Points of each segment by which the places of nodes are found; a node need not be anywhere exactly."""

MOST_TURNS = 60
"""Bisections that find σ of an arc length: more than a double has digits."""


@dataclass(frozen=True, kw_only=True)
class SmoothPath(PathPiece):
    """A piece of a path whose `path` has σ for time.

    Attributes:
        arc: Arc length s at the nodes, Shape (n,).
        arc_speed: ds/dσ, Shape (n,).
        stops: Whether its timing is at rest at its start, and at its end.
    """

    arc: Array
    arc_speed: Array
    stops: tuple[bool, bool]


@dataclass(frozen=True)
class _Quintic:
    """The share of the way at the share z of the time, least in jerk, from rest or from full speed and likewise to.

    Attributes:
        coefficients: Of rising powers of z, from z⁰.
    """

    coefficients: tuple[float, ...]

    def at(self, z: Array, order: int = 0) -> Array:
        """The polynomial or one of its derivatives.

        Args:
            z: Anywhere in [0, 1].
            order: Of the derivative.
        """
        polynomial = np.polynomial.Polynomial(self.coefficients)
        return np.asarray((polynomial.deriv(order) if order else polynomial)(z))

    def inverse(self, share: Array) -> Array:
        """The z at which the share of the way is done, by bisection.

        Args:
            share: Rising from 0 to 1, Shape (n,).
        """
        low, high = np.zeros(len(share)), np.ones(len(share))
        for _ in range(MOST_TURNS):
            middle = (low + high) / 2
            below = self.at(middle) < share
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        high[0], high[-1] = 0.0, 1.0
        return high


QUINTICS = {
    (True, True): _Quintic((0, 0, 0, 10, -15, 6)),
    (True, False): _Quintic((0, 0, 0, 2, -1)),
    (False, True): _Quintic((0, 2, 0, -2, 1)),
    (False, False): _Quintic((0, 1)),
}
"""By whether the motion is at rest at the start and at the end: there the way grows with the cube of z."""


def stops(piece: PathPiece, end_speeds: tuple[float, float]) -> tuple[bool, bool]:
    """Whether a timing is at rest at the ends of a piece: where the motion is, and where no speed is asked for.

    Args:
        piece: The piece.
        end_speeds: At the start and at the end of the whole motion.
    """
    start, end = (rests or speed == 0 for rests, speed in zip(piece.rests, end_speeds, strict=True))
    return start, end


def smooth_nodes(cell: Cell, motion: CoordinatedMotion, end_speeds: tuple[float, float]) -> CoordinatedMotion | NoPath:
    """The same motion at nodes that are evenly spaced in σ, as many as it has samples but not too few.

    Args:
        cell: The cell.
        motion: Its motion, N samples.
        end_speeds: At its start and at its end.

    Raises:
        MotionError: If the arms cannot hold the object there.
    """
    pieces = path_pieces(motion)
    if isinstance(pieces, NoPath):
        return pieces
    given, times, kept = motion.object.time, [], [0]
    for piece in pieces:
        n, s = len(piece.speed), piece.path.object.time
        time = given[piece.first : piece.first + n]
        places = np.linspace(0, 1, max(n, LEAST_NODES))[1:-1]
        fine, way = _way(time, s, piece.speed)
        wanted = np.interp(s[-1] * QUINTICS[stops(piece, end_speeds)].at(places), way, fine)
        times.append(wanted[(wanted > time[0]) & (wanted < time[-1])])
        kept.append(piece.first + n - 1)
    added = np.unique(np.concatenate(times))
    added = added[~np.isin(added, given)]
    more = between_samples(cell, motion, added)
    whole = denser(motion, more, np.arange(1, len(added) + 1, dtype=np.intp))
    chosen = np.isin(whole.object.time, np.concatenate([added, given[kept]]))
    return _only(whole, chosen)


def _way(time: Array, s: Array, speed: Array) -> tuple[Array, Array]:
    """Finely spaced times and the arc length there, a cubic polynomial by its values and slopes on each segment."""
    h, u = np.diff(time)[:, None], np.arange(FINE) / FINE
    rise = np.diff(s)[:, None]
    start, end = (h * speed[side, None] for side in (slice(None, -1), slice(1, None)))
    way = s[:-1, None] + u * start + u**2 * (3 * rise - 2 * start - end) + u**3 * (start + end - 2 * rise)
    fine = time[:-1, None] + h * u
    rising = np.maximum.accumulate(np.append(way.ravel(), s[-1]))
    return np.append(fine.ravel(), time[-1]), rising


def _only(motion: CoordinatedMotion, chosen: NDArray[np.bool_]) -> CoordinatedMotion:
    """Some samples of a motion, at their times."""
    of = motion.object
    carried = replace(
        of,
        time=of.time[chosen],
        position=of.position[chosen],
        rotation=of.rotation[chosen],
        twist=of.twist[chosen],
        acceleration=of.acceleration[chosen],
        smooth=False,
        remarks=(),
    )
    travel = None if motion.travel is None else motion.travel[:, chosen]
    return CoordinatedMotion(
        carried, motion.q[chosen], motion.dq[chosen], motion.ddq[chosen], travel=travel, course=motion.course
    )


def smooth_path(piece: PathPiece, duration: float, end_speeds: tuple[float, float]) -> SmoothPath:
    """A piece by σ, the time in which a quintic from stop to stop goes its way.

    Where it is at rest q' = q'' = 0 by σ: q goes with σ³, as from rest with a limited rate it goes with t³, so that ṡ²
    by σ is finite and not zero.

    Args:
        piece: The piece by arc length, n samples.
        duration: Of the quintic [s].
        end_speeds: At the start and at the end of the whole motion.
    """
    at_rest, path = stops(piece, end_speeds), piece.path
    quintic = QUINTICS[at_rest]
    s = path.object.time
    z = quintic.inverse(s / s[-1])
    first = s[-1] / duration * quintic.at(z, 1)
    second = s[-1] / duration**2 * quintic.at(z, 2)
    for place, stopped in zip((0, -1), at_rest, strict=True):
        if stopped:
            first[place] = second[place] = 0.0

    def by_sigma(rates: Array, changes: Array) -> tuple[Array, Array]:
        return rates * first[:, None], changes * first[:, None] ** 2 + rates * second[:, None]

    given = path.object
    dq, ddq = by_sigma(path.dq, path.ddq)
    twist, acceleration = by_sigma(given.twist, given.acceleration)
    carried = ObjectMotion(z * duration, given.position, given.rotation, twist, acceleration, smooth=False)
    travel = np.stack(travel_directions(path.dq, path.ddq))
    joined = CoordinatedMotion(carried, path.q, dq, ddq, travel=travel)
    return SmoothPath(
        piece.first, joined, piece.speed, piece.rests, piece.continued, arc=s, arc_speed=first, stops=at_rest
    )


def joined_at_stops(pieces: Sequence[SmoothPath]) -> list[SmoothPath]:
    """The same pieces, each knowing at a stop how every joint travels on the other side of it.

    So the torques at a stop are the same before and after it: of a joint that turns back there, without dry friction.

    Args:
        pieces: All of a path.
    """
    travels = [np.array(piece.path.travel) for piece in pieces]
    for before, after in pairwise(travels):
        before[1, -1], after[0, 0] = after[1, 0], before[0, -1]
    return [
        replace(piece, path=replace(piece.path, travel=travel)) for piece, travel in zip(pieces, travels, strict=True)
    ]
