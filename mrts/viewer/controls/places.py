# SPDX-License-Identifier: MIT
"""What can be moved by a gizmo: bases, grasps, and both ends of the motion."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.base.rigid_transform import (
    RigidTransform,
    plane_normal,
    rotations_from_vectors,
    vectors_from_rotations,
)
from mrts.cell.cell import Cell
from mrts.cell.cell_change import machine_of
from mrts.motion.motion_file import MotionDescription
from mrts.viewer.workbench.choices import Choices, Given

DECIMALS = 6
"""Of a position that was moved [m]."""


@dataclass(frozen=True)
class Place:
    """Something with a pose.

    Attributes:
        kind: A base in the world, a grasp in the object's frame, or an end of the motion in the world.
        robot: Whose it is; empty of the motion.
    """

    kind: Literal["base", "grasp", "start", "end"]
    robot: str = ""

    def __str__(self) -> str:
        return f"{self.robot} {self.kind}" if self.robot else f"{self.kind} of the motion"

    def pose(self, choices: Choices, given: Given) -> RigidTransform:
        """Its pose as it was chosen."""
        chosen = {"base": choices.bases.get(self.robot), "grasp": choices.grasps.get(self.robot)}
        chosen |= {"start": choices.start, "end": choices.end}
        return chosen[self.kind] or self.given_pose(given)

    def given_pose(self, given: Given) -> RigidTransform:
        """Its pose as it was given."""
        if self.kind == "start" or self.kind == "end":  # noqa: PLR1714 (what mypy takes for the two)
            assert given.description is not None  # noqa: S101 (else it is no place)
            return end_of(given.description, self.kind)
        robot = next(robot for robot in given.cell.robots if robot.name == self.robot)
        return robot.T_world_base if self.kind == "base" else robot.T_object_tip

    def with_pose(self, choices: Choices, pose: RigidTransform) -> Choices:
        """Choices with another pose, whose position is rounded: no hand is as exact as a number of a gizmo."""
        pose = RigidTransform(pose.R, np.round(pose.p, DECIMALS))
        if self.kind == "base":
            return choices.with_base(self.robot, pose)
        if self.kind == "grasp":
            return choices.with_grasp(self.robot, pose)
        return replace(choices, start=pose) if self.kind == "start" else replace(choices, end=pose)

    def in_world(self, pose: RigidTransform, held: RigidTransform) -> RigidTransform:
        """Where a pose of it is in the world."""
        return held @ pose if self.kind == "grasp" else pose

    def from_world(self, pose: RigidTransform, held: RigidTransform) -> RigidTransform:
        """The opposite of `in_world`."""
        return held.inverse() @ pose if self.kind == "grasp" else pose


def places(given: Given) -> list[Place]:
    """All that can be moved: of a machine with several arms the base of the first, of a table's motion no end."""
    cell = given.cell
    bases = [Place("base", robot.name) for robot in cell.robots if machine_of(cell, robot.name)[0] == robot.name]
    grasps = [Place("grasp", robot.name) for robot in cell.robots]
    return [*bases, *grasps, *([Place("start"), Place("end")] if given.description is not None else [])]


def end_of(description: MotionDescription, which: Literal["start", "end"]) -> RigidTransform:
    """Pose of the object at the start or the end of a motion that is described by poses."""
    waypoints = description.waypoints
    pose = getattr(description, which) if waypoints is None else waypoints[0 if which == "start" else -1]
    transform: RigidTransform = pose.transform
    return transform


def free_axes(cell: Cell) -> tuple[str, str]:
    """Axes along which, and about which poses of a cell may move: two and one in a plane."""
    if cell.plane is None:
        return "xyz", "xyz"
    return cell.plane, "".join(sorted({*"xyz"} - {*cell.plane}))


def offset_of(pose: RigidTransform, given: RigidTransform) -> tuple[Array, Array]:
    """How far a pose is from the given one: the shift [m] and the turn as a vector [rad], each Shape (3,)."""
    return pose.p - given.p, vectors_from_rotations((pose.R @ given.R.T)[None])[0]


def moved_by(given: RigidTransform, shift: Array, turn: Array) -> RigidTransform:
    """The opposite of `offset_of`."""
    return RigidTransform(rotations_from_vectors(turn[None])[0] @ given.R, given.p + shift)


def in_plane(cell: Cell, pose: RigidTransform, given: RigidTransform) -> RigidTransform:
    """The pose nearest to one that a planar cell may have; of a spatial cell itself."""
    if cell.plane is None:
        return pose
    shift, turn = offset_of(pose, given)
    normal = plane_normal(cell.plane)
    return moved_by(given, shift - normal * (normal @ shift), normal * (normal @ turn))
