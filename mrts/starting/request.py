# SPDX-License-Identifier: MIT
"""What is known when a cell is begun, and where its arms then stand."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mrts.base.arrays import Array
from mrts.base.rigid_transform import RigidTransform
from mrts.starting.arm import Arm


@dataclass(frozen=True, eq=False)
class ArmRequest:
    """One arm of the cell that is begun.

    Attributes:
        arm: With its chain.
        urdf: How the cell file names its URDF.
        path: Where that is, absolute.
        why: Why its tip was chosen, to stand behind the name; empty where the user chose it.
        base: Of its base link in the world, where the user gave it.
        posture: Where the user gave it, Shape (n,) [rad or m].
        xacro_args: Of a xacro, by name.
    """

    arm: Arm
    urdf: str
    path: Path
    why: str = ""
    base: RigidTransform | None = None
    posture: Array | None = None
    xacro_args: Mapping[str, str] = field(default_factory=dict)


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
        score: From 0 to 1; the larger, the farther from limits. 0 where the user gave the postures.
    """

    position: Array
    sides: Array
    lift: Array
    stands: tuple[Stand, ...]
    score: float
