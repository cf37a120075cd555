# SPDX-License-Identifier: MIT
"""A given motion played with a speed that varies along its path: at its samples, and between them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion, unchecked_coordinated_motion
from mrts.following.denser_motion import WHOLE_WAY, polynomial_weights
from mrts.kernel.binding import filled, structure
from mrts.limits.rows import RowName
from mrts.motion.object_motion import unchecked_object_motion
from mrts.program.motion_rows import travel_directions
from mrts.program.smooth_program import SmoothProgram, segment_times
from mrts.program.successive_steps import StepsTaken
from mrts.timing.fastest_profile import SpeedProfile
from mrts.timing.path_pieces import PLACES, STRIDE, PathPiece, SmoothPath

AT_PLACES = polynomial_weights(PLACES)
"""Found once: to find them takes 1 % of a short timing."""

JOINT_PATH = structure("arm_tips.c", "mrts_joint_path")

BINDING = 1e-4
"""A limit binds where it is reached to this share: interior points come near limits, not to them."""


@dataclass(frozen=True, kw_only=True)
class TimedPiece:
    """A piece of a path with its speed.

    Attributes:
        piece: The piece, n samples; its time is the path parameter σ.
        x: σ̇² at the samples, Shape (n,).
        rates: σ̈ at the start and at the end of every segment, linear in between, Shape (n - 1, 2).
        profile: Of a fastest timing: x with the admissible (σ̈, σ̇²) in which it is the fastest.
    """

    piece: PathPiece
    x: Array
    rates: Array
    profile: SpeedProfile | None = None

    @cached_property
    def segment_times(self) -> Array:
        """Duration of each segment, Shape (n - 1,) [s]; of a smooth one, what the limits of rates were kept with."""
        return segment_times(self.piece.step, self.x, None if self.profile is None else self.profile.rise)

    def along_arc(self, x: Array) -> Array:
        """Speeds ṡ along the arc length at the samples, for some σ̇² there, Shape (n,)."""
        speed: Array = self.piece.arc_speed * np.sqrt(x)
        return speed

    def to_json(self, time: Array) -> dict[str, list[float | None]]:
        """The profile as JSON values, along the arc length; `time` of the given motion, Shape (N,) [s]."""
        own, speeds = time[self.piece.first :][: len(self.x)], {"speed": self.x}
        if self.profile is not None:
            speeds |= {"least_controllable": self.profile.lower, "largest_controllable": self.profile.upper}
            speeds["largest"] = self.profile.regions.upper
        along = {name: self.along_arc(x).tolist() for name, x in speeds.items()}
        finite = {name: [speed if np.isfinite(speed) else None for speed in of] for name, of in along.items()}
        return {"r": own.tolist(), "s": self.piece.arc.tolist(), **finite}


@dataclass(frozen=True, kw_only=True)
class SmoothPiece(TimedPiece):
    """A piece with its smooth timing, by σ.

    Attributes:
        program: All limits of it, for all loads.
        steps: How the timing was found.
        carried: Free wrenches of the timing for each load, Shape (n, f).
        plan: Free wrenches of the least torques that carry the cell's load within all limits and rates, Shape (n, f).
        torque: Those torques, Shape (n, m) [N m].
        wrench: Contact wrenches with them, Shape (n, n w) [N, N m].
    """

    piece: SmoothPath
    program: SmoothProgram
    steps: StepsTaken
    carried: tuple[Array, ...]
    plan: Array
    torque: Array
    wrench: Array

    def between(self) -> tuple[NDArray[np.int_], NDArray[np.int_], Array, Array, Array]:
        """The fine samples that are not nodes: which, segment, place in it, x and u there, each Shape (k,)."""
        fine, step = self.piece.fine, self.piece.step
        inside = np.flatnonzero(np.arange(fine.samples) % STRIDE)
        segment = inside // STRIDE
        after = fine.object.time[inside] - self.piece.path.object.time[segment]
        place, start, change = after / step[segment], self.rates[segment, 0], np.diff(self.rates)[segment, 0]
        x = self.x[segment] + 2 * after * (start + change * place / 2)
        return inside, segment, place, x, start + change * place

    @property
    def binding(self) -> list[set[RowName]]:
        """The limits that bind on every segment."""
        return self.program.binding(self.steps.best, BINDING)


def smooth_parts(pieces: Sequence[TimedPiece]) -> list[SmoothPiece]:
    """The pieces of a smooth timing; none of another one."""
    return [part for part in pieces if isinstance(part, SmoothPiece)]


def new_times(pieces: Sequence[TimedPiece]) -> Array:
    """Times of all samples of a path in pieces, Shape (N,) [s]."""
    times: Array = np.concatenate([[0.0], *[part.segment_times for part in pieces]]).cumsum()
    return times


def retimed_motion(motion: CoordinatedMotion, pieces: Sequence[TimedPiece]) -> CoordinatedMotion:
    """The given samples at their new times.

    Where s̈ jumps at a sample it is the mean of before and after, which limits admit as they admit both. So is the
    direction of travel at a stop, where friction jumps with it.
    """
    played = []
    for part in pieces:
        rates, path = part.rates, part.piece.path
        at_samples = np.concatenate([rates[:1, 0], (rates[:-1, 1] + rates[1:, 0]) / 2, rates[-1:, 1]])
        played.append((*_played(path, part.x, at_samples), *travel_directions(path)))
    dq, ddq, twist, acceleration, *travel = map(_joined, zip(*played, strict=True))
    carried = motion.object.played(new_times(pieces), twist, acceleration)
    return unchecked_coordinated_motion(carried, motion.q, dq, ddq, np.array(travel))


def smooth_torques(pieces: Sequence[TimedPiece]) -> tuple[Array, Array]:
    """Torques and wrenches of a smooth timing, Shape (N, m) and (N, n w); at a stop they are alike on both sides."""
    planned = [(part.torque, part.wrench) for part in smooth_parts(pieces)]
    torques, wrenches = map(_joined, zip(*planned, strict=True))
    return torques, wrenches


def _joined(parts: Sequence[Array]) -> Array:
    """Values of pieces in a row; where two meet, their mean."""
    rows = parts[0]
    for part in parts[1:]:
        rows = np.concatenate([rows[:-1], (rows[-1:] + part[:1]) / 2, part[1:]])
    return rows


def at_segment_ends(part: TimedPiece) -> tuple[CoordinatedMotion, CoordinatedMotion]:
    """The starts and the ends of all segments, each with the s̈ of its segment; their time only counts them."""
    path, given, travel = part.piece.path, part.piece.path.object, travel_directions(part.piece.path)
    count, ends = np.arange(len(part.piece.step), dtype=np.float64), []
    for side, rate in zip((slice(None, -1), slice(1, None)), part.rates.T, strict=True):
        dq, ddq, twist, acceleration = _played(path, part.x, rate, side)
        there = unchecked_object_motion(count, given.position[side], given.rotation[side], twist, acceleration)
        ends.append(unchecked_coordinated_motion(there, path.q[side], dq, ddq, travel[:, side]))
    return ends[0], ends[1]


def between_path_samples(
    cell: Cell, part: TimedPiece, segments: NDArray[np.intp], places: Array = PLACES
) -> CoordinatedMotion:
    """The retimed motion inside some segments, dq/ds on the polynomials of `velocity_polynomials`, by one foreign call.

    Args:
        segments: Which, in order, Shape (s,).
        places: Where in each segment, in (0, 1), Shape (p,).

    Returns:
        The motion at p s samples, segment after segment; its time is the path parameter, from the first place on.
    """
    path, library = part.piece.path, cell.library
    weights = AT_PLACES if places is PLACES else polynomial_weights(places)
    joints = {"time": path.object.time, "q": path.q, "dq": path.dq, "ddq": path.ddq}
    along = filled(JOINT_PATH, **joints, weight=weights, at=places, whole=WHOLE_WAY, places=len(places))
    count = len(places) * len(segments)
    found = [np.empty((count, *shape)) for shape in [(), *[(library.joints,)] * 3, (3,), (3, 3), (6,), (6,)]]
    library.opened.mrts_path_places(count, along, part.x, part.rates, cell.geometry, segments, cell.wrench_rows, *found)
    s, q, dq, ddq, position, rotation, twist, acceleration = found
    by_columns = rotation.transpose(0, 2, 1)  # as generated functions want them
    return unchecked_coordinated_motion(
        unchecked_object_motion(s, position, by_columns, twist, acceleration), q, dq, ddq
    )


def _played(
    path: CoordinatedMotion, x: Array, rate: Array, side: slice = slice(None)
) -> tuple[Array, Array, Array, Array]:
    """Eq. (10) and its derivative along s: q̇ = q_s ṡ, q̈ = q_ss ṡ² + q_s s̈, and so for the object."""
    given, square, rate = path.object, x[side, None], rate[:, None]
    speed = np.sqrt(square)
    return (
        path.dq[side] * speed,
        path.ddq[side] * square + path.dq[side] * rate,
        given.twist[side] * speed,
        given.acceleration[side] * square + given.twist[side] * rate,
    )
