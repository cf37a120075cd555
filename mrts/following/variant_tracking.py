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
from mrts.following.starting_positions import further_starts
from mrts.following.tracking_messages import WORDINGS, TrackingFailure, tracking_failure
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


class VariantTracking:
    """How variants of one cell start and follow their motions.

    Where an arm cannot reach its grasp at t = 0 from its posture, or only past its limits, further starts are tried. Of
    what they lead to inside the limits the arm takes the nearest to its posture.

    Args:
        cell: One of them; its chains, limits of positions and components are those of all.
    """

    def __init__(self, cell: Cell) -> None:
        self._cell, self._library, self._rule = cell, cell.functions.motion_library, tracking_rule(cell)

    def follow(
        self, path: Mapping[str, Array], geometry: Array, posture: Array, refused: NDArray[np.bool_]
    ) -> TrackedVariants:
        """Follow V variants.

        Args:
            path: Of the object: `mrts.kernel.tracking.PATH` with V, or 1 where all share one, and N before each shape.
            geometry: As `Cell.geometry`, Shape (V or 1, 3 + 24 n + h).
            posture: Of all joints, Shape (V or 1, m) [rad or m].
            refused: Variants that are passed over, Shape (V,); they end as `REFUSED`.
        """
        seed, beyond = self._seeds(path, geometry, posture)
        if len(refused) > 1:  # one is searched in less time
            beyond = beyond | self._surely_beyond(path, geometry)
        given = {**path, "geometry": geometry, "posture": posture, "seed": seed}
        nothing = np.zeros((1, 0, posture.shape[1]))
        joints = follow_variants(self._library, self._rule, refused | beyond, {**given, "further": nothing})
        reasons = self._reasons(path, geometry, np.flatnonzero(~refused & ~joints.followed))
        code = joints.outcome["code"]
        may_start = np.any((code == NO_START) | (code == START_PAST), axis=1)
        may_start[list(reasons)] = False
        again = np.flatnonzero(may_start)
        if again.size:
            some = {name: _some(value, again) for name, value in given.items()}
            some["further"] = self._further(some["posture"])
            none = np.zeros(len(again), dtype=bool)
            retried = follow_variants(self._library, self._rule, none, some)
            for whole, part in zip(joints.parts(), retried.parts(), strict=True):
                whole[again] = part
        return TrackedVariants(self._cell.robots, path["time"], joints, reasons)

    def _seeds(self, path: Mapping[str, Array], geometry: Array, posture: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Where the search for each start begins, Shape (V or 1, m), and whether a closed form is out of reach."""
        position, rotation = path["position"][:, :1], path["rotation"][:, :1]
        beyond = np.zeros(1, dtype=bool)
        seed = posture
        for robot, joints, places in self._arms(geometry):
            if has_closed_form(self._cell, robot):
                found = planar_triangles(self._cell, robot, places, position, rotation)
                branches = (branch[:, 0] for branch in found.branches())
                near = np.stack([nearest_turns(robot, branch, posture[:, joints]) for branch in branches])
                chosen = np.argmin(np.max(np.abs(near - posture[:, joints]), axis=2), axis=0)
                at = near[chosen, np.arange(near.shape[1])]
                seed = np.repeat(seed, len(at) // len(seed), axis=0) if len(seed) < len(at) else seed.copy()
                seed[:, joints] = at
                beyond = beyond | found.out_of_reach()
        return seed, beyond

    def _surely_beyond(self, path: Mapping[str, Array], geometry: Array) -> NDArray[np.bool_]:
        """Variants with an arm whose links do not reach its grasp at t = 0, Shape (V or 1,)."""
        beyond = np.zeros(1, dtype=bool)
        for robot, _, places in self._arms(geometry):
            reach = arm_reach(robot)
            if reach is not None and not has_closed_form(self._cell, robot):
                beyond = beyond | reach.beyond(reach.distance(places, path["position"][:, 0], path["rotation"][:, 0]))
        return beyond

    def _reasons(self, path: Mapping[str, Array], geometry: Array, failed: NDArray[np.intp]) -> dict[int, str]:
        """By variant of those that failed, why it is surely out of reach: of the first arm that is."""
        reasons: dict[int, str] = {}
        position, rotation = (_some(path[name], failed) for name in ("position", "rotation"))
        for robot, _, places in self._arms(_some(geometry, failed)) if failed.size else ():
            reach = arm_reach(robot)
            if has_closed_form(self._cell, robot):
                found = planar_triangles(self._cell, robot, places, position, rotation)
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

    def _arms(self, geometry: Array) -> Iterator[tuple[Robot, slice, ArmPlaces]]:
        """Each arm, its joints and where it stands and holds, of geometries with V or 1 first."""
        for index, (robot, joints) in enumerate(zip(self._cell.robots, self._cell.joint_slices.values(), strict=True)):
            of = geometry[:, GRAVITY_SIZE + ROBOT_SIZE * index :]
            base, tip = of[:, :9].reshape(-1, 3, 3), of[:, 12:21].reshape(-1, 3, 3)
            yield robot, joints, ArmPlaces(base, of[:, 9:12], tip, of[:, 21:24])

    def _further(self, posture: Array) -> Array:
        """The starts tried after the posture, Shape (V or 1, F, m)."""
        slices = self._cell.joint_slices.values()
        parts = zip(self._cell.robots, slices, strict=True)
        return np.concatenate([further_starts(robot, posture[:, joints]) for robot, joints in parts], axis=2)


def _some(values: Array, variants: NDArray[np.intp]) -> Array:
    """What some variants have of values with V or 1 first."""
    return values if len(values) == 1 else values[variants]


def _of(values: Array, variant: int) -> Array:
    """What a variant has of values with V or 1 first."""
    one: Array = values[variant if len(values) > 1 else 0]
    return one
