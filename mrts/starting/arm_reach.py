# SPDX-License-Identifier: MIT
"""How far each arm follows a motion, what stops it, and from which posture it would go on."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import MotionError
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion, follow_object
from mrts.following.tracking import branches_at_start, follow_from
from mrts.motion.object_motion import ObjectMotion

MOST_TRACKS = 16
"""Ways to hold the grasp that are followed, nearest to the posture first: an arm of six joints has no more."""

STARTS = 48
"""Random ones of an arm: ways that few of them lead to are not near any posture."""


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
        posture: The one nearest to its own from which it follows; None where there is none, or where it is its own.
        furthest: Why the way that goes furthest ends; empty where there is none, or one leads to the end.
        joint: That comes nearest to a position limit; None if it does not follow, or no joint has one.
        to_limit: How near.
        unit: Of that.
        limit_time: When [s].
    """

    robot: str
    samples: int
    followed: int
    time: float
    failure: str = ""
    ways: int = 0
    posture: Array | None = None
    furthest: str = ""
    joint: str | None = None
    to_limit: float | None = None
    unit: str = ""
    limit_time: float | None = None

    @property
    def follows(self) -> bool:
        """Whether it does so from its posture."""
        return not self.failure

    def lines(self) -> Iterator[str]:
        """What came of it, for people."""
        if self.follows:
            near = "no joint has a position limit"
            if self.joint is not None:
                near = (
                    f"{self.to_limit:.3g} {self.unit} from the limit of '{self.joint}' at t = {self.limit_time:.3g} s"
                )
            yield f"robot '{self.robot}' follows the whole motion: {near}."
            return
        yield self.failure
        if self.posture is not None:
            shown = ", ".join(f"{value:.4f}" for value in self.posture)
            yield f"  It follows from another posture: posture: [{shown}]"
            return
        if self.ways:
            ways = f"{self.ways} way{'s' if self.ways > 1 else ''} to hold the grasp at t = 0"
            yield f"  Of {ways}, none leads to the end: {self.followed} of {self.samples} samples. {self.furthest}"
        else:
            yield "  No posture holds its grasp at t = 0."


def reach_of(arm: Cell, motion: ObjectMotion) -> ArmReach:
    """How far an arm follows the object, and from which posture it does where it does not from its own."""
    try:
        return _following(arm, follow_object(arm, motion))
    except MotionError as error:
        failure = str(error)
    (robot,) = arm.robots
    count = len(motion.time)
    starts = branches_at_start(arm, 0, motion, STARTS)
    nearest = np.argsort(np.max(np.abs(starts - robot.posture), axis=1), kind="stable")
    starts = starts[nearest][:MOST_TRACKS]
    tracks = follow_from(arm, motion, starts) if len(starts) else None
    ends = [] if tracks is None else [tracks.of_arm(way, 0) for way in range(len(starts))]
    last = max((end for end in ends if end is not None), key=lambda end: end.sample, default=None)
    leads = None in ends
    followed = count if leads else 0 if last is None else last.sample
    return ArmReach(
        robot=robot.name,
        samples=count,
        followed=followed,
        time=float(motion.time[min(followed, count - 1)]),
        failure=failure,
        ways=len(starts),
        posture=starts[ends.index(None)] if leads else None,
        furthest="" if leads or last is None else last.message,
    )


def _following(arm: Cell, motion: CoordinatedMotion) -> ArmReach:
    """An arm that follows, with what it keeps free."""
    (robot,) = arm.robots
    room = np.minimum(motion.q - robot.position_lower, robot.position_upper - motion.q)
    sample, joint = np.unravel_index(int(np.argmin(room)), room.shape)
    time = motion.object.time
    found = ArmReach(robot=robot.name, samples=motion.samples, followed=motion.samples, time=float(time[-1]))
    if np.isinf(room[sample, joint]):
        return found
    return replace(
        found,
        joint=robot.joints[joint],
        to_limit=float(room[sample, joint]),
        unit=robot.position_units[joint],
        limit_time=float(time[sample]),
    )
