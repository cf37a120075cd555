# SPDX-License-Identifier: MIT
"""A path by a parameter in which a timing from rest with limited rates is regular: the time of a quintic."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import between_samples, denser
from mrts.program.path_program import third_derivatives
from mrts.timing.path_pieces import PLACES, NoPath, PathPiece, by_parameter, path_pieces

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
        stops: Whether its timing is at rest at its start, and at its end.
        fine: The path at its nodes and between them, K samples.
        nodes: Which of them are the nodes, indices of Shape (n,).
        third: q''' at the start and at the end of each of their segments, Shape (K - 1, 2, m).
        given_time: Of them, in the given motion, Shape (K,) [s].
    """

    stops: tuple[bool, bool]
    fine: CoordinatedMotion
    nodes: NDArray[np.int_]
    third: Array
    given_time: Array

    @property
    def third_at_nodes(self) -> Array:
        """Q''' at the start and at the end of every segment between nodes, Shape (n - 1, 2, m)."""
        return np.stack([self.third[self.nodes[:-1], 0], self.third[self.nodes[1:] - 1, 1]], axis=1)

    @property
    def inside(self) -> NDArray[np.int_]:
        """Which samples of `fine` are not nodes, Shape (K - n,)."""
        return np.setdiff1d(np.arange(self.fine.samples), self.nodes)


@dataclass(frozen=True)
class FineMotion:
    """A motion at its nodes and between them.

    Attributes:
        motion: K samples.
        is_node: Shape (K,).
        follows: Whether accelerations between the nodes are those of the motion, not only between those at the nodes.
    """

    motion: CoordinatedMotion
    is_node: NDArray[np.bool_]
    follows: bool


def fine_motion(cell: Cell, nodes: CoordinatedMotion) -> FineMotion:
    """A motion with places between its nodes, where jerk and limits are looked at.

    Args:
        cell: The cell.
        nodes: The motion at its nodes.

    Raises:
        MotionError: If the arms cannot hold the object there.
    """
    time = nodes.object.time
    added = (time[:-1, None] + np.diff(time)[:, None] * PLACES).ravel()
    more = between_samples(cell, nodes, added)
    whole = denser(nodes, more, np.arange(1, len(added) + 1, dtype=np.intp))
    follows = nodes.course is not None or nodes.object.course is not None
    return FineMotion(whole, np.isin(whole.object.time, time), follows)


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


def _only(motion: CoordinatedMotion, chosen: NDArray[np.bool_] | NDArray[np.int_]) -> CoordinatedMotion:
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


def smooth_path(given: FineMotion, piece: PathPiece, end_speeds: tuple[float, float], slower: float) -> SmoothPath:
    """A piece by σ, the time in which a quintic from stop to stop goes its way.

    Where it is at rest q' = q'' = 0 by σ: q goes with σ³, as from rest with a limited rate it goes with t³, so that ṡ²
    by σ is finite and not zero.

    Args:
        given: The motion.
        piece: A piece of it by arc length, K samples.
        end_speeds: At the start and at the end of the whole motion.
        slower: The σ that the piece takes, as a multiple of the time that it is given.
    """
    own = slice(piece.first, piece.first + len(piece.speed))
    time, nodes = given.motion.object.time[own], np.flatnonzero(given.is_node[own])
    at_rest, path = stops(piece, end_speeds), piece.path
    s, duration = path.object.time, slower * float(time[-1] - time[0])
    z = QUINTICS[at_rest].inverse(s / s[-1])
    first, second, third = (s[-1] / duration**order * QUINTICS[at_rest].at(z, order) for order in (1, 2, 3))
    for place, stopped in zip((0, -1), at_rest, strict=True):
        if stopped:
            first[place] = second[place] = 0.0
    fine = by_parameter(path, z * duration, first, second)
    turns = third_derivatives(np.diff(s), path.dq, path.ddq)
    if not given.follows:
        turns = _between_nodes(s, nodes, third_derivatives(np.diff(s[nodes]), path.dq[nodes], path.ddq[nodes]))
    sides = np.stack([np.arange(len(s) - 1), np.arange(1, len(s))], axis=1)
    by, by2, by3 = (of[sides][..., None] for of in (first, second, third))
    return SmoothPath(
        first=int(np.count_nonzero(given.is_node[: piece.first])),
        path=_only(fine, nodes),
        speed=piece.speed[nodes],
        rests=piece.rests,
        continued=np.flatnonzero(np.isin(nodes, piece.continued)),
        arc=s[nodes],
        arc_speed=first[nodes],
        stops=at_rest,
        fine=fine,
        nodes=nodes,
        third=turns * by**3 + 3 * path.ddq[sides] * by * by2 + path.dq[sides] * by3,
        given_time=time,
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


def _between_nodes(s: Array, nodes: NDArray[np.int_], third: Array) -> Array:
    """Values at both ends of segments between nodes, linear in between, at both ends of every finer segment."""
    segment = np.searchsorted(nodes, np.arange(len(s) - 1), side="right") - 1
    start, length = s[nodes[segment]], np.diff(s[nodes])[segment]
    share = (np.stack([s[:-1], s[1:]], axis=1) - start[:, None]) / length[:, None]
    values: Array = third[segment, :1] + (third[segment, 1:] - third[segment, :1]) * share[..., None]
    return values
