# SPDX-License-Identifier: MIT
"""What is known when a cell is begun, and where its arms then stand."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.rigid_transform import RigidTransform, plane_normal
from mrts.scene.arm_meshes import arm_meshes
from mrts.starting.arm import Arm

WIDTH, LIFT, GRID = 0.3, 0.2, 0.12
"""Of the box, of the lift, and between heights that are tried, as shares of the shortest arm's reach."""


@dataclass(frozen=True, eq=False)
class ArmRequest:
    """One arm of the cell that is begun.

    Attributes:
        arm: With its chain.
        urdf: How the cell file names its URDF.
        path: Where that is, absolute.
        why: Why its tip was chosen, to stand behind the name; empty where the user chose it.
        base: Of its base link in the world, where the user gave it.
    """

    arm: Arm
    urdf: str
    path: Path
    why: str = ""
    base: RigidTransform | None = None

    @cached_property
    def overhang(self) -> float:
        """How far meshes that move with the tip reach beyond the tip's origin, where the hand points [m]."""
        robot = self.arm.robot
        try:
            meshes = arm_meshes(self.path, robot.source.base_link, robot.joints)
        except InputError:
            return 0.0
        T, last = robot.T_base_tip, len(robot.joints)
        beyond = [np.max((mesh.vertices - T.p) @ T.R @ self.arm.approach) for body, mesh in meshes if body == last]
        return max([0.0, *map(float, beyond)])


@dataclass(frozen=True, eq=False)
class Request:
    """What a cell is begun from.

    Attributes:
        name: Of the cell.
        arms: Its arms, two or more.
        one_machine: Whether they are arms of one machine, whose bases stay where the URDF has them.
        plane: Of a planar cell, as in a cell file.
        gravity: World, Shape (3,) [m/s²].
        mass: Of the object [kg], where the user gave it.
    """

    name: str
    arms: tuple[ArmRequest, ...]
    one_machine: bool
    plane: str | None
    gravity: Array
    mass: float | None

    @cached_property
    def up(self) -> Array:
        """Against gravity, along an axis of the world; in the plane of a planar cell. Shape (3,)."""
        axes = np.eye(3)
        if self.plane is not None:
            axes = axes[np.abs(plane_normal(self.plane)) == 0]
        along = axes @ self.gravity
        best = int(np.argmax(np.abs(along)))
        if along[best] == 0:
            return np.asarray(axes[-1], dtype=np.float64)
        return np.asarray(-np.sign(along[best]) * axes[best] + 0.0, dtype=np.float64)

    def length(self, share: float) -> float:
        """A share of the shortest arm's reach, of two digits at most [m]."""
        length = share * min(each.arm.reach for each in self.arms)
        step = 10.0 ** np.floor(np.log10(length)) / 2
        return float(np.round(max(np.round(length / step), 1) * step, 6))

    @property
    def width(self) -> float:
        """Between the hands' tips [m]."""
        return self.length(WIDTH)

    @property
    def between_hands(self) -> float:
        """What hands that reach beyond their tips leave of the width, a tenth at least [m]."""
        left = self.width - 2 * max(each.overhang for each in self.arms)
        return max(left, self.width / 10)

    @property
    def grid(self) -> float:
        """Between places that are tried [m]."""
        return self.length(GRID)

    def force(self, mass: float) -> Array:
        """Of each hand on an object at rest, Shape (3,) [N]."""
        force = -mass * self.gravity / len(self.arms)
        return force if self.plane is None else force * (plane_normal(self.plane) == 0)


@dataclass(frozen=True, eq=False)
class Stand:
    """Where an arm stands, and how it holds.

    Attributes:
        T_world_base: Of its base link.
        T_world_tip: Of its hand at the start.
        posture: Shape (n,) [rad or m].
    """

    T_world_base: RigidTransform
    T_world_tip: RigidTransform
    posture: Array


@dataclass(frozen=True, eq=False)
class Layout:
    """Where everything is at the start.

    Attributes:
        position: Of the object, Shape (3,) [m]; its axes are those of the world.
        sides: Of the box that the object is taken for, Shape (3,) [m].
        lift: From the start to the end, Shape (3,) [m].
        stands: By arm.
        score: From 0 to 1; the larger, the farther from limits.
    """

    position: Array
    sides: Array
    lift: Array
    stands: tuple[Stand, ...]
    score: float
