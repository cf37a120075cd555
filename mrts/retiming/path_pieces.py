# SPDX-License-Identifier: MIT
"""The path of a motion without its timing: samples by arc length, in pieces from stop to stop."""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.coordination.closed_chain import nearest_rates
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.rows_at_rest import REST

PLACES = np.array([0.125, 0.375, 0.5, 0.625, 0.875])
"""Where each segment is checked; the error vanishes at its ends."""

NEAR_REST = 1e-3
"""Below this share, q'/|q'| and its derivative lose digits: they are continued from the first faster sample."""


@dataclass(frozen=True)
class PathPiece:
    """Part of a path between two stops or ends, n samples.

    Attributes:
        first: Index of its first sample in the motion.
        path: Its samples with arc length s for time: q, dq/ds, d²q/ds², and so for the object.
        speed: ds/dr at the samples, Shape (n,).
        rests: Whether the motion is at rest at its start, and at its end.
        continued: Samples near rest, whose derivatives are continued from a faster one.
    """

    first: int
    path: CoordinatedMotion
    speed: Array
    rests: tuple[bool, bool]
    continued: NDArray[np.int_]

    @property
    def step(self) -> Array:
        """Δs of each segment, Shape (n - 1,)."""
        return np.diff(self.path.object.time)


@dataclass(frozen=True)
class NoPath:
    """Why a motion is no path that can be timed.

    Attributes:
        kind: "zero length", "wait" (at rest over a whole segment) or "turn" (back on itself between two samples).
        sample: Start of the segment.
    """

    kind: Literal["zero length", "wait", "turn"]
    sample: int


def path_pieces(motion: CoordinatedMotion) -> list[PathPiece] | NoPath:
    """Cut a motion at its stops and take the timing out of it.

    s is the arc length of the joints' path, ds = |q'| dr with |q'| the root mean square over the joints: unlike the
    given time it is regular where a motion starts from rest, and a constant acceleration is a constant s̈.

    Args:
        motion: The given motion, N samples.
    """
    speed = np.sqrt(np.mean(motion.dq**2, axis=1))
    fastest = float(np.max(speed))
    if fastest == 0:
        return NoPath("zero length", 0)
    rest = speed <= REST * fastest
    waits = np.flatnonzero(rest[1:] & rest[:-1])
    if waits.size:
        return NoPath("zero length" if np.all(rest) else "wait", int(waits[0]))
    cuts = [0, *(np.flatnonzero(rest[1:-1]) + 1).tolist(), motion.samples - 1]
    pieces = []
    for first, last in pairwise(cuts):
        piece = _piece(motion, first, last, speed, rest, fastest)
        if isinstance(piece, NoPath):
            return piece
        pieces.append(piece)
    return pieces


def _piece(
    motion: CoordinatedMotion, first: int, last: int, all_speeds: Array, rest: Array, fastest: float
) -> PathPiece | NoPath:
    part = slice(first, last + 1)
    given, speed = motion.object, all_speeds[part]
    rates = np.concatenate([motion.dq[part], given.twist[part]], axis=1)
    changes = np.concatenate([motion.ddq[part], given.acceleration[part]], axis=1)
    joints = motion.q.shape[1]
    moving = np.flatnonzero(speed > NEAR_REST * fastest)
    if not moving.size:
        moving = np.flatnonzero(speed > REST * fastest)
    if not moving.size:
        return NoPath("wait", first)
    slowing = np.sqrt(np.mean(motion.ddq[part] ** 2, axis=1)) * np.where(np.arange(len(speed)) == 0, 1.0, -1.0)
    safe = np.where(speed > 0, speed, 1.0)
    growth = np.where(rest[part], slowing, np.mean(motion.dq[part] * motion.ddq[part], axis=1) / safe)
    h = np.diff(given.time[part])
    step = h / 2 * (speed[:-1] + speed[1:]) + h**2 / 12 * (growth[:-1] - growth[1:])

    direction, bend = np.zeros_like(rates), np.zeros_like(rates)
    direction[moving] = rates[moving] / speed[moving, None]
    bend[moving] = (changes[moving] - direction[moving] * growth[moving, None]) / speed[moving, None] ** 2
    away = np.concatenate([[0.0], np.cumsum(step)])
    continued = np.setdiff1d(np.arange(len(speed)), moving)
    for near in continued:
        of = moving[np.argmin(np.abs(moving - near))]
        bend[near] = bend[of]
        direction[near] = direction[of] + (away[near] - away[of]) * bend[of]
    fast = np.isin(np.arange(len(step)), moving) & np.isin(np.arange(len(step)) + 1, moving)
    step[fast] = _arcs(motion.q[part], direction[:, :joints])[fast]
    s = np.concatenate([[0.0], np.cumsum(step)])
    back = np.sum(direction[1:, :joints] * direction[:-1, :joints], axis=1) <= 0
    if np.any(back) or np.any(step <= 0):
        return NoPath("turn", first + int(np.argmax(back | (step <= 0))))
    path = ObjectMotion(
        s, given.position[part], given.rotation[part], direction[:, joints:], bend[:, joints:], smooth=False
    )
    rests = (bool(rest[first]), bool(rest[last]))
    joined = CoordinatedMotion(path, motion.q[part], direction[:, :joints], bend[:, :joints])
    return PathPiece(first, joined, speed, rests, continued)


def closed_piece(cell: Cell, piece: PathPiece) -> PathPiece:
    """The same piece; where its derivatives were continued, those of the joints keep the grasps on the object.

    Continued each by themselves, the arms would carry it apart, by the square of a step.

    Args:
        cell: The cell.
        piece: A piece of a path of it.
    """
    path, chosen = piece.path, np.union1d(piece.continued, [0, len(piece.speed) - 1])
    some = path.at(chosen)
    dq, ddq = path.dq.copy(), path.ddq.copy()
    wrong = np.isin(chosen, piece.continued)
    dq[piece.continued], ddq[piece.continued] = (rates[wrong] for rates in nearest_rates(cell, some.object, some))
    return replace(piece, path=replace(path, dq=dq, ddq=ddq))


def _arcs(q: Array, direction: Array) -> Array:
    """Arc lengths from sample to sample: chords, lengthened as on a circle with the tangents at both ends.

    They do not depend on the timing, which may have a kink between two samples.
    """
    chord = np.sqrt(np.mean(np.diff(q, axis=0) ** 2, axis=1))
    turn = np.sqrt(np.mean(np.diff(direction, axis=0) ** 2, axis=1))
    half = np.arcsin(np.minimum(turn / 2, 1.0))
    arcs: Array = chord / np.sinc(half / np.pi)
    return arcs
