# SPDX-License-Identifier: MIT
"""Joints of many variants of one cell along their motions, and why some cannot follow: as `follow_object` has them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.cell.cell import Cell
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
        seed, reasons = self._seeds(path, geometry, posture, refused)
        passed_over = refused.copy()
        passed_over[list(reasons)] = True
        given = {**path, "geometry": geometry, "posture": posture, "seed": seed}
        nothing = np.zeros((1, 0, posture.shape[1]))
        joints = follow_variants(self._library, self._rule, passed_over, {**given, "further": nothing})
        again = np.flatnonzero(np.isin(joints.outcome["code"], (NO_START, START_PAST)))
        if again.size:
            some = {name: value if len(value) == 1 else value[again] for name, value in given.items()}
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

    def _seeds(
        self, path: Mapping[str, Array], geometry: Array, posture: Array, refused: NDArray[np.bool_]
    ) -> tuple[Array, dict[int, str]]:
        """Where the search for each start begins, Shape (V or 1, m), and variants that are surely out of reach."""
        reasons: dict[int, str] = {}
        seed = posture
        for index, (robot, joints) in enumerate(zip(self._cell.robots, self._cell.joint_slices.values(), strict=True)):
            places, reach = _places_of(index, geometry), arm_reach(robot)
            if has_closed_form(self._cell, robot):
                found = planar_triangles(self._cell, robot, places, path["position"], path["rotation"])
                near = np.stack(
                    [nearest_turns(robot, branch[:, 0], posture[:, joints]) for branch in found.branches(1)]
                )
                chosen = np.argmin(np.max(np.abs(near - posture[:, joints]), axis=2), axis=0)
                at = near[chosen, np.arange(near.shape[1])]
                seed = np.repeat(seed, len(at) // len(seed), axis=0) if len(seed) < len(at) else seed.copy()
                seed[:, joints] = at
                for variant in np.flatnonzero(found.out_of_reach() & ~refused).tolist():
                    which = (variant if len(found.wrist) > 1 else 0,)
                    reasons.setdefault(variant, found.failure(robot, _of(path["time"], variant), which))
            elif reach is not None:
                distance = reach.distance(places, path["position"][:, 0], path["rotation"][:, 0])
                for variant in np.flatnonzero(reach.beyond(distance) & ~refused).tolist():
                    failure = reach.failure(robot, _of(path["time"], variant), float(_of(distance, variant)))
                    reasons.setdefault(variant, failure)
        return seed, reasons

    def _further(self, posture: Array) -> Array:
        """The starts tried after the posture, Shape (V or 1, F, m)."""
        slices = self._cell.joint_slices.values()
        parts = zip(self._cell.robots, slices, strict=True)
        return np.concatenate([further_starts(robot, posture[:, joints]) for robot, joints in parts], axis=2)


def _places_of(index: int, geometry: Array) -> ArmPlaces:
    """Where an arm stands and holds, of geometries with V or 1 first."""
    first = GRAVITY_SIZE + ROBOT_SIZE * index
    base, at, tip, held = np.split(geometry[:, first : first + ROBOT_SIZE], (9, 12, 21), axis=1)
    return ArmPlaces(base.reshape(-1, 3, 3), at, tip.reshape(-1, 3, 3), held)


def _of(values: Array, variant: int) -> Array:
    """What a variant has of values with V or 1 first."""
    one: Array = values[variant if len(values) > 1 else 0]
    return one
