# SPDX-License-Identifier: MIT
"""A path by a parameter in which a timing from rest with limited rates is regular: the time of a quintic."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.path_program import third_derivatives
from mrts.timing.path_pieces import PLACES, NoPath, PathPiece, by_parameter, path_pieces, with_samples

LEAST_NODES = 60
"""Nodes of a piece where the given motion has fewer samples."""

FINE = 32
"""Points of each segment by which the places of nodes are found; a node need not be anywhere exactly."""

MOST_TURNS = 60
"""Bisections that find σ of an arc length: more than a double has digits."""


STRIDE = len(PLACES) + 1
"""Samples from node to node of a motion that has places between its nodes."""

QUINTICS = {
    (True, True): Polynomial((0, 0, 0, 10, -15, 6)),
    (True, False): Polynomial((0, 0, 0, 2, -1)),
    (False, True): Polynomial((0, 2, 0, -2, 1)),
    (False, False): Polynomial((0, 1)),
}
"""The share of the way at a share of the time, least in jerk, by whether the motion is at rest at the start and at the
end: there the way grows with the cube of the time."""


@dataclass(frozen=True, kw_only=True)
class SmoothPath(PathPiece):
    """A piece of a path whose `path` has σ for time.

    Attributes:
        stops: Whether its timing is at rest at its start, and at its end.
        fine: The path at its nodes and between them, every `STRIDE`th of K samples a node.
        third: q''' at the start and at the end of each of their segments, Shape (K - 1, 2, m).
    """

    stops: tuple[bool, bool]
    fine: CoordinatedMotion
    third: Array

    @property
    def inside(self) -> NDArray[np.int_]:
        """Which samples of `fine` are not nodes, Shape (K - n,)."""
        return np.flatnonzero(np.arange(self.fine.samples) % STRIDE)


def _inverse(rising: Polynomial, share: Array) -> Array:
    """Where a polynomial reaches shares that rise from 0 to 1, Shape (n,), by bisection."""
    low, high = np.zeros(len(share)), np.ones(len(share))
    for _ in range(MOST_TURNS):
        middle = (low + high) / 2
        below = rising(middle) < share
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    high[0], high[-1] = 0.0, 1.0
    return high


def stops(piece: PathPiece, end_speeds: tuple[float, float]) -> tuple[bool, bool]:
    """Whether a timing is at rest at the ends of a piece: where the motion is, and where no speed is asked for."""
    start, end = (rests or speed == 0 for rests, speed in zip(piece.rests, end_speeds, strict=True))
    return start, end


def smooth_nodes(cell: Cell, motion: CoordinatedMotion, end_speeds: tuple[float, float]) -> CoordinatedMotion | NoPath:
    """The same motion at nodes that are evenly spaced in σ, as many as it has samples but not too few.

    Raises:
        MotionError: If the arms cannot hold the object there.
    """
    pieces = path_pieces(motion)
    if isinstance(pieces, NoPath):
        return pieces
    given, times, kept = motion.object.time, [], [0]
    for piece in pieces:
        n, s = len(piece.speed), piece.arc
        time = given[piece.first : piece.first + n]
        places = np.linspace(0, 1, max(n, LEAST_NODES))[1:-1]
        fine, way = _way(time, s, piece.speed)
        wanted = np.interp(s[-1] * QUINTICS[stops(piece, end_speeds)](places), way, fine)
        times.append(wanted[(wanted > time[0]) & (wanted < time[-1])])
        kept.append(piece.first + n - 1)
    added = np.unique(np.concatenate(times))
    added = added[~np.isin(added, given)]
    whole = with_samples(cell, motion, added)
    chosen = np.isin(whole.object.time, np.concatenate([added, given[kept]]))
    of, names = whole.object, ("time", "position", "rotation", "twist", "acceleration")
    carried = replace(of, **{name: getattr(of, name)[chosen] for name in names}, smooth=False, remarks=())
    travel = None if whole.travel is None else whole.travel[:, chosen]
    joints = (whole.q[chosen], whole.dq[chosen], whole.ddq[chosen])
    return CoordinatedMotion(carried, *joints, travel=travel, course=whole.course)


def _way(time: Array, s: Array, speed: Array) -> tuple[Array, Array]:
    """Finely spaced times and the arc length there, a cubic polynomial by its values and slopes on each segment."""
    h, u = np.diff(time)[:, None], np.arange(FINE) / FINE
    rise = np.diff(s)[:, None]
    start, end = (h * speed[side, None] for side in (slice(None, -1), slice(1, None)))
    way = s[:-1, None] + u * start + u**2 * (3 * rise - 2 * start - end) + u**3 * (start + end - 2 * rise)
    fine = time[:-1, None] + h * u
    rising = np.maximum.accumulate(np.append(way.ravel(), s[-1]))
    return np.append(fine.ravel(), time[-1]), rising


def smooth_path(
    motion: CoordinatedMotion, piece: PathPiece, end_speeds: tuple[float, float], slower: float
) -> SmoothPath:
    """A piece by σ, the time in which a quintic from stop to stop goes its way.

    Where it is at rest q' = q'' = 0 by σ: q goes with σ³, as from rest with a limited rate it goes with t³, so that ṡ²
    by σ is finite and not zero.

    Args:
        motion: The motion at its nodes.
        piece: A piece of its `fine_motion` by arc length, K samples.
        end_speeds: At the start and at the end of the whole motion.
        slower: The σ that the piece takes, as a multiple of the time that it is given.
    """
    path, at_rest, nodes = piece.path, stops(piece, end_speeds), np.arange(0, piece.path.samples, STRIDE)
    first_node, s = piece.first // STRIDE, path.object.time
    time = motion.object.time[first_node : first_node + len(nodes)]
    duration, quintic = slower * float(time[-1] - time[0]), QUINTICS[at_rest]
    z = _inverse(quintic, s / s[-1])
    first, second, third = (s[-1] / duration**order * quintic.deriv(order)(z) for order in (1, 2, 3))
    for place, stopped in zip((0, -1), at_rest, strict=True):
        if stopped:
            first[place] = second[place] = 0.0
    turns = third_derivatives(np.diff(s), path.dq, path.ddq)
    if motion.course is None and motion.object.course is None:  # accelerations between nodes are only between theirs
        turns = _between_nodes(s, third_derivatives(np.diff(s[nodes]), path.dq[nodes], path.ddq[nodes]))
    sides = np.stack([np.arange(len(s) - 1), np.arange(1, len(s))], axis=1)
    by, by2, by3 = (of[sides][..., None] for of in (first, second, third))
    return SmoothPath(
        first=first_node,
        path=by_parameter(path.at(nodes), z[nodes] * duration, first[nodes], second[nodes]),
        speed=piece.speed[nodes],
        rests=piece.rests,
        continued=np.flatnonzero(np.isin(nodes, piece.continued)),
        arc=s[nodes],
        arc_speed=first[nodes],
        stops=at_rest,
        fine=by_parameter(path, z * duration, first, second),
        third=turns * by**3 + 3 * path.ddq[sides] * by * by2 + path.dq[sides] * by3,
    )


def joined_at_stops(pieces: Sequence[SmoothPath]) -> list[SmoothPath]:
    """The same pieces, each knowing at a stop how every joint travels on the other side of it.

    So the torques at a stop are the same before and after it: of a joint that turns back there, without dry friction.
    """
    travels = [np.array(piece.path.travel) for piece in pieces]
    for before, after in pairwise(travels):
        before[1, -1], after[0, 0] = after[1, 0], before[0, -1]
    return [
        replace(piece, path=replace(piece.path, travel=travel)) for piece, travel in zip(pieces, travels, strict=True)
    ]


def _between_nodes(s: Array, third: Array) -> Array:
    """Values at both ends of segments between nodes, linear in between, at both ends of every finer segment."""
    segment, nodes = np.arange(len(s) - 1) // STRIDE, s[::STRIDE]
    share = (np.stack([s[:-1], s[1:]], axis=1) - nodes[segment, None]) / np.diff(nodes)[segment, None]
    values: Array = third[segment, :1] + (third[segment, 1:] - third[segment, :1]) * share[..., None]
    return values
