# SPDX-License-Identifier: MIT
"""One arm as a chain of moving bodies, taken from a URDF."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from mrts_codegen.cell_description import inertia_problem

from mrts.errors import InputError
from mrts.rigid_transform import Array, RigidTransform, multiply, snap_rotation

MOVING_TYPES = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic"}


@dataclass(frozen=True)
class Inertia:
    """Mass properties of a rigid body in some frame.

    Attributes:
        mass: [kg].
        com: Centre of mass, Shape (3,) [m].
        at_com: Rotational inertia about the com, axes of the frame, Shape (3, 3) [kg m²].
    """

    mass: float
    com: Array
    at_com: Array

    @staticmethod
    def zero() -> "Inertia":
        """No body at all."""
        return Inertia(0.0, np.zeros(3), np.zeros((3, 3)))

    def seen_from(self, T: RigidTransform) -> "Inertia":
        """The same body in frame a, where `T` is the pose of its frame in a."""
        return Inertia(self.mass, T.p + multiply(T.R, self.com), multiply(multiply(T.R, self.at_com), T.R.T))

    def __add__(self, other: "Inertia") -> "Inertia":
        mass = self.mass + other.mass
        if mass == 0:
            return self
        com = (self.mass * self.com + other.mass * other.com) / mass
        at_com = self.at_com + other.at_com
        for body in (self, other):
            d = body.com - com
            at_com = at_com + body.mass * (sum(d * d) * np.eye(3) - d[:, None] * d[None, :])
        return Inertia(mass, com, at_com)


@dataclass(frozen=True)
class Joint:
    """A moving joint and the body behind it.

    Attributes:
        name: Name in the URDF.
        kind: Turns or slides.
        axis: Unit vector in the joint's own frame, Shape (3,).
        placement: Joint frame at position 0 in the frame of the joint before (the base for the first).
        body: All links that this joint carries up to the next chain joint, joint frame.
        lower: Position limit, minus infinity if none [rad or m].
        upper: Position limit, infinity if none [rad or m].
        effort: Largest torque or force from the URDF, None if it says nothing [N m or N].
        velocity: Largest velocity from the URDF, None if it says nothing [rad/s or m/s].
    """

    name: str
    kind: Literal["revolute", "prismatic"]
    axis: Array
    placement: RigidTransform
    body: Inertia
    lower: float
    upper: float
    effort: float | None
    velocity: float | None


@dataclass(frozen=True)
class RobotModel:
    """A chain from base link to tip link.

    Attributes:
        base_link: Name in the URDF.
        tip_link: Name in the URDF.
        joints: Moving joints from base to tip.
        tip: Tip frame in the last joint's frame (the base frame if nothing moves).
    """

    base_link: str
    tip_link: str
    joints: tuple[Joint, ...]
    tip: RigidTransform

    def zero_frames(self) -> list[RigidTransform]:
        """Joint frames, then the tip, in the base frame with every joint at zero."""
        frames = [RigidTransform.identity()]
        for step in (*(joint.placement for joint in self.joints), self.tip):
            frames.append(frames[-1] @ step)
        return frames[1:]


def build_robot_model(path: Path, urdf: Any, base_link: str | None, tip_link: str) -> RobotModel:
    """Take the chain from `base_link` to `tip_link` out of a URDF; joints off the chain stay at zero.

    Args:
        path: The URDF file, for messages.
        urdf: What `read_urdf` returned.
        base_link: First link; None takes the URDF's root.
        tip_link: Last link.

    Raises:
        InputError: If a link is unknown, the tip is not below the base, a joint type cannot be modelled, or a
            body is not physical.
    """
    links = {link.name: link for link in urdf.links}
    joint_above = {joint.child: joint for joint in urdf.joints}
    _check_tree(path, links, urdf.joints)
    base_link = base_link or next(name for name in links if name not in joint_above)
    chain = _chain(path, links, joint_above, base_link, tip_link)
    children: dict[str, list[Any]] = {}
    for joint in urdf.joints:
        children.setdefault(joint.parent, []).append(joint)
    moving = [joint for joint in chain if joint.type in MOVING_TYPES]
    stops = {joint.child for joint in moving}

    joints = []
    placement = RigidTransform.identity()
    for urdf_joint in chain:
        if urdf_joint.type not in {*MOVING_TYPES, "fixed"}:
            raise InputError(
                path,
                f"a joint on the chain must be one of {', '.join(MOVING_TYPES)}, fixed.",
                key=f"joint '{urdf_joint.name}' type",
                value=urdf_joint.type,
            )
        if urdf_joint.mimic is not None and urdf_joint.type in MOVING_TYPES:
            raise InputError(
                path,
                f"it moves with '{urdf_joint.mimic.joint}', but each joint on the chain must have a motor of its own.",
                key=f"joint '{urdf_joint.name}' mimic",
            )
        placement = placement @ _pose(urdf_joint.origin)
        if urdf_joint.type in MOVING_TYPES:
            body = _carried(path, links, children, stops, urdf_joint.child)
            joints.append(_joint(path, urdf_joint, placement, body))
            placement = RigidTransform.identity()
    if not joints:
        raise InputError(path, f"no joint moves between '{base_link}' and '{tip_link}'.", key="tip_link")
    return RobotModel(base_link, tip_link, tuple(joints), placement)


def _chain(path: Path, links: dict[str, Any], joint_above: dict[str, Any], base_link: str, tip_link: str) -> list[Any]:
    """The URDF's joints from base link to tip link."""
    for key, name in (("base_link", base_link), ("tip_link", tip_link)):
        if name not in links:
            raise InputError(path, f"there is no such link. Its links are: {', '.join(links)}.", key=key, value=name)
    chain: list[Any] = []
    link = tip_link
    while link != base_link:
        if link not in joint_above:
            raise InputError(path, f"is not below base_link '{base_link}'.", key="tip_link", value=tip_link)
        chain.append(joint_above[link])
        link = joint_above[link].parent
    return chain[::-1]


def _check_tree(path: Path, links: dict[str, Any], joints: list[Any]) -> None:
    parents: dict[str, str] = {}
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in links:
                raise InputError(path, f"names a link '{end}' that is not there.", key=f"joint '{joint.name}'")
        if joint.child in parents:
            raise InputError(path, "hangs from two joints; a URDF must be a tree.", key=f"link '{joint.child}'")
        parents[joint.child] = joint.parent
    first_walk: dict[str, str] = {}  # through each link, by the link where it began
    for start in links:
        link = start
        while link not in first_walk:
            first_walk[link] = start
            link = parents.get(link, link)
        if first_walk[link] == start and link in parents:
            raise InputError(path, "the joints form a loop; a URDF must be a tree.", key=f"link '{link}'")
    if not links:
        raise InputError(path, "has no <link>.")


def _pose(matrix: Array | None) -> RigidTransform:
    if matrix is None:
        return RigidTransform.identity()
    return RigidTransform(snap_rotation(matrix[:3, :3]), matrix[:3, 3].copy())


def _joint(path: Path, joint: Any, placement: RigidTransform, body: Inertia) -> Joint:
    length = float(np.sqrt(sum(joint.axis * joint.axis)))
    if not 0 < length < np.inf:
        raise InputError(path, "must not be zero.", key=f"joint '{joint.name}' axis", value=joint.axis.tolist())
    limit = joint.limit
    turns = joint.type == "continuous"
    lower = -np.inf if turns or limit is None or limit.lower is None else limit.lower
    upper = np.inf if turns or limit is None or limit.upper is None else limit.upper
    return Joint(
        joint.name,
        "prismatic" if joint.type == "prismatic" else "revolute",
        joint.axis / length,
        placement,
        body,
        float(lower),
        float(upper),
        limit.effort if limit is not None and limit.effort else None,
        limit.velocity if limit is not None and limit.velocity else None,
    )


def _carried(path: Path, links: dict[str, Any], children: dict[str, list[Any]], stops: set[str], first: str) -> Inertia:
    """Everything that a chain joint carries up to the next, in the frame of its first link."""
    total = Inertia.zero()
    pending = [(first, RigidTransform.identity())]
    while pending:
        link, T_body_link = pending.pop()
        total = total + _link_inertia(path, links[link]).seen_from(T_body_link)
        pending += [
            (joint.child, T_body_link @ _pose(joint.origin))
            for joint in children.get(link, [])
            if joint.child not in stops
        ]
    return total


def _link_inertia(path: Path, link: Any) -> Inertia:
    inertial = link.inertial
    if inertial is None or (inertial.mass == 0 and not np.any(inertial.inertia)):
        return Inertia.zero()
    if inertial.mass <= 0:
        raise InputError(path, "must be > 0 kg.", key=f"link '{link.name}' mass", value=inertial.mass)
    if not np.any(inertial.inertia):  # a point mass, as small grippers are often given
        return Inertia(inertial.mass, np.zeros(3), inertial.inertia).seen_from(_pose(inertial.origin))
    problem = inertia_problem(inertial.inertia)
    if problem:
        raise InputError(path, problem, key=f"link '{link.name}' inertia")
    return Inertia(inertial.mass, np.zeros(3), inertial.inertia).seen_from(_pose(inertial.origin))
