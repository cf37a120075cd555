# SPDX-License-Identifier: MIT
"""The path of a motion without its timing, in pieces from stop to stop: by arc length, or by a quintic.

The last is for smooth timings: by the time of a quintic one that starts from rest with limited rates is regular.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from mrts.base.arrays import Array, row_products
from mrts.base.errors import InputError, MrtsError
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import HERMITE, between_samples, denser
from mrts.following.tracking import nearest_rates
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.rows_at_rest import REST
from mrts.program.motion_rows import travel_directions
from mrts.program.smooth_program import third_derivatives

PLACES = np.array([0.125, 0.375, 0.5, 0.625, 0.875])
"""Where each segment is checked; the error vanishes at its ends."""

NEAR_REST = 1e-3
"""Below this share, q'/|q'| and its derivative lose digits: they are continued from the first faster sample."""

LEAST_NODES = 60
"""Nodes of a piece where the given motion has fewer samples."""

STRAIGHT = 1e-12
"""Half a turn below which a chord is as long as its arc."""

FINE = 32
"""Points of each segment by which the places of nodes are found; a node need not be anywhere exactly."""

PARTS_OF_WAY, NEWTON_STEPS = 1000, 6
"""By these σ of an arc length is found: the first part is 2e-6 of σ, where a quintic is at 1e-16 of the way."""

WAIT = "stands still", "a wait is no part of a path. Cut it out"

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
class PathPiece:
    """Part of a path between two stops or ends, n samples.

    Attributes:
        first: Index of its first sample in the motion.
        path: Its samples with a parameter σ for time: q, dq/dσ, d²q/dσ², and so for the object.
        arc: Arc length s at the samples, from the start of the piece, Shape (n,).
        arc_speed: ds/dσ at the samples, Shape (n,).
        speed: ds/dr at the samples, Shape (n,).
        rests: Whether the motion is at rest at its start, and at its end.
    """

    first: int
    path: CoordinatedMotion
    arc: Array
    arc_speed: Array
    speed: Array
    rests: tuple[bool, bool]

    @cached_property
    def step(self) -> Array:
        """Δσ of each segment, Shape (n - 1,)."""
        return np.diff(self.path.object.time)


@dataclass(frozen=True, kw_only=True)
class SmoothPath(PathPiece):
    """A piece whose samples are the nodes of a smooth timing.

    Attributes:
        fine: The path at its nodes and between them, every `STRIDE`th of K samples a node.
        third: q''' at the start and at the end of each of their segments, Shape (K - 1, 2, m).
    """

    fine: CoordinatedMotion
    third: Array


class PathError(MrtsError):
    """A motion is no path: of "zero length", or "stationary" where it stands still or turns back between samples."""

    def __init__(self, message: str, kind: Literal["zero length", "stationary"] = "stationary") -> None:
        super().__init__(message)
        self.kind = kind


def path_pieces(cell: Cell, motion: CoordinatedMotion) -> list[PathPiece]:
    """Cut a motion at its stops and take the timing out of it: σ is the arc length.

    s is the arc length of the joints' path, ds = |q'| dr with |q'| the root mean square over the joints: unlike the
    given time it is regular where a motion starts from rest, and a constant acceleration is a constant s̈.
    Near rest derivatives are continued from a faster sample, and those of the joints keep the grasps on the object:
    continued each by themselves, the arms would carry it apart, by the square of a step.

    Raises:
        PathError: If the motion stands still over a segment, or turns back inside one.
        InputError: If numbers of floating point do not hold the path.
    """
    speed = root_mean_square(motion.dq)
    fastest = float(speed.max())
    rest = speed <= REST * fastest
    if rest.all():
        raise PathError("neither the object nor a joint moves: the path has no length.", "zero length")
    for wait in (rest[1:] & rest[:-1]).nonzero()[0][:1].tolist():
        raise _stationary(motion, wait, *WAIT)
    cuts = [0, *(rest[1:-1].nonzero()[0] + 1).tolist(), motion.samples - 1]
    return [_piece(cell, motion, (first, last), speed, rest) for first, last in pairwise(cuts)]


def _stationary(motion: CoordinatedMotion, segment: int, what: str, cure: str) -> PathError:
    start, end = motion.object.time[segment : segment + 2].tolist()
    where = f"from t = {start:.6g} to {end:.6g} s"
    return PathError(f"the motion {what} {where}: {cure}, or retime what is before and after it by themselves.")


def with_samples(cell: Cell, motion: CoordinatedMotion, added: Array) -> CoordinatedMotion:
    """A motion with samples at further times, Shape (k,) [s]; its own stay exactly as they are."""
    between = between_samples(cell, motion, added, of_path=True)
    return denser(motion, between, np.arange(1, len(added) + 1, dtype=np.intp))


def _piece(
    cell: Cell, motion: CoordinatedMotion, ends: tuple[int, int], all_speeds: Array, rest: NDArray[np.bool_]
) -> PathPiece:
    (first, last), fastest = ends, all_speeds.max()
    part = slice(first, last + 1)
    given, speed, q, dq, ddq = motion.object, all_speeds[part], motion.q[part], motion.dq[part], motion.ddq[part]
    moves = speed > NEAR_REST * fastest
    if not moves.any():
        moves = speed > REST * fastest
    if not moves.any():
        raise _stationary(motion, first, *WAIT)
    growth = row_products(dq, ddq) / q.shape[1] / np.where(speed > 0, speed, 1.0)
    for place, sign in ((0, 1.0), (-1, -1.0)):
        if rest[part][place]:
            growth[place] = sign * (ddq[place] @ ddq[place] / q.shape[1]) ** 0.5
    h = given.time[first + 1 : last + 1] - given.time[first:last]
    step = h / 2 * (speed[:-1] + speed[1:]) + h**2 / 12 * (growth[:-1] - growth[1:])

    away, (moving,), (continued,) = _summed(step), moves.nonzero(), (~moves).nonzero()
    of = moving[((moving[:-1] + moving[1:]) / 2).searchsorted(continued)]  # the nearest, the former of two
    safe = np.where(moves, speed, 1.0)[:, None]

    def along_arc(rate: Array, change: Array) -> tuple[Array, Array]:
        direction = rate / safe
        bend = (change - direction * growth[:, None]) / safe**2
        bend[continued] = bend[of]
        direction[continued] = direction[of] + (away[continued] - away[of])[:, None] * bend[of]
        return direction, bend

    direction, bend = along_arc(dq, ddq)
    turning, change = along_arc(given.twist[part], given.acceleration[part])
    arcs = _arcs(q, direction)
    # with a course velocities near rest are a spline's, the positions are what was given
    exact = arcs > 0 if motion.course is not None else moves[:-1] & moves[1:]
    step = np.where(exact, arcs, step)
    s = _summed(step)
    back = (row_products(direction[1:], direction[:-1]) <= 0) | (step <= 0)
    if back.any():
        cure = "it stops between two samples. Give a sample at the turning point"
        raise _stationary(motion, first + int(np.argmax(back)), "turns back on itself", cure)
    if not ((s[1:] > s[:-1]).all() and np.isfinite(s[-1] + bend.sum() + change.sum())):
        rule = "its positions, velocities and accelerations are too unlike in size to be one motion."
        raise InputError("motion", rule)
    carried = ObjectMotion(s, given.position[part], given.rotation[part], turning, change, checked=False)
    if continued.size:
        rates = nearest_rates(cell, carried, continued, q[continued], direction[continued], bend[continued])
        direction[continued], bend[continued] = rates
    return PathPiece(
        first=first,
        path=CoordinatedMotion(carried, q, direction, bend, checked=False),
        arc=s,
        arc_speed=np.ones_like(s),
        speed=speed,
        rests=(bool(rest[first]), bool(rest[last])),
    )


def _summed(step: Array) -> Array:
    """Where segments start and end, from 0, Shape (n,)."""
    return np.concatenate([np.zeros(1), step]).cumsum()


def root_mean_square(values: Array) -> Array:
    """Over the joints, Shape (N,) of (N, m)."""
    found: Array = np.sqrt(row_products(values, values) / values.shape[1])
    return found


def _arcs(q: Array, direction: Array) -> Array:
    """Arc lengths from sample to sample: chords, lengthened as on a circle with the tangents at both ends.

    They do not depend on the timing, which may have a kink between two samples.
    """
    chord, turn = root_mean_square(q[1:] - q[:-1]), root_mean_square(direction[1:] - direction[:-1])
    half = (turn / 2).clip(STRAIGHT, 1.0)
    arcs: Array = chord * np.arcsin(half) / half
    return arcs


def _inverse(rising: Polynomial, share: Array) -> Array:
    """Where a polynomial reaches shares that rise from 0 to 1, Shape (n,), by Newton steps within parts of its way."""
    table = np.sin(np.linspace(0, np.pi / 2, PARTS_OF_WAY + 1)) ** 2  # dense at both ends, where it may be flat
    reached, slope = rising(table), rising.deriv()
    part = reached.searchsorted(share).clip(1, PARTS_OF_WAY)
    low, high = table[part - 1], table[part]
    z: Array = np.interp(share, reached, table)
    for _ in range(NEWTON_STEPS):
        steep = slope(z)
        z = (z - (rising(z) - share) / np.where(steep > 0, steep, 1.0)).clip(low, high)
    z[0], z[-1] = 0.0, 1.0
    return z


def stops(piece: PathPiece, end_speeds: tuple[float, float]) -> tuple[bool, bool]:
    """Whether a timing is at rest at the ends of a piece: where the motion is, and where no speed is asked for."""
    return piece.rests[0] or end_speeds[0] == 0, piece.rests[1] or end_speeds[1] == 0


def smooth_nodes(cell: Cell, motion: CoordinatedMotion, end_speeds: tuple[float, float]) -> CoordinatedMotion:
    """The same motion at nodes that are evenly spaced in σ, as many as it has samples but not too few."""
    given, times, kept = motion.object.time, [], [0]
    for piece in path_pieces(cell, motion):
        n, s = len(piece.speed), piece.arc
        time = given[piece.first : piece.first + n]
        places = np.linspace(0, 1, max(n, LEAST_NODES))[1:-1]
        h, u = np.diff(time), np.arange(FINE) / FINE  # between samples the way is a cubic polynomial
        ends = np.stack([s[:-1], h * piece.speed[:-1], s[1:], h * piece.speed[1:]], axis=1)
        way = np.maximum.accumulate(np.append(ends @ HERMITE @ u ** np.arange(4)[:, None], s[-1]))
        fine = np.append(time[:-1, None] + h[:, None] * u, time[-1])
        wanted = np.interp(s[-1] * QUINTICS[stops(piece, end_speeds)](places), way, fine)
        times.append(wanted[(wanted > time[0]) & (wanted < time[-1])])
        kept.append(piece.first + n - 1)
    added = np.unique(np.concatenate(times))
    added = added[~np.isin(added, given)]
    whole = with_samples(cell, motion, added)
    chosen = np.flatnonzero(np.isin(whole.object.time, np.concatenate([added, given[kept]])))
    return whole.at(chosen)


def smooth_pieces(
    cell: Cell, motion: CoordinatedMotion, end_speeds: tuple[float, float], duration: float
) -> list[SmoothPath]:
    """The pieces of a motion with nodes at its samples, by the time σ in which quintics from stop to stop go their way.

    That is some duration [s] in all. Where a piece is at rest q' = q'' = 0 by σ: q goes with σ³, as from rest with a
    limited rate it goes with t³, so that ṡ² by σ is finite and not zero. At a stop on the way each knows how every
    joint travels on the other side, so that the torques there are the same before and after it: of a joint that turns
    back, without dry friction.
    """
    time = motion.object.time
    pieces = path_pieces(cell, with_samples(cell, motion, (time[:-1, None] + np.diff(time)[:, None] * PLACES).ravel()))
    travels = [travel_directions(piece.path) for piece in pieces]
    for before, after in pairwise(travels):
        before[1, -1], after[0, 0] = after[1, 0], before[0, -1]
    slower = duration / float(time[-1])
    return [
        _smooth_piece(motion, piece, travel, stops(piece, end_speeds), slower)
        for piece, travel in zip(pieces, travels, strict=True)
    ]


def _smooth_piece(
    motion: CoordinatedMotion, piece: PathPiece, travel: Array, at_rest: tuple[bool, bool], slower: float
) -> SmoothPath:
    path, nodes = piece.path, np.arange(0, piece.path.samples, STRIDE)
    first_node, s = piece.first // STRIDE, path.object.time
    time = motion.object.time[first_node : first_node + len(nodes)]
    duration, quintic = slower * float(time[-1] - time[0]), QUINTICS[at_rest]
    z = _inverse(quintic, s / s[-1])
    by = np.stack([s[-1] / duration**order * quintic.deriv(order)(z) for order in (1, 2, 3)])
    for place, stopped in zip((0, -1), at_rest, strict=True):
        if stopped:
            by[:2, place] = 0.0
    turns = third_derivatives(np.diff(s), path.dq, path.ddq)
    if motion.course is None and motion.object.course is None:  # accelerations between nodes are only between theirs
        turns = _between_nodes(s, third_derivatives(np.diff(s[nodes]), path.dq[nodes], path.ddq[nodes]))
    sides = np.stack([np.arange(len(s) - 1), np.arange(1, len(s))], axis=1)
    first, second, third = by[:, sides, None]
    fine = path.played(z * duration, by[0, :, None], by[1, :, None], travel)
    return SmoothPath(
        first=first_node,
        path=fine.at(nodes),
        speed=piece.speed[nodes],
        rests=piece.rests,
        arc=s[nodes],
        arc_speed=by[0, nodes],
        fine=fine,
        third=turns * first**3 + 3 * path.ddq[sides] * first * second + path.dq[sides] * third,
    )


def _between_nodes(s: Array, third: Array) -> Array:
    """Values at both ends of segments between nodes, linear in between, at both ends of every finer segment."""
    segment, nodes = np.arange(len(s) - 1) // STRIDE, s[::STRIDE]
    share = (np.stack([s[:-1], s[1:]], axis=1) - nodes[segment, None]) / np.diff(nodes)[segment, None]
    values: Array = third[segment, :1] + (third[segment, 1:] - third[segment, :1]) * share[..., None]
    return values
