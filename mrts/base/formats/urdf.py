# SPDX-License-Identifier: MIT
"""What a URDF says before anybody has chosen a chain of it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Mistakes
from mrts.base.rigid_transform import RigidTransform, rotations_from_vectors, snap_rotation

NO_LIMIT = 1e9
"""A limit of this size or more (1e16, the largest float, inf) says "none" [rad, m, N m, N, rad/s, m/s]: no motor gives
a giganewton, and none of the URDFs that people publish has a real limit above 1e5."""


class Link(NamedTuple):
    """A link; without an <inertial> all is 0.

    Attributes:
        name: Its own.
        mass: [kg].
        inertia: About the com in the axes of the origin, Shape (3, 3) [kg m²].
        origin: The com, in the link.
    """

    name: str
    mass: float
    inertia: Array
    origin: RigidTransform


class Mimic(NamedTuple):
    """That a joint stands at multiplier times the position of another, plus offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, kw_only=True, eq=False)
class UrdfJoint:
    """A joint; what it says nothing of is unlimited, or without friction.

    Attributes:
        name: Its own.
        type: "revolute", "continuous", "prismatic", "fixed", "floating" or "planar".
        parent: Link that it hangs from.
        child: Link that hangs from it.
        origin: Frame of the child in the parent, at position zero.
        axis: Unit vector, or zero, in the joint's own frame, Shape (3,).
        lower: Minus infinity if there is none [rad or m].
        upper: Infinity if there is none [rad or m].
        velocity: Infinity if there is none [rad/s or m/s].
        effort: As given, 0 if it says nothing [N m or N].
        coulomb: Dry friction [N m or N].
        viscous: [N m s/rad or N s/m].
        mimic: What it follows.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: RigidTransform
    axis: Array
    lower: float
    upper: float
    velocity: float
    effort: float
    coulomb: float
    viscous: float
    mimic: Mimic | None

    @property
    def moves(self) -> bool:
        """Whether it turns or slides along one axis."""
        return self.type in {"revolute", "continuous", "prismatic"}

    @property
    def kind(self) -> Literal["revolute", "prismatic"]:
        """Of a joint that moves: whether it turns or slides."""
        return "revolute" if self.type in {"revolute", "continuous"} else "prismatic"

    def check(self, path: Path) -> None:
        """Check what a joint that moves must keep; one that nobody moves may break it."""
        where, mistakes = f"joint '{self.name}'", Mistakes()
        if not np.any(self.axis):
            mistakes.add(InputError(path, "must not be zero.", key=f"{where} axis"))
        if self.lower > self.upper:
            rule = (
                f"its lower limit {self.lower:g} exceeds its upper limit {self.upper:g}. Correct them; a joint without "
                "limits is 'continuous', or has none of the two."
            )
            mistakes.add(InputError(path, rule, key=where))
        if self.velocity < 0:
            mistakes.add(InputError(path, "must be >= 0.", key=f"{where} velocity limit", value=self.velocity))
        for name, value in (("friction", self.coulomb), ("damping", self.viscous)):
            if not 0 <= value < NO_LIMIT:
                rule = f"must be >= 0 and below {NO_LIMIT:.0e}."
                mistakes.add(InputError(path, rule, key=f"{where}, <dynamics> {name}", value=value))
        mistakes.raise_noted()

    def pose(self, position: float = 0.0) -> RigidTransform:
        """Frame of the child link in the parent link, where the joint stands at a position [rad or m]."""
        if position == 0:
            return self.origin
        if self.kind == "prismatic":
            return self.origin @ RigidTransform(np.eye(3), position * self.axis)
        return self.origin @ RigidTransform(snap_rotation(rotations_from_vectors(position * self.axis)), np.zeros(3))


@dataclass(frozen=True, eq=False)
class Urdf:
    """A tree of links and joints, in the order of the file.

    Attributes:
        root: The link that hangs from no joint.
        links: By name.
        joints: By the link behind each.
    """

    root: str
    links: dict[str, Link]
    joints: dict[str, UrdfJoint]

    def joints_to(self, link: str) -> list[UrdfJoint]:
        """Joints from the root to a link."""
        joints: list[UrdfJoint] = []
        while link in self.joints:
            joints.insert(0, self.joints[link])
            link = joints[0].parent
        return joints
