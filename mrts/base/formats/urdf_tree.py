# SPDX-License-Identifier: MIT
"""What a URDF says before anybody has chosen a chain of it."""

from dataclasses import dataclass


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
        """Joints from the root to a link."""
        joints: list[JointEnds] = []
        while tip in self.joints:
            joints.append(self.joints[tip])
            tip = joints[-1].parent
        return tuple(reversed(joints))
