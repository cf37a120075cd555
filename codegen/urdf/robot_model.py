# SPDX-License-Identifier: MIT
"""One arm as a chain of moving bodies, taken from a URDF."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from mrts_codegen.urdf.link_inertia import Inertia, is_point, link_inertia
from mrts_codegen.urdf.urdf_file import Urdf, UrdfJoint
from mrts_codegen.urdf.urdf_joint import (
    MOVING_TYPES,
    friction,
    joint_pose,
    position_limits,
    unit_axis,
    velocity_limit,
)

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Mistakes
from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform, multiply


@dataclass(frozen=True, kw_only=True)
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
        effort: Largest torque or force as the URDF gives it, None if it says nothing or 0 [N m or N].
        velocity: Largest velocity from the URDF, None if it says nothing [rad/s or m/s].
        coulomb: Dry friction from the URDF, 0 if it says nothing [N m or N].
        viscous: Likewise what grows with the velocity [N m s/rad or N s/m].
        placed_by_held: Whether the placement depends on where held joints stand.
        laden_by_held: Whether the body does.
        point_links: Of the body's links those that have a mass but no extent.
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
    coulomb: float
    viscous: float
    placed_by_held: bool
    laden_by_held: bool
    point_links: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class RobotModel:
    """A chain from base link to tip link.

    Attributes:
        base_link: Name in the URDF.
        tip_link: Name in the URDF.
        joints: Moving joints from base to tip.
        tip: Tip frame in the last joint's frame (the base frame if nothing moves).
        tip_by_held: Whether it depends on where held joints stand.
        remarks: What to know of the links that it carries.
    """

    base_link: str
    tip_link: str
    joints: tuple[Joint, ...]
    tip: RigidTransform
    tip_by_held: bool
    remarks: tuple[Remark, ...] = ()

    def held_numbers(self) -> Array:
        """What of the chain depends on where held joints stand, in order, Shape (h,) [1, m, kg m²].

        Of a joint that is placed by them R by rows and p, of a body laden by them its com and its inertia by rows, of
        the tip R and p.
        """
        parts: list[Array] = [np.empty(0)]
        for joint in self.joints:
            if joint.placed_by_held:
                parts.append(joint.placement.numbers)
            if joint.laden_by_held:
                parts += [joint.body.com, joint.body.at_com.ravel()]
        if self.tip_by_held:
            parts.append(self.tip.numbers)
        return np.concatenate(parts)

    def of_robot(self) -> dict[str, Any]:
        """Attributes of `mrts.cell.robot.Robot` that the chain alone gives."""
        *frames, tip = self.zero_frames()
        return {
            "joints": tuple(joint.name for joint in self.joints),
            "joint_types": tuple(joint.kind for joint in self.joints),
            "axes": np.array([multiply(frame.R, joint.axis) for joint, frame in zip(self.joints, frames, strict=True)]),
            "points": np.array([frame.p for frame in frames]),
            "T_base_tip": tip,
            "position_lower": np.array([joint.lower for joint in self.joints]),
            "position_upper": np.array([joint.upper for joint in self.joints]),
            "velocity_limit": np.array([np.inf if joint.velocity is None else joint.velocity for joint in self.joints]),
            "held_numbers": self.held_numbers(),
        }

    def zero_frames(self) -> list[RigidTransform]:
        """Joint frames, then the tip, in the base frame with every joint at zero."""
        frames = [RigidTransform.identity()]
        for step in (*(joint.placement for joint in self.joints), self.tip):
            frames.append(frames[-1] @ step)
        return frames[1:]


def build_robot_model(
    path: Path,
    urdf: Urdf,
    base_link: str | None,
    tip_link: str,
    held: Mapping[str, float] | None = None,
    *,
    lenient: bool = False,
) -> RobotModel:
    """The chain from a base link (None: the root) to a tip link; joints off it that are not held stay at zero."""
    held = held or {}
    links = {link.name: link for link in urdf.links}
    check_tree(path, links, urdf.joints)
    base_link = base_link or next(name for name in links if all(joint.child != name for joint in urdf.joints))
    chain = _chain(path, urdf, base_link, tip_link)
    moving = [joint for joint in chain if joint.type in MOVING_TYPES and joint.name not in held]
    stops = {joint.child for joint in moving}
    hanging: dict[str, list[UrdfJoint]] = {}
    for joint in urdf.joints:
        hanging.setdefault(joint.parent, []).append(joint)
    mistakes, remarks = Mistakes(), list[Remark]()

    def carried(first: str) -> tuple[Inertia, bool, tuple[str, ...]]:
        """All that a joint carries up to the next, in the frame of its first link; whether held joints place any."""
        total, by_held, points = Inertia.zero(), False, list[str]()
        pending = [(first, RigidTransform.identity())]
        while pending:
            link, T_body_link = pending.pop()
            with mistakes.noted():
                total = total + link_inertia(path, links[link], remarks, lenient=lenient).seen_from(T_body_link)
                points += [link] if is_point(links[link]) else []
            below = [joint for joint in hanging.get(link, []) if joint.child not in stops]
            by_held |= any(joint.name in held for joint in below)
            pending += [
                (joint.child, T_body_link @ joint_pose(path, joint, held.get(joint.name, 0.0))) for joint in below
            ]
        return total, by_held, tuple(points)

    joints = []
    placement, placed_by_held = RigidTransform.identity(), False
    for joint in chain:
        with mistakes.noted():
            moves = joint.child in stops
            _check_kind(path, joint, moves=moves)
            placement = placement @ joint_pose(path, joint, held.get(joint.name, 0.0))
            placed_by_held |= joint.name in held
            if not moves:
                continue
            body, laden_by_held, point_links = carried(joint.child)
            lower, upper = position_limits(path, joint)
            coulomb, viscous = friction(path, joint)
            joints.append(
                Joint(
                    name=joint.name,
                    kind="prismatic" if joint.type == "prismatic" else "revolute",
                    axis=unit_axis(path, joint),
                    placement=placement,
                    body=body,
                    lower=lower,
                    upper=upper,
                    effort=joint.effort or None,
                    velocity=velocity_limit(path, joint),
                    coulomb=coulomb,
                    viscous=viscous,
                    placed_by_held=placed_by_held,
                    laden_by_held=laden_by_held,
                    point_links=point_links,
                )
            )
            placement, placed_by_held = RigidTransform.identity(), False
    mistakes.raise_noted()
    if not joints:
        raise InputError(path, f"no joint moves between '{base_link}' and '{tip_link}'.", key="tip_link")
    return RobotModel(
        base_link=base_link,
        tip_link=tip_link,
        joints=tuple(joints),
        tip=placement,
        tip_by_held=placed_by_held,
        remarks=(*remarks, *_follower_remarks(path, urdf.joints, moving)),
    )


def _follower_remarks(path: Path, joints: Sequence[UrdfJoint], moving: list[UrdfJoint]) -> Iterator[Remark]:
    """Joints off the chain that follow one of it: the model leaves them at zero."""
    for leader in moving:
        followers = [f"'{joint.name}'" for joint in joints if joint.mimic and joint.mimic.joint == leader.name]
        if followers:
            yield Remark(
                "follower-at-zero",
                f"{path.name}: {', '.join(followers)} would move with joint '{leader.name}' of the chain, but what is "
                "off the chain is taken to stay at zero.",
            )


def _check_kind(path: Path, joint: UrdfJoint, *, moves: bool) -> None:
    if joint.type not in {*MOVING_TYPES, "fixed"}:
        raise InputError(
            path,
            f"a joint on the chain must be one of {', '.join(MOVING_TYPES)}, fixed.",
            key=f"joint '{joint.name}' type",
            value=joint.type,
        )
    if moves and joint.mimic is not None:
        raise InputError(
            path,
            f"it moves with '{joint.mimic.joint}', but each joint on the chain must have a motor of its own. Choose a "
            f"tip before it, or hold '{joint.mimic.joint}' still: 'fixed' in the cell file.",
            key=f"joint '{joint.name}' mimic",
        )


def _chain(path: Path, urdf: Urdf, base_link: str, tip_link: str) -> list[UrdfJoint]:
    links = [link.name for link in urdf.links]
    for key, name in (("base_link", base_link), ("tip_link", tip_link)):
        if name not in links:
            raise InputError(path, f"there is no such link. Its links are: {', '.join(links)}.", key=key, value=name)
    joints = urdf.joints_to(tip_link)
    place = [tip_link, *(joint.parent for joint in reversed(joints))]
    if base_link not in place:
        raise InputError(path, f"is not below base_link '{base_link}'.", key="tip_link", value=tip_link)
    return joints[len(joints) - place.index(base_link) :]


def check_tree(path: Path, links: Mapping[str, Any], joints: Sequence[UrdfJoint]) -> None:
    """Check that joints make a tree of links."""
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
