# SPDX-License-Identifier: MIT
"""Joints of many variants of one cell along their motions, and why some cannot follow; one motion is one variant."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.following.grasp_tracking import tracking_rule
from mrts.following.joint_limits import nearest_turns
from mrts.following.planar_closed_form import has_closed_form, planar_triangles
from mrts.following.reach import ArmPlaces, arm_reach
from mrts.following.tracking_messages import FURTHER_STARTS, WORDINGS, TrackingFailure, tracking_failure
from mrts.kernel.tracking import (
    FOLLOWED,
    NO_START,
    OUT_OF_REACH,
    PAST_LIMIT,
    PATH,
    START_PAST,
    FollowedVariants,
    follow_variants,
)
from mrts.motion.object_motion import ObjectMotion

SEED = 13

SPREAD = 2.0
"""The further starts reach from the posture to this far from it in every joint, evenly [rad or m]."""


@dataclass(frozen=True)
class TrackedVariants:
    """What became of V variants.

    Attributes:
        robots: Their arms.
        time: Shape (V or 1, N) [s].
        joints: Their joints along the motion, inside their limits where whole turns do it, and how following ended.
        reasons: By variant, why it cannot follow, where that is known without a search.
    """

    robots: tuple[Robot, ...]
    time: Array
    joints: FollowedVariants
    reasons: dict[int, str]

    def of_arm(self, variant: int, arm: int) -> TrackingFailure | None:
        """Why an arm of a variant cannot follow; None if it does."""
        code, sample, joint, _, amounts = self.joints.outcome[variant, arm].tolist()
        if code not in WORDINGS:
            return None
        return tracking_failure(code, self.robots[arm], _of(self.time, variant), sample, amounts, joint)

    def failure(self, variant: int) -> TrackingFailure | None:
        """Why a variant cannot follow: of the first arm that ends on the way, or else passes a limit."""
        if variant in self.reasons:
            return TrackingFailure(WORDINGS[OUT_OF_REACH].kind, self.reasons[variant], 0)
        code = self.joints.outcome[variant]["code"]
        ends = code != FOLLOWED
        on_the_way = ends & (code != PAST_LIMIT)
        return self.of_arm(variant, int(np.argmax(on_the_way if np.any(on_the_way) else ends)))


def follow_from(cell: Cell, motion: ObjectMotion, start: Array) -> TrackedVariants:
    """Follow the grasps along a motion from several positions that hold them, each branch by continuity.

    An arm with more joints than wrench components stays near its start, away from its limits
    (`mrts.following.null_space`).

    Args:
        cell: The cell.
        motion: Motion of the object.
        start: Positions at t = 0, Shape (V, m) [rad or m].
    """
    path = {name: getattr(motion, name)[None] for name in PATH}
    nothing = np.zeros((1, 0, start.shape[1]))
    given = {**path, "geometry": cell.geometry[None], "posture": start, "seed": start, "further": nothing}
    rule = replace(tracking_rule(cell), start_steps=0)
    joints = follow_variants(cell.functions.motion_library, rule, np.zeros(len(start), dtype=bool), given)
    return TrackedVariants(cell.robots, path["time"], joints, {})


def track_variants(
    cell: Cell, path: Mapping[str, Array], geometry: Array, posture: Array, refused: NDArray[np.bool_]
) -> TrackedVariants:
    """Start and follow V variants of one cell along their motions.

    Where an arm cannot reach its grasp at t = 0 from its posture, or only past its limits, further starts are tried. Of
    what they lead to inside the limits the arm takes the nearest to its posture.

    Args:
        cell: One of them; its chains, limits of positions and components are those of all.
        path: Of the object: `mrts.kernel.tracking.PATH` with V, or 1 where all share one, and N before each shape.
        geometry: As `Cell.geometry`, Shape (V or 1, 3 + 24 n + h).
        posture: Of all joints, Shape (V or 1, m) [rad or m].
        refused: Variants that are passed over, Shape (V,); they end as `REFUSED`.
    """
    seed, beyond = _seeds(cell, path, geometry, posture)
    if len(refused) > 1:  # one is searched in less time
        beyond = beyond | _surely_beyond(cell, path, geometry)
    library, rule = cell.functions.motion_library, tracking_rule(cell)
    given = {**path, "geometry": geometry, "posture": posture, "seed": seed}
    nothing = np.zeros((1, 0, posture.shape[1]))
    joints = follow_variants(library, rule, refused | beyond, {**given, "further": nothing})
    reasons = _reasons(cell, path, geometry, np.flatnonzero(~refused & ~joints.followed))
    code = joints.outcome["code"]
    may_start = np.any((code == NO_START) | (code == START_PAST), axis=1)
    may_start[list(reasons)] = False
    again = np.flatnonzero(may_start)
    if again.size:
        some = {name: _some(value, again) for name, value in given.items()}
        parts = zip(cell.robots, cell.joint_slices.values(), strict=True)
        further = [further_starts(robot, some["posture"][:, own]) for robot, own in parts]
        some["further"] = np.concatenate(further, axis=2)
        retried = follow_variants(library, rule, np.zeros(len(again), dtype=bool), some)
        for whole, part in zip(joints.parts(), retried.parts(), strict=True):
            whole[again] = part
    return TrackedVariants(cell.robots, path["time"], joints, reasons)


def _seeds(cell: Cell, path: Mapping[str, Array], geometry: Array, posture: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Where the search for each start begins, Shape (V or 1, m), and whether a closed form is out of reach."""
    position, rotation = path["position"][:, :1], path["rotation"][:, :1]
    beyond = np.zeros(1, dtype=bool)
    seed = posture
    for robot, joints, places in _arms(cell, geometry):
        if has_closed_form(cell, robot):
            found = planar_triangles(cell, robot, places, position, rotation)
            branches = (branch[:, 0] for branch in found.branches())
            near = np.stack([nearest_turns(robot, branch, posture[:, joints]) for branch in branches])
            chosen = np.argmin(np.max(np.abs(near - posture[:, joints]), axis=2), axis=0)
            at = near[chosen, np.arange(near.shape[1])]
            seed = np.repeat(seed, len(at) // len(seed), axis=0) if len(seed) < len(at) else seed.copy()
            seed[:, joints] = at
            beyond = beyond | found.out_of_reach()
    return seed, beyond


def _surely_beyond(cell: Cell, path: Mapping[str, Array], geometry: Array) -> NDArray[np.bool_]:
    """Variants with an arm whose links do not reach its grasp at t = 0, Shape (V or 1,)."""
    beyond = np.zeros(1, dtype=bool)
    for robot, _, places in _arms(cell, geometry):
        reach = arm_reach(robot)
        if reach is not None and not has_closed_form(cell, robot):
            beyond = beyond | reach.beyond(reach.distance(places, path["position"][:, 0], path["rotation"][:, 0]))
    return beyond


def _reasons(cell: Cell, path: Mapping[str, Array], geometry: Array, failed: NDArray[np.intp]) -> dict[int, str]:
    """By variant of those that failed, why it is surely out of reach: of the first arm that is."""
    reasons: dict[int, str] = {}
    position, rotation = (_some(path[name], failed) for name in ("position", "rotation"))
    for robot, _, places in _arms(cell, _some(geometry, failed)) if failed.size else ():
        reach = arm_reach(robot)
        if has_closed_form(cell, robot):
            found = planar_triangles(cell, robot, places, position, rotation)
            for place in np.flatnonzero(np.broadcast_to(found.out_of_reach(), len(failed))).tolist():
                variant, which = int(failed[place]), (place if len(found.wrist) > 1 else 0,)
                reasons.setdefault(variant, found.failure(robot, _of(path["time"], variant), which))
        elif reach is not None:
            distance = np.broadcast_to(reach.distance(places, position[:, 0], rotation[:, 0]), len(failed))
            for place in np.flatnonzero(reach.beyond(distance)).tolist():
                variant = int(failed[place])
                failure = reach.failure(robot, _of(path["time"], variant), float(distance[place]))
                reasons.setdefault(variant, failure)
    return reasons


def _arms(cell: Cell, geometry: Array) -> Iterator[tuple[Robot, slice, ArmPlaces]]:
    """Each arm, its joints and where it stands and holds, of geometries with V or 1 first."""
    for index, (robot, joints) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
        of = geometry[:, GRAVITY_SIZE + ROBOT_SIZE * index :]
        base, tip = of[:, :9].reshape(-1, 3, 3), of[:, 12:21].reshape(-1, 3, 3)
        yield robot, joints, ArmPlaces(base, of[:, 9:12], tip, of[:, 21:24])


def starting_reference(cell: Cell) -> Array:
    """The postures of all arms, moved inside their limits where they are not, Shape (m,) [rad or m]."""
    inside = [np.clip(robot.posture, robot.position_lower, robot.position_upper) for robot in cell.robots]
    return np.concatenate(inside)


def further_starts(robot: Robot, posture: Array) -> Array:
    """Where the search goes on from where an arm's posture leads to nothing, Shape (…, FURTHER_STARTS, n_i).

    Always the same: the middle of its limits, and random ones farther and farther from the posture, Shape (…, n_i).
    """
    low, high = robot.position_lower, robot.position_upper
    steps = np.linspace(0, SPREAD, FURTHER_STARTS)[:, None]
    turns = np.random.default_rng(SEED).uniform(-1, 1, (FURTHER_STARTS, len(robot.joints)))
    starts: Array = np.clip(posture[..., None, :] + steps * turns, low, high)
    limited = np.isfinite(low) & np.isfinite(high)
    starts[..., 0, limited] = (low[limited] + high[limited]) / 2
    return starts


def _some(values: Array, variants: NDArray[np.intp]) -> Array:
    """What some variants have of values with V or 1 first."""
    return values if len(values) == 1 else values[variants]


def _of(values: Array, variant: int) -> Array:
    """What a variant has of values with V or 1 first."""
    one: Array = values[variant if len(values) > 1 else 0]
    return one
