# SPDX-License-Identifier: MIT
"""What was given to a workbench, and what its user changed since: numbers of the cell, ends of the motion, timing."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from mrts.base.formats.pose import Pose
from mrts.base.rigid_transform import RigidTransform, rpy_from_rotation
from mrts.cell.cell import Cell
from mrts.cell.cell_change import CellChange, Changed, with_machine_at
from mrts.following.grasp_closure import ClosureBound
from mrts.motion.joint_table import JointTable
from mrts.motion.motion_file import MotionDescription, sample_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.program.load_sharing import LoadSharing
from mrts.viewer.player_state import Profile

TORQUE_RATE = 11.0
"""Of the smooth profile, where the cell gives none: a multiple of the torque limit per second [1/s]; a Panda's."""


COARSE_SAMPLES = 101
"""Most samples of a coarse answer, where the motion is described by poses."""


@dataclass(frozen=True, eq=False)
class Given:
    """What a workbench starts from.

    Attributes:
        cell: The cell.
        motion: Its motion.
        description: Of a motion from pose to pose or through waypoints, whose ends can be moved; None of a table.
        cell_path: File that the cell is from; None where there is none that can be written anew.
        motion_path: File that the motion is from; likewise.
        sharing: A fixed distribution of the load; None leaves it free.
        closure: As in `mrts.scale`.
        stands: Whether the motion is one of `still_motion`, because none was given: the cell is looked at.
    """

    cell: Cell
    motion: ObjectMotion | JointTable
    description: MotionDescription | None = None
    cell_path: Path | None = None
    motion_path: Path | None = None
    sharing: LoadSharing | None = None
    closure: ClosureBound | None = None
    stands: bool = False

    @property
    def shares(self) -> tuple[float, ...] | None:
        """Shares of the load by arm; None where they are free."""
        if self.sharing is None:
            return None
        arms = len(self.cell.robots)
        shares = np.full(arms, 1 / arms) if self.sharing.shares is None else np.asarray(self.sharing.shares)
        return tuple(shares.tolist())


@dataclass(frozen=True, eq=False, kw_only=True)
class Choices:
    """What differs from what was given; as they are, nothing does.

    Attributes:
        mass: Of the object [kg]; None is the given one.
        corner: Parameters of one load of the cell's box, to look at it alone; None leaves the load uncertain.
        limits: Share of a given limit by its name, both sides alike.
        bases: Bases in the world, by robot.
        grasps: Tips in the object frame, by robot.
        start: Object in the world at the start of the motion; None is the given one.
        end: Likewise at its end.
        postures: Joint positions near which the motion starts, by robot [rad or m]; None are the given ones.
        configuration: What they are called; empty for the given ones.
        profile: How the speed may vary.
        torque_rate: Of the smooth profile, for joints whose rate is not known [1/s].
        shares: Shares of the load by arm; None leaves them free.
    """

    mass: float | None = None
    corner: Mapping[str, float] | None = None
    limits: Mapping[Changed, float] = field(default_factory=dict)
    bases: Mapping[str, RigidTransform] = field(default_factory=dict)
    grasps: Mapping[str, RigidTransform] = field(default_factory=dict)
    start: RigidTransform | None = None
    end: RigidTransform | None = None
    postures: Mapping[str, list[float]] | None = None
    configuration: str = ""
    profile: Profile = "constant"
    torque_rate: float = TORQUE_RATE
    shares: tuple[float, ...] | None = None

    def cell(self, given: Given) -> Cell:
        """The cell as it was chosen.

        Raises:
            InputError: If a number breaks a rule of the cell.
        """
        cell = self.saved_cell(given)
        if self.corner is None or cell.load_box is None:
            return cell
        return cell.with_load(cell.load_box.load_at(self.corner))

    def saved_cell(self, given: Given) -> Cell:
        """The cell as a cell file would hold it: with its whole range of loads.

        Raises:
            InputError: If a number breaks a rule of the cell.
        """
        cell = given.cell if self.mass is None else given.cell.with_mass(self.mass)
        for (kind, robot, element), share in self.limits.items():
            cell = CellChange(kind=kind, robot=robot, element=element, step=share - 1).applied(cell)
        for name, base in self.bases.items():
            cell = with_machine_at(cell, name, base)
        values: dict[str, object] = {f"robots.{name}.grasp": _pose(pose) for name, pose in self.grasps.items()}
        return cell.with_values(values | {f"robots.{name}.posture": q for name, q in (self.postures or {}).items()})

    def motion(self, given: Given, most: int | None = None) -> ObjectMotion | JointTable:
        """The motion as it was chosen.

        Raises:
            InputError: If two waypoints became the same.
        """
        described = self.description(given)
        if described is not None and most is not None and len(given.motion.time) > most:
            return sample_motion(described.model_copy(update={"samples": most}))
        return given.motion if described is given.description or described is None else sample_motion(described)

    def description(self, given: Given) -> MotionDescription | None:
        """The description of the motion as it was chosen; None of a table."""
        described = given.description
        if described is None or (self.start is None and self.end is None):
            return described
        ends = {"start": self.start, "end": self.end}
        moved = {name: _pose(end) for name, end in ends.items() if end is not None}
        keys = {key: value for key, value in described if value is not None}
        if described.waypoints:
            poses = list(described.waypoints)
            poses[0], poses[-1] = moved.get("start", poses[0]), moved.get("end", poses[-1])
            return MotionDescription(**keys | {"waypoints": poses})
        return MotionDescription(**keys | moved)

    def sharing(self) -> LoadSharing | None:
        """The distribution of the load; None where it is free."""
        return None if self.shares is None else LoadSharing(np.array(self.shares))

    def with_limit(self, name: Changed, share: float) -> "Choices":
        """With another share of a limit."""
        others = {key: value for key, value in self.limits.items() if key != name}
        return replace(self, limits=others if share == 1 else others | {name: share})

    def with_base(self, robot: str, pose: RigidTransform) -> "Choices":
        """With the base of a robot, and all of its machine, elsewhere in the world."""
        return replace(self, bases={**self.bases, robot: pose})

    def with_grasp(self, robot: str, pose: RigidTransform) -> "Choices":
        """With a robot that holds the object elsewhere."""
        return replace(self, grasps={**self.grasps, robot: pose})

    def edited(self) -> list[str]:
        """What was changed, in words."""
        words = [] if self.mass is None else [f"mass {self.mass:.4g} kg"]
        words += [f"{robot}/{element} × {share:.4g}" for (_, robot, element), share in self.limits.items()]
        words += [f"{name} base" for name in self.bases] + [f"{name} grasp" for name in self.grasps]
        words += [name for name in ("start", "end") if getattr(self, name) is not None]
        return words + ([f"configuration {self.configuration}"] if self.configuration else [])


def _pose(pose: RigidTransform) -> Pose:
    return Pose(xyz=pose.p.tolist(), rpy=rpy_from_rotation(pose.R))
