# SPDX-License-Identifier: MIT
"""How far each arm follows a motion, what stops it, and what would let it go on."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import MotionError
from mrts.cell.cell import Cell
from mrts.following.branches import branches_at_start
from mrts.following.coordinated_motion import CoordinatedMotion, follow_object
from mrts.following.reach import ArmPlaces, arm_reach, has_closed_form, planar_triangles
from mrts.following.tracking import POSITION_TOLERANCE, TrackingFailure, follow_from, further_starts, within_limits
from mrts.motion.object_motion import ObjectMotion
from mrts.starting.nearest_hold import NearestHold, nearest_hold

HELD = 1e-5
"""Distance [m] and angle [rad] below which a hand is where it should be: what the search leaves."""

MOST_TRACKS = 16
"""Ways to hold the grasp that are followed, nearest to the posture first: an arm of six joints has no more."""

FEW_TRACKS = 4
"""The same of an arm that was moved to see whether it follows."""

STARTS = 48
"""Random ones for an arm without a closed form: ways that few of them lead to are not near any posture."""

MOST_SHIFTS = 6
"""Times that a base is moved by what is missing, until nothing is."""

SPARES = (0.01, 0.05)
"""Metres that a base is then moved further, one after the other: an arm at full stretch is singular."""

LOOKED_AT = 5
"""Samples at which is looked whether something is missing."""

SHIFT_DIGITS = 3
"""A move of a base is rounded to millimetres before it is tried out."""


@dataclass(frozen=True, kw_only=True)
class ArmMargin:
    """What an arm that follows keeps free.

    Attributes:
        stretch: Least distance to full stretch along the motion [m]; None where it is not known.
        joint: That comes nearest to a position limit; None where none has one.
        to_limit: How near [rad or m].
        unit: Of that.
        time: When [s].
    """

    stretch: float | None
    joint: str | None
    to_limit: float
    unit: str
    time: float


@dataclass(frozen=True, kw_only=True)
class ArmReach:
    """How far one arm follows the motion.

    Attributes:
        robot: Its name.
        samples: Of the motion.
        followed: Samples that it follows: of all ways to hold the grasp at t = 0, the one that goes furthest.
        time: Of the first that it does not follow [s]; of the last if it follows.
        failure: Why it does not follow from its posture; empty if it does.
        ways: Number of ways to hold the grasp at t = 0 that were followed.
        nearest: How near its hand comes to the first sample that it does not follow; None if it follows.
        shift: A move of its base, and with it of its machine's other arms, with which they follow, tried out, world
            axes, Shape (3,) [m]; None where none was found.
        machine: The other arms of its machine, whose bases stay beside its own.
        posture: The one nearest to its own from which it follows; None where there is none, or where it is its own.
        margin: What it keeps free; None if it does not follow.
    """

    robot: str
    samples: int
    followed: int
    time: float
    failure: str = ""
    ways: int = 0
    nearest: NearestHold | None = None
    shift: Array | None = None
    machine: tuple[str, ...] = ()
    posture: Array | None = None
    margin: ArmMargin | None = None

    @property
    def follows(self) -> bool:
        """Whether it does so from its posture."""
        return not self.failure


def reach_of(arm: Cell, motion: ObjectMotion, *, seek: bool = True) -> ArmReach:
    """How far an arm follows the object, and what would help where it does not."""
    try:
        return following(arm, follow_object(arm, motion))
    except MotionError as error:
        failure = str(error)
    (robot,) = arm.robots
    count = len(motion.time)
    starts, failures = _ways(arm, motion, MOST_TRACKS)
    good = [start for start, ended in zip(starts, failures, strict=True) if ended is None]
    reached = [count if ended is None else ended.sample or 0 for ended in failures]
    followed = max(reached, default=0)
    found = ArmReach(
        robot=robot.name,
        samples=count,
        followed=followed,
        time=float(motion.time[min(followed, count - 1)]),
        failure=failure,
        ways=len(starts),
    )
    if good:
        return replace(found, posture=good[0])
    around = [further_starts(robot, robot.posture), *([starts] if len(starts) else [])]
    nearest = nearest_hold(arm, motion, followed, np.concatenate(around))
    return replace(found, nearest=nearest, shift=_shift(arm, motion, nearest) if seek else None)


def of_machine(reach: ArmReach, fellows: Sequence[Cell], motion: ObjectMotion) -> ArmReach:
    """The same of an arm whose base others share: it moves only where they still follow."""
    shift = reach.shift
    if shift is not None and not all(follows(_moved(fellow, shift), motion) for fellow in fellows):
        shift = None
    return replace(reach, shift=shift, machine=tuple(fellow.robots[0].name for fellow in fellows))


def following(arm: Cell, motion: CoordinatedMotion) -> ArmReach:
    """An arm that follows, with its margins."""
    (robot,) = arm.robots
    room = np.minimum(motion.q - robot.position_lower, robot.position_upper - motion.q)
    sample, joint = np.unravel_index(int(np.argmin(room)), room.shape)
    margin = ArmMargin(
        stretch=_stretch(arm, motion.object),
        joint=robot.joints[joint] if np.isfinite(room[sample, joint]) else None,
        to_limit=float(room[sample, joint]),
        unit=robot.position_units[joint],
        time=float(motion.object.time[sample]),
    )
    time = float(motion.object.time[-1])
    return ArmReach(robot=robot.name, samples=motion.samples, followed=motion.samples, time=time, margin=margin)


def _stretch(arm: Cell, motion: ObjectMotion) -> float | None:
    """Least distance of an arm to full stretch along a motion [m]; None where its links do not tell."""
    (robot,) = arm.robots
    base, grasp = robot.T_world_base, robot.T_object_tip
    places = ArmPlaces(base.R, base.p, grasp.R, grasp.p)
    if has_closed_form(arm, robot):
        triangles = planar_triangles(arm, robot, places, motion.position, motion.rotation)
        return float(np.sum(triangles.lengths) - np.max(np.linalg.norm(triangles.wrist, axis=-1)))
    reach = arm_reach(robot)
    if reach is None:
        return None
    return reach.longest - float(np.max(reach.distance(places, motion.position, motion.rotation)))


def follows(arm: Cell, motion: ObjectMotion) -> bool:
    """Whether an arm follows the object from some way to hold the grasp at t = 0."""
    return None in _ways(arm, motion, FEW_TRACKS)[1]


def _ways(arm: Cell, motion: ObjectMotion, most: int) -> tuple[Array, list[TrackingFailure | None]]:
    """Ways of an arm to hold its grasp at t = 0, as many at most, and why they end.

    Returns:
        Joint positions, Shape (count, n_i) [rad or m], nearest to the posture first, and their failures.
    """
    (robot,) = arm.robots
    try:
        found = branches_at_start(arm, 0, motion, STARTS)
    except MotionError:  # of a planar arm with a closed form: out of reach
        found = np.empty((0, len(robot.joints)))
    if not len(found):
        return found, []
    order = np.argsort(np.max(np.abs(found - robot.posture), axis=1), kind="stable")
    found = found[order][:most]
    tracks = follow_from(arm, motion, found)
    return found, [_first_failure(arm, q, tracks.of_arm(way, 0)) for way, q in enumerate(tracks.q)]


def _first_failure(arm: Cell, q: Array, failure: TrackingFailure | None) -> TrackingFailure | None:
    (robot,) = arm.robots
    inside = within_limits(robot, q if failure is None else q[: (failure.sample or 0) + 1])
    low, high = robot.position_lower - POSITION_TOLERANCE, robot.position_upper + POSITION_TOLERANCE
    beyond = np.any((inside < low) | (inside > high), axis=1)
    sample = int(np.argmax(beyond))
    if not np.any(beyond) or (failure is not None and sample >= (failure.sample or 0)):
        return failure
    return TrackingFailure("past a position limit", "", sample)


def _shift(arm: Cell, motion: ObjectMotion, nearest: NearestHold) -> Array | None:
    """A move of the base that lets the arm follow; None where moving it by what is missing does not lead to one."""
    if nearest.gap <= HELD:
        return None
    (robot,) = arm.robots
    total = nearest.off
    starts = further_starts(robot, robot.posture)
    samples = np.linspace(0, len(motion.time) - 1, LOOKED_AT).astype(int)
    for _ in range(MOST_SHIFTS):
        moved = _moved(arm, total)
        worst = max((nearest_hold(moved, motion, int(k), starts) for k in samples), key=lambda hold: hold.gap)
        if worst.gap <= HELD:
            break
        total = total + worst.off
    for spare in SPARES:
        further: Array = np.round(total * (1 + spare / float(np.linalg.norm(total))), SHIFT_DIGITS)
        if follows(_moved(arm, further), motion):
            return further
    return None


def _moved(arm: Cell, shift: Array) -> Cell:
    (robot,) = arm.robots
    return arm.with_values({"robots[0].base.xyz": robot.T_world_base.p + shift})
