# SPDX-License-Identifier: MIT
"""How far each arm follows a motion, what stops it, and from which posture it would go on."""

from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import MotionError
from mrts.cell.cell import Cell
from mrts.following.branches import branches_at_start
from mrts.following.coordinated_motion import CoordinatedMotion, follow_object
from mrts.following.tracking import POSITION_TOLERANCE, TrackingFailure, follow_from, further_starts, within_limits
from mrts.motion.object_motion import ObjectMotion
from mrts.starting.nearest_hold import NearestHold, nearest_hold

HELD = 1e-5
"""Distance [m] and angle [rad] below which a hand is where it should be: what the search leaves."""

MOST_TRACKS = 16
"""Ways to hold the grasp that are followed, nearest to the posture first: an arm of six joints has no more."""

STARTS = 48
"""Random ones of an arm: ways that few of them lead to are not near any posture."""


@dataclass(frozen=True, kw_only=True)
class ArmMargin:
    """What an arm that follows keeps free.

    Attributes:
        joint: That comes nearest to a position limit; None where none has one.
        to_limit: How near [rad or m].
        unit: Of that.
        time: When [s].
    """

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
    posture: Array | None = None
    margin: ArmMargin | None = None

    @property
    def follows(self) -> bool:
        """Whether it does so from its posture."""
        return not self.failure


def reach_of(arm: Cell, motion: ObjectMotion) -> ArmReach:
    """How far an arm follows the object, and from which posture it does where it does not from its own."""
    try:
        return following(arm, follow_object(arm, motion))
    except MotionError as error:
        failure = str(error)
    (robot,) = arm.robots
    count = len(motion.time)
    starts, failures = _ways(arm, motion)
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
    return replace(found, nearest=nearest_hold(arm, motion, followed, np.concatenate(around)))


def following(arm: Cell, motion: CoordinatedMotion) -> ArmReach:
    """An arm that follows, with its margins."""
    (robot,) = arm.robots
    room = np.minimum(motion.q - robot.position_lower, robot.position_upper - motion.q)
    sample, joint = np.unravel_index(int(np.argmin(room)), room.shape)
    margin = ArmMargin(
        joint=robot.joints[joint] if np.isfinite(room[sample, joint]) else None,
        to_limit=float(room[sample, joint]),
        unit=robot.position_units[joint],
        time=float(motion.object.time[sample]),
    )
    time = float(motion.object.time[-1])
    return ArmReach(robot=robot.name, samples=motion.samples, followed=motion.samples, time=time, margin=margin)


def _ways(arm: Cell, motion: ObjectMotion) -> tuple[Array, list[TrackingFailure | None]]:
    """Ways of an arm to hold its grasp at t = 0, `MOST_TRACKS` at most, and why they end.

    Returns:
        Joint positions, Shape (count, n_i) [rad or m], nearest to the posture first, and their failures.
    """
    (robot,) = arm.robots
    found = branches_at_start(arm, 0, motion, STARTS)
    if not len(found):
        return found, []
    order = np.argsort(np.max(np.abs(found - robot.posture), axis=1), kind="stable")
    found = found[order][:MOST_TRACKS]
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
