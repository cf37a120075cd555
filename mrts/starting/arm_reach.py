# SPDX-License-Identifier: MIT
"""How far each arm follows a motion, what stops it, and from which posture it would go on."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mrts.base.arrays import Array, apply
from mrts.base.errors import MotionError
from mrts.base.rigid_transform import vectors_from_rotations
from mrts.cell.cell import Cell
from mrts.following.branches import branches_at_start
from mrts.following.coordinated_motion import CoordinatedMotion, follow_object
from mrts.following.tracking import follow_from, further_starts
from mrts.motion.object_motion import ObjectMotion
from mrts.starting.postures import damped_step

HELD = 1e-5
"""Distance [m] and angle [rad] below which a hand is where it should be: what the search leaves."""

MOST_TRACKS = 16
"""Ways to hold the grasp that are followed, nearest to the posture first: an arm of six joints has no more."""

STARTS = 48
"""Random ones of an arm: ways that few of them lead to are not near any posture."""

ROTATION_WEIGHT = 30.0
"""Metres that a radian counts as: for each metre that is missing, a hand of 1 m is off by 1 mrad."""

STEPS = 60
"""Of the search for the nearest place; a few dozen settle."""

DAMPING = (1e-6, 1e6)
"""Least and most beside squares of Jacobians, which are about 1: far from any grasp, error alone would let it sink to
nothing, and at most a step is a millionth of what the error asks for."""

LONGEST_STEP = 1.0
"""Of a joint [rad or m]."""

DIRECTIONS = 0.05
"""Share of a move along an axis below which it is not named."""

ANGLE_SHOWN = 0.01
"""[rad]: an angle that is missed beside a distance is named from here on."""


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
        off: From where its hand comes nearest, at the first sample that it does not follow in any way, to where it
            should be, world axes, Shape (3,) [m]: what the base would have to move. None if it follows.
        turn: Angle that is left there [rad].
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
    off: Array | None = None
    turn: float = 0.0
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
        ways = f"{self.ways} way{'s' if self.ways > 1 else ''} to hold the grasp at t = 0"
        share = f"{self.followed} of {self.samples} samples, to t = {self.time:.4g} s"
        yield f"  Of {ways}, none leads to the end: {share}." if self.ways else "  No posture holds its grasp at t = 0."
        if self.off is None:
            return
        gap = float(np.linalg.norm(self.off))
        if gap > HELD:
            turned = f" and {np.degrees(self.turn):.2g}° turned" if self.turn > ANGLE_SHOWN else ""
            yield f"  There its hand comes no nearer than {_length(gap)}{turned}: what is missing is {_move(self.off)}."
        elif self.turn > HELD:
            yield f"  There its hand can be, but turned by {np.degrees(self.turn):.3g}°."
        else:
            yield "  There it could hold the grasp, but not on a way that leads there from the start."


def _move(off: Array) -> str:
    """How far along which axes of the world."""
    size = float(np.linalg.norm(off))
    parts = [
        f"{_length(abs(value))} towards {'-' if value < 0 else '+'}{axis}"
        for axis, value in zip("xyz", off, strict=True)
        if abs(value) > DIRECTIONS * size
    ]
    return ", ".join(parts)


def _length(size: float) -> str:
    return f"{1e3 * size:.3g} mm" if size < 1 else f"{size:.4g} m"


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
    followed = max((count if end is None else end.sample for end in ends), default=0)
    time = float(motion.time[min(followed, count - 1)])
    found = ArmReach(robot=robot.name, samples=count, followed=followed, time=time, failure=failure, ways=len(starts))
    if None in ends:
        return replace(found, posture=starts[ends.index(None)])
    off, turn = nearest_hold(arm, motion, followed, np.concatenate([further_starts(robot, robot.posture), starts]))
    return replace(found, off=off, turn=turn)


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


def nearest_hold(arm: Cell, motion: ObjectMotion, sample: int, starts: Array) -> tuple[Array, float]:
    """How near the hand of an arm comes to its grasp at a sample, turned as the grasp wants it, inside joint limits.

    Levenberg-Marquardt with weighted rotation; a joint at a limit stays there while it is pushed outward.

    Args:
        arm: A cell of one arm.
        motion: Motion of the object.
        sample: Of the motion.
        starts: Joint positions to search from, Shape (T, n_i) [rad or m].

    Returns:
        What is missing, world axes, Shape (3,) [m], and the angle that is left [rad].
    """
    (robot,) = arm.robots
    low, high, R = robot.position_lower, robot.position_upper, robot.T_world_base.R
    weights = np.where(np.array(arm.wrench_rows) >= 3, ROTATION_WEIGHT, 1.0)  # noqa: PLR2004 (rotations)
    position = motion.position[sample] + motion.rotation[sample] @ robot.T_object_tip.p
    rotation = motion.rotation[sample] @ robot.T_object_tip.R

    def missing(q: Array) -> tuple[Array, Array, Array]:
        """Distances, Shape (T, 3), and angles, Shape (T, 3), in world axes; the Jacobians, Shape (T, w, n_i)."""
        poses = arm.functions("kinematics", len(q), {"q": q})
        turn = vectors_from_rotations(rotation @ poses["rotation"].swapaxes(1, 2))
        return position - poses["position"], turn, weights[:, None] * poses["jacobian"]

    def weighted(off: Array, turn: Array) -> Array:
        return np.asarray(weights * np.concatenate([off @ R, turn @ R], axis=1)[:, arm.wrench_rows])

    q = np.clip(starts, low, high)
    off, turn, J = missing(q)
    damping = np.full(len(q), 1e-2)
    for _ in range(STEPS):
        error = weighted(off, turn)
        towards = apply(J.swapaxes(1, 2), error)
        pushed = ((q <= low) & (towards < 0)) | ((q >= high) & (towards > 0))
        step = damped_step(error, np.where(pushed[:, None], 0.0, J), damping, LONGEST_STEP)
        tried = np.clip(q + step, low, high)
        found = missing(tried)
        better = np.sum(weighted(*found[:2]) ** 2, axis=1) < np.sum(error**2, axis=1)
        damping = np.clip(np.where(better, damping / 3, damping * 4), *DAMPING)
        for ours, theirs in zip((q, off, turn, J), (tried, *found), strict=True):
            ours[better] = theirs[better]
    angle = np.linalg.norm(turn, axis=1)
    best = int(np.argmin(np.linalg.norm(off, axis=1) + ROTATION_WEIGHT * angle))
    return off[best], float(angle[best])
