# SPDX-License-Identifier: MIT
"""What was given to a workbench, and what its user changed since."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.base.formats.record import Pose
from mrts.base.rigid_transform import RigidTransform, rotations_from_vectors
from mrts.base.yaml_text import yaml_text
from mrts.cell.cell import Cell
from mrts.cell.cell_change import CellChange, Changed, machine_of, with_machine_at
from mrts.cell.cell_keys import cell_keys, pose_keys
from mrts.motion.joint_table import JointTable
from mrts.motion.motion_file import MotionDescription, sample_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.viewer.player_state import Profile

TORQUE_RATE = 11.0
"""Of the smooth profile, where the cell gives none: a multiple of the torque limit per second [1/s]; a Panda's."""

DECIMALS = 6
"""Of a position that was moved [m]: what is less is rounding."""


@dataclass(frozen=True, eq=False)
class Given:
    """What a workbench starts from.

    Attributes:
        cell: The cell.
        motion: Its motion; None looks at the cell, which stands with the object in the first arm's hand.
        description: Of a motion from pose to pose or through waypoints, whose ends can be moved; None of a table.
        asked: Options of `mrts.scale`.
    """

    cell: Cell
    motion: ObjectMotion | JointTable | None
    description: MotionDescription | None = None
    asked: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Place:
    """What can be moved: a base in the world, a grasp in the object's frame, or an end of the motion, no robot."""

    kind: Literal["base", "grasp", "start", "end"]
    robot: str = ""

    def __str__(self) -> str:
        return f"{self.robot} {self.kind}" if self.robot else f"{self.kind} of the motion"

    def given(self, given: Given) -> RigidTransform:
        """Its pose as it was given."""
        if not self.robot:
            described = given.description
            assert described is not None  # noqa: S101 (else it is no place)
            poses: Sequence[Pose | None] = described.waypoints or [described.start, described.end]
            pose = poses[0 if self.kind == "start" else -1]
            assert pose is not None  # noqa: S101 (a description has either)
            return pose.transform
        robot = next(robot for robot in given.cell.robots if robot.name == self.robot)
        return robot.T_world_base if self.kind == "base" else robot.T_object_tip


def places(given: Given) -> list[Place]:
    """All that can be moved: of a machine with several arms the base of the first, of a table's motion no end."""
    cell = given.cell
    bases = [Place("base", robot.name) for robot in cell.robots if machine_of(cell, robot.name)[0] == robot.name]
    grasps = [Place("grasp", robot.name) for robot in cell.robots]
    return [*bases, *grasps, *([Place("start"), Place("end")] if given.description is not None else [])]


@dataclass(frozen=True, kw_only=True)
class Choices:
    """What differs from what was given; as they are, nothing does.

    Attributes:
        mass: Of the object [kg]; None is the given one.
        limits: Share of a given limit by its name, both sides alike.
        offsets: Of places that were moved, from where they were given: shift [m], turn as a vector [rad].
        torque_rate: Of the smooth profile, for joints whose rate is not known [1/s].
        speed: That it is played at, the nearest on offer; None is the first choice.
        simulated: Whether a controller plays the motion too, as `mrts.simulate` does.
    """

    mass: float | None = None
    limits: Mapping[Changed, float] = field(default_factory=dict)
    offsets: Mapping[Place, tuple[float, ...]] = field(default_factory=dict)
    profile: Profile = "constant"
    torque_rate: float = TORQUE_RATE
    speed: float | None = None
    simulated: bool = False

    def cell(self, given: Given) -> Cell:
        """The cell as it was chosen.

        Raises:
            InputError: If a number breaks a rule of the cell.
        """
        cell = given.cell
        for (kind, robot, element), share in self.limits.items():
            cell = CellChange(kind=kind, robot=robot, element=element, step=share - 1).applied(cell)
        values: dict[str, object] = {} if self.mass is None else {"object.mass": self.mass}
        for place, pose in self.poses(given).items():
            if place.kind == "base":
                cell = with_machine_at(cell, place.robot, pose)
            elif place.kind == "grasp":
                values[f"robots.{place.robot}.grasp"] = pose
        return cell.with_values(values)

    def motion(self, given: Given) -> ObjectMotion | JointTable | None:
        """The motion as it was chosen, if there is one.

        Raises:
            InputError: If two waypoints became the same.
        """
        described = given.description
        moved: dict[str, Any] = {
            place.kind: Pose(**pose_keys(pose)) for place, pose in self.poses(given).items() if not place.robot
        }
        if described is None or not moved:
            return given.motion
        keys = {key: value for key, value in described if value is not None}
        if described.waypoints:
            start, *between, end = described.waypoints
            moved = {"waypoints": [moved.get("start", start), *between, moved.get("end", end)]}
        return sample_motion(MotionDescription(**keys | moved))

    def with_limit(self, name: Changed, share: float) -> "Choices":
        """With another share of a limit."""
        others = {key: value for key, value in self.limits.items() if key != name}
        return replace(self, limits=others if share == 1 else others | {name: share})

    def with_offset(self, place: Place, offset: Array) -> "Choices":
        """With a place elsewhere, of a base with all of its machine."""
        return replace(self, offsets={**self.offsets, place: tuple(offset.tolist())})

    def offset(self, place: Place) -> Array:
        """How far a place is from where it was given, Shape (6,)."""
        return np.array(self.offsets.get(place, np.zeros(6)))

    def poses(self, given: Given) -> dict[Place, RigidTransform]:
        """Of places that were moved; positions are rounded."""
        moved = {}
        for place in self.offsets:
            start, offset = place.given(given), self.offset(place)
            turn = rotations_from_vectors(offset[None, 3:])[0]
            moved[place] = RigidTransform(turn @ start.R, np.round(start.p + offset[:3], DECIMALS))
        return moved


def free_axes(cell: Cell) -> tuple[str, str]:
    """Axes along which, and about which poses of a cell may move: two and one in a plane."""
    if cell.plane is None:
        return "xyz", "xyz"
    return cell.plane, "".join(sorted({*"xyz"} - {*cell.plane}))


def changed_keys(given: Given, choices: Choices) -> list[str]:
    """What was changed: keys of the cell file as of `Cell.with_values`, and of the motion file, with their values."""
    before, after = cell_keys(given.cell), cell_keys(choices.cell(given))
    parts = [("object", before["object"], after["object"])]
    parts += [(f"robots.{new['name']}", old, new) for old, new in zip(before["robots"], after["robots"], strict=True)]
    lines = [
        f"{where}.{key}: {yaml_text(value, one_line=True)}"
        for where, old, new in parts
        for key, value in new.items()
        if value != old[key] and key != "contact"
    ]
    lines += [  # several keys of a contact say it, or none
        f"robots.{robot}.contact: {element} × {share:.4g}"
        for (kind, robot, element), share in choices.limits.items()
        if kind == "contact"
    ]
    ends = {place.kind: pose_keys(pose) for place, pose in choices.poses(given).items() if not place.robot}
    return [*lines, *(f"{end}: {yaml_text(keys, one_line=True)}" for end, keys in ends.items())]
