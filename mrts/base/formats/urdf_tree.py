# SPDX-License-Identifier: MIT
"""What a URDF says before anybody has chosen a chain of it, and what a chain of it is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from mrts.base.arrays import Array
from mrts.base.rigid_transform import RigidTransform


@dataclass(frozen=True)
class JointEnds:
    """What a joint of a URDF stands between.

    Attributes:
        name: In the URDF.
        type: Likewise: "revolute", "fixed", "floating", ….
        parent: Link before it.
        child: Link behind it.
        follows: Whether it mimics another joint.
    """

    name: str
    type: str
    parent: str
    child: str
    follows: bool


@dataclass(frozen=True)
class UrdfTree:
    """Links and joints of a URDF.

    Attributes:
        root: The link that hangs from no joint.
        links: All links, in the order of the file.
        joints: By the link behind each.
    """

    root: str
    links: tuple[str, ...]
    joints: dict[str, JointEnds]

    def chain(self, tip: str) -> tuple[JointEnds, ...]:
        """Joints from the root to a link.

        Args:
            tip: The link.
        """
        joints: list[JointEnds] = []
        while tip in self.joints:
            joints.append(self.joints[tip])
            tip = joints[-1].parent
        return tuple(reversed(joints))


@dataclass(frozen=True, eq=False)
class ArmChain:
    """A chain of a URDF from base link to tip link; n joints that move, all numbers with every joint at zero.

    Attributes:
        base_link: Where it begins.
        tip_link: Where it ends.
        joints: Names of the joints that move.
        types: Whether each turns or slides.
        axes: In the base frame, Shape (n, 3).
        points: A point on each axis, base frame, Shape (n, 3) [m].
        lower: Position limits, minus infinity where there is none, Shape (n,) [rad or m].
        upper: Likewise, infinity where there is none.
        effort: What the URDF says of each motor, None where it says nothing or 0 [N m or N].
        velocity: Likewise [rad/s or m/s].
        mass: Of what each joint carries up to the next, Shape (n,) [kg].
        point_links: Names of those of its links that have a mass but no inertia, by joint.
        com: Its centre of mass in the base frame, Shape (n, 3) [m].
        T_base_tip: Tip in the base frame.
        T_root_base: Base link in the URDF's root.
    """

    base_link: str
    tip_link: str
    joints: tuple[str, ...]
    types: tuple[Literal["revolute", "prismatic"], ...]
    axes: Array
    points: Array
    lower: Array
    upper: Array
    effort: tuple[float | None, ...]
    velocity: tuple[float | None, ...]
    mass: Array
    point_links: tuple[tuple[str, ...], ...]
    com: Array
    T_base_tip: RigidTransform
    T_root_base: RigidTransform


Survey = Callable[[str | None, str], ArmChain]
"""The chain of a URDF from a base link, None for its root, to a tip link."""
