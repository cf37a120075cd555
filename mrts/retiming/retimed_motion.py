# SPDX-License-Identifier: MIT
"""A given motion played with a speed that varies along its path: at its samples, and between them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion, carried_by_first
from mrts.coordination.denser_motion import velocity_polynomials
from mrts.motion.object_motion import ObjectMotion
from mrts.reachability.fastest_profile import SpeedProfile
from mrts.reachability.speed_regions import SpeedRegions
from mrts.retiming.path_pieces import PathPiece
from mrts.samples.motor_terms import travel_directions


@dataclass(frozen=True)
class TimedPiece:
    """A piece of a path with its fastest speed.

    Attributes:
        piece: The piece, n samples.
        regions: Admissible (s̈, ṡ²) at its samples.
        profile: The fastest ṡ².
    """

    piece: PathPiece
    regions: SpeedRegions
    profile: SpeedProfile

    @property
    def rate(self) -> Array:
        """s̈ on each segment, Shape (n - 1,)."""
        rate: Array = np.diff(self.profile.x) / (2 * self.piece.step)
        return rate

    @property
    def segment_times(self) -> Array:
        """Duration of each segment: ṡ² is linear in s, so 2 Δs / (ṡ_start + ṡ_end), Shape (n - 1,) [s]."""
        speed = np.sqrt(self.profile.x)
        duration: Array = 2 * self.piece.step / (speed[:-1] + speed[1:])
        return duration


def retimed_motion(motion: CoordinatedMotion, pieces: Sequence[TimedPiece]) -> CoordinatedMotion:
    """The given samples at their new times.

    s̈ jumps at samples; there it is the mean of before and after, which limits admit as they admit both. So is the
    direction of travel at a stop, where friction jumps with it.

    Args:
        motion: The given motion, N samples.
        pieces: All of its path.
    """
    played, directions = [], []
    for part in pieces:
        rate = part.rate
        at_samples = np.concatenate([rate[:1], (rate[:-1] + rate[1:]) / 2, rate[-1:]])
        played.append(_played(part.piece.path, np.sqrt(part.profile.x), part.profile.x, at_samples))
        directions.append(_directions(part.piece.path))
    time = np.concatenate([[0.0], np.cumsum(np.concatenate([part.segment_times for part in pieces]))])
    given = motion.object
    dq, ddq, twist, acceleration = (_joined([rates[index] for rates in played]) for index in range(4))
    carried = ObjectMotion(time, given.position, given.rotation, twist, acceleration, smooth=False)
    travel = np.stack([_joined([signs[place] for signs in directions]) for place in (0, 1)])
    return CoordinatedMotion(carried, motion.q, dq, ddq, travel=travel)


def _directions(path: CoordinatedMotion) -> Array:
    """Signs of the joints' velocities before and after every sample of a piece, Shape (2, n, m)."""
    return np.stack(travel_directions(path.dq, path.ddq))


def _joined(parts: list[Array]) -> Array:
    """Values of pieces in a row; where two meet, their mean."""
    rows = parts[0]
    for part in parts[1:]:
        rows = np.concatenate([rows[:-1], (rows[-1:] + part[:1]) / 2, part[1:]])
    return rows


def at_segment_ends(part: TimedPiece) -> tuple[CoordinatedMotion, CoordinatedMotion]:
    """The starts and the ends of all segments, each with the s̈ of its segment; their time only counts them.

    Args:
        part: A piece of n samples.
    """
    path, x = part.piece.path, part.profile.x
    motions = []
    for side in (slice(None, -1), slice(1, None)):
        given = path.object
        count = np.arange(len(part.piece.step), dtype=np.float64)
        there = ObjectMotion(
            count, given.position[side], given.rotation[side], given.twist[side], given.acceleration[side], smooth=False
        )
        travel = _directions(path)[:, side]
        piece = CoordinatedMotion(there, path.q[side], path.dq[side], path.ddq[side], travel=travel)
        motions.append(_retimed(piece, np.sqrt(x[side]), x[side], part.rate))
    return motions[0], motions[1]


def between_path_samples(cell: Cell, part: TimedPiece, places: Array) -> CoordinatedMotion:
    """The retimed motion inside the segments, dq/ds on the polynomials of `velocity_polynomials`.

    Args:
        cell: The cell.
        part: A piece of n samples.
        places: Where in each segment, in (0, 1), Shape (p,).

    Returns:
        The motion at p (n - 1) samples, segment after segment; its time is the arc length s.
    """
    path, step = part.piece.path, part.piece.step
    s = (path.object.time[:-1, None] + step[:, None] * places).ravel()
    q, dq, ddq = velocity_polynomials(path.object.time, (path.q, path.dq, path.ddq), s)
    between = carried_by_first(cell, s - s[0], q, dq, ddq, smooth=False)
    x = (part.profile.x[:-1, None] + np.diff(part.profile.x)[:, None] * places).ravel()
    return _retimed(between, np.sqrt(x), x, np.repeat(part.rate, len(places)))


def _retimed(path: CoordinatedMotion, speed: Array, x: Array, rate: Array) -> CoordinatedMotion:
    """Samples of a path at their speeds; the time stays that of the path."""
    dq, ddq, twist, acceleration = _played(path, speed, x, rate)
    given = path.object
    carried = ObjectMotion(given.time, given.position, given.rotation, twist, acceleration, smooth=False)
    return CoordinatedMotion(carried, path.q, dq, ddq, travel=path.travel)


def _played(path: CoordinatedMotion, speed: Array, x: Array, rate: Array) -> tuple[Array, Array, Array, Array]:
    """Eq. (10) and its derivative along s: q̇ = q_s ṡ, q̈ = q_ss ṡ² + q_s s̈, and so for the object."""
    speed, x, rate = speed[:, None], x[:, None], rate[:, None]
    given = path.object
    return (
        path.dq * speed,
        path.ddq * x + path.dq * rate,
        given.twist * speed,
        given.acceleration * x + given.twist * rate,
    )
