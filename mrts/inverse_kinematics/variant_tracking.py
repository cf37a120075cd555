# SPDX-License-Identifier: MIT
"""Joints of many variants of one cell along their motions, and why some cannot follow: as `follow_object` has them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.inverse_kinematics.grasp_tracking import (
    JUMP_LIMIT,
    SETTLED_PREFERENCE,
    STARTING_STEPS,
    TRACKING_STEPS,
    grasp_task,
)
from mrts.inverse_kinematics.joint_limits import POSITION_TOLERANCE, is_turning, nearest_turns, past_a_limit
from mrts.inverse_kinematics.null_space import FOLD
from mrts.inverse_kinematics.planar_closed_form import has_closed_form, planar_triangles
from mrts.inverse_kinematics.reach import ArmPlaces, arm_reach
from mrts.inverse_kinematics.starting_positions import FURTHER_STEPS, STARTS_TRIED, further_starts
from mrts.inverse_kinematics.tracking_messages import branch_lost, unreachable
from mrts.kernel.cell_library import CellLibrary
from mrts.kernel.variants import (
    FOLLOWED,
    LOST,
    NO_START,
    PAST_LIMIT,
    START_PAST,
    FollowedVariants,
    FollowingRule,
    follow_variants,
)


@dataclass(frozen=True)
class TrackedVariants:
    """What became of V variants.

    Attributes:
        joints: Their joints along the motion, and how following ended.
        reasons: By variant, why it cannot follow, where that is known without a search.
    """

    joints: FollowedVariants
    reasons: dict[int, str]


class VariantTracking:
    """How variants of one cell follow their motions.

    Args:
        cell: One of them; its chains, limits of positions and components are those of all.
        library: Of the cell.
    """

    def __init__(self, cell: Cell, library: CellLibrary) -> None:
        self._cell, self._library = cell, library
        self._rule = FollowingRule(
            task=grasp_task(cell, TRACKING_STEPS),
            start_steps=STARTING_STEPS,
            further_steps=FURTHER_STEPS,
            jump=JUMP_LIMIT,
            drift=SETTLED_PREFERENCE,
            fold=FOLD,
            past=POSITION_TOLERANCE,
            turns=np.concatenate([is_turning(robot) for robot in cell.robots]),
        )

    def follow(
        self, path: Mapping[str, Array], geometry: Array, posture: Array, refused: NDArray[np.bool_]
    ) -> TrackedVariants:
        """Follow V variants.

        Args:
            path: Of the object: `mrts.kernel.variants.PATH` with V, or 1 where all share one, and N before each shape.
            geometry: As `Cell.geometry`, Shape (V or 1, 3 + 24 n + h).
            posture: Of all joints, Shape (V or 1, m) [rad or m].
            refused: Variants that are passed over, Shape (V,); they end as `REFUSED`.
        """
        seed, beyond = self._seeds(path, geometry, posture)
        given = {**path, "geometry": geometry, "posture": posture, "seed": seed}
        nothing = np.zeros((1, 0, posture.shape[1]))
        joints = follow_variants(self._library, self._rule, refused | beyond, {**given, "further": nothing})
        reasons = self._reasons(path, geometry, np.flatnonzero(~refused & (joints.outcome["code"] != FOLLOWED)))
        may_start = np.isin(joints.outcome["code"], (NO_START, START_PAST))
        may_start[list(reasons)] = False
        again = np.flatnonzero(may_start)
        if again.size:
            some = {name: _some(value, again) for name, value in given.items()}
            some["further"] = self._further(some["posture"])
            none = np.zeros(len(again), dtype=bool)
            retried = follow_variants(self._library, self._rule, none, some)
            for whole, part in zip(joints.parts(), retried.parts(), strict=True):
                whole[again] = part
        return TrackedVariants(joints, reasons)

    def reason(self, outcome: NDArray[np.void], time: Array) -> str:
        """Why a variant cannot follow, as `follow_object` says it.

        Args:
            outcome: How it ended, of `mrts.kernel.variants.OUTCOME`; neither followed nor unsettled nor refused.
            time: Of its motion, Shape (N,) [s].
        """
        robot, sample, joint = (int(outcome[name]) for name in ("robot", "sample", "joint"))
        arm, amount = self._cell.robots[robot], outcome["amount"].tolist()
        match int(outcome["code"]):
            case code if code == LOST:
                return branch_lost(arm, time, sample, amount[0])
            case code if code in {START_PAST, PAST_LIMIT}:
                text = past_a_limit(arm, time, sample, joint, amount[0])
            case code:
                text = unreachable(arm, time, sample, *amount)
        return f"{text} {STARTS_TRIED}" if code in {NO_START, START_PAST} else text

    def _seeds(self, path: Mapping[str, Array], geometry: Array, posture: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Where the search for each start begins, Shape (V or 1, m), and whether that is surely out of reach."""
        position, rotation = path["position"][:, :1], path["rotation"][:, :1]
        beyond = np.zeros(1, dtype=bool)
        seed = posture
        for robot, joints, places in self._arms(geometry):
            reach = arm_reach(robot)
            if has_closed_form(self._cell, robot):
                found = planar_triangles(self._cell, robot, places, position, rotation)
                branches = (branch[:, 0] for branch in found.branches())
                near = np.stack([nearest_turns(robot, branch, posture[:, joints]) for branch in branches])
                chosen = np.argmin(np.max(np.abs(near - posture[:, joints]), axis=2), axis=0)
                at = near[chosen, np.arange(near.shape[1])]
                seed = np.repeat(seed, len(at) // len(seed), axis=0) if len(seed) < len(at) else seed.copy()
                seed[:, joints] = at
                beyond = beyond | found.out_of_reach()
            elif reach is not None:
                beyond = beyond | reach.beyond(reach.distance(places, position[:, 0], rotation[:, 0]))
        return seed, beyond

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
            first = GRAVITY_SIZE + ROBOT_SIZE * index
            base, at, tip, held = np.split(geometry[:, first : first + ROBOT_SIZE], (9, 12, 21), axis=1)
            yield robot, joints, ArmPlaces(base.reshape(-1, 3, 3), at, tip.reshape(-1, 3, 3), held)

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
