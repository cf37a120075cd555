# SPDX-License-Identifier: MIT
"""One arm as a chain of moving bodies, taken from a URDF; what mass properties a link can have, or is let pass with."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mrts.base.arrays import Array, without_infinity
from mrts.base.errors import NEAREST_INERTIA, InputError, Mistakes, Remark
from mrts.base.formats.urdf import NO_LIMIT, Link, Urdf, UrdfJoint
from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.base.rigid_transform import RigidTransform, multiply
from mrts.cell.cell_file import INERTIA_TOLERANCE, inertia_problem, triangle_excess
from mrts.cell.robot import JointMotors, Robot, RobotSource

TRIANGLE_MARGIN = 0.2
"""Share by which a link's largest principal moment may exceed the sum of the others. Rounding of a file stays below
2 %, but robots in wide use are farther off (the xArm 6 that pybullet ships by 15.6 %), and their users cannot mend
them; the equations stay sound as long as the inertia is positive definite. Beyond this a digit is probably wrong."""

POINT_RADIUS = 1e-7
"""Radius of gyration below which a body is a point mass [m]: exporters leave rounding of zero behind."""


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


NO_BODY = Inertia(0.0, np.zeros(3), np.zeros((3, 3)))


def is_point(link: Link) -> bool:
    """Whether a link of a URDF has a mass but no extent: no moment of inertia of its own."""
    return link.mass > 0 and bool(np.max(np.abs(link.inertia)) <= link.mass * POINT_RADIUS**2)


def nearest_inertia(inertia: Array) -> Array:
    """The inertia of a body that is nearest to a symmetric matrix in the Frobenius norm, Shape (3, 3) [kg m²].

    A body's principal moments are sums of two each of its second moments along the principal axes, which are >= 0.
    """
    from scipy.optimize import nnls  # noqa: PLC0415 (slow to import, for URDFs that are wrong)

    moments, axes = np.linalg.eigh(inertia)
    sums = np.ones((3, 3)) - np.eye(3)
    second, _ = nnls(sums, moments)
    return multiply(axes * (sums @ second), axes.T)


def link_inertia(path: Path, link: Link, remarks: list[Remark], *, lenient: bool = False) -> Inertia:
    """Mass properties of a link in its own frame; without mass there is no body.

    What is let pass is added to `remarks`; `lenient` moves an inertia that no body has to the nearest that one has.
    """
    if link.mass < 0:
        raise InputError(path, "must be >= 0 kg.", key=f"link '{link.name}' mass", value=link.mass)
    if link.mass == 0:
        if np.any(link.inertia):
            text = f"{path.name}: link '{link.name}' has an inertia but no mass; it counts as a frame without a body."
            remarks.append(Remark("massless-inertia", text))
        return NO_BODY
    inertia = np.zeros((3, 3)) if is_point(link) else link.inertia
    if lenient and inertia_problem(inertia, rods=True) and np.any(inertia):
        inertia = nearest_inertia(inertia)
        given, taken = (
            ", ".join(f"{moment:.6g}" for moment in np.linalg.eigvalsh(of)) for of in (link.inertia, inertia)
        )
        text = (
            f"{path.name}: no body has the principal moments of link '{link.name}', {given} kg m²; the nearest "
            f"that one has are taken, {taken} kg m²."
        )
        remarks.append(Remark(NEAREST_INERTIA, text))
    elif np.any(inertia):
        _check_inertia(path, link, remarks)
    return Inertia(link.mass, np.zeros(3), inertia).seen_from(link.origin)


def _check_inertia(path: Path, link: Link, remarks: list[Remark]) -> None:
    problem = inertia_problem(link.inertia, triangle=TRIANGLE_MARGIN, rods=True)
    if problem:
        advice = (
            f"Correct it in the URDF; a moment {100 * TRIANGLE_MARGIN:g} % beyond the sum of the others passes. Or "
            "give 'inertia: lenient' in the cell file: then it is moved to the nearest that a body has."
        )
        raise InputError(path, f"{problem} {advice}", key=f"link '{link.name}' inertia")
    excess = triangle_excess(link.inertia)
    if excess > INERTIA_TOLERANCE:
        text = (
            f"{path.name}: the largest principal moment of link '{link.name}' exceeds the sum of the others by "
            f"{100 * excess:.2g} %, which no body's does; it is taken as it is."
        )
        remarks.append(Remark("inertia-triangle", text))


@dataclass(frozen=True, kw_only=True, eq=False)
class Joint(UrdfJoint):
    """A moving joint and the body behind it.

    Attributes:
        placement: Joint frame at position 0 in the frame of the joint before (the base for the first).
        body: All links that this joint carries up to the next chain joint, joint frame.
        placed_by_held: Whether the placement depends on where held joints stand.
        laden_by_held: Whether the body does.
        point_links: Of the body's links those that have a mass but no extent.
    """

    placement: RigidTransform
    body: Inertia
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
        T_base_root: Root of the URDF in the base link, joints in between held or at zero.
        remarks: What to know of the links that it carries.
    """

    base_link: str
    tip_link: str
    joints: tuple[Joint, ...]
    tip: RigidTransform
    tip_by_held: bool
    T_base_root: RigidTransform
    remarks: tuple[Remark, ...] = ()

    def numbers(self) -> Iterator[tuple[Array, bool]]:
        """Of each joint R by rows and p, then com and inertia by rows of its body, of the tip R and p [1, m, kg m²].

        Each with whether it depends on where held joints stand.
        """
        for joint in self.joints:
            yield joint.placement.numbers, joint.placed_by_held
            yield np.append(joint.body.com, joint.body.at_com), joint.laden_by_held
        yield self.tip.numbers, self.tip_by_held

    def held_numbers(self) -> Array:
        """What of the chain depends on where held joints stand, in order, Shape (h,) [1, m, kg m²]."""
        return np.concatenate([np.empty(0), *(numbers for numbers, by_held in self.numbers() if by_held)])

    def attributes(
        self, components: int, *, urdf: str, sha256: str, fixed: Mapping[str, float], held: Mapping[str, float]
    ) -> dict[str, Any]:
        """Attributes of `mrts.cell.robot.Robot` as the URDF alone gives them, all but the name.

        Nothing limits wrenches of so many components, the arm stands and holds nowhere yet, and efforts that say
        nothing are infinite.
        """
        *frames, tip = self.zero_frames()
        n, free = len(self.joints), np.full(len(self.joints), np.inf)
        effort = np.array([joint.effort if 0 < joint.effort < NO_LIMIT else np.inf for joint in self.joints])
        velocity = np.array([joint.velocity for joint in self.joints])
        coulomb, viscous = (tuple(getattr(joint, of) for joint in self.joints) for of in ("coulomb", "viscous"))
        return {
            "joints": tuple(joint.name for joint in self.joints),
            "joint_types": tuple(joint.kind for joint in self.joints),
            "axes": np.array([multiply(frame.R, joint.axis) for joint, frame in zip(self.joints, frames, strict=True)]),
            "points": np.array([frame.p for frame in frames]),
            "T_base_tip": tip,
            "position_lower": np.array([joint.lower for joint in self.joints]),
            "position_upper": np.array([joint.upper for joint in self.joints]),
            "velocity_limit": velocity,
            "acceleration_lower": -free,
            "acceleration_upper": free,
            "T_world_base": RigidTransform.identity(),
            "T_object_tip": RigidTransform.identity(),
            "posture": np.zeros(n),
            "torque_lower": -effort,
            "torque_upper": effort,
            "wrench_lower": np.full(components, -np.inf),
            "wrench_upper": np.full(components, np.inf),
            "source": RobotSource(
                urdf=urdf,
                sha256=sha256,
                base_link=self.base_link,
                tip_link=self.tip_link,
                fixed=dict(fixed),
                T_base_root=self.T_base_root,
                carried_mass=tuple(joint.body.mass for joint in self.joints),
                point_links=tuple(joint.point_links for joint in self.joints),
                effort=(*effort.tolist(),),
                velocity=(*without_infinity(velocity),),
                joint_limits=None,
                friction=(coulomb, viscous),
            ),
            "held": held,
            "held_numbers": self.held_numbers(),
            "motors": replace(JointMotors.unknown(n), coulomb=np.array(coulomb), viscous=np.array(viscous)),
            "contacts": (),
            "contact_rate": np.full(components, np.inf),
            "point_limits": (),
        }

    def zero_frames(self) -> list[RigidTransform]:
        """Joint frames, then the tip, in the base frame with every joint at zero."""
        frames = [RigidTransform.identity()]
        for step in (*(joint.placement for joint in self.joints), self.tip):
            frames.append(frames[-1] @ step)
        return frames[1:]


class BuiltRobot(NamedTuple):
    """One arm as a cell file and its URDF give it; remarks say where values are from."""

    robot: Robot
    model: RobotModel
    urdf: Urdf
    remarks: tuple[Remark, ...]


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
    base_link = base_link or urdf.root
    chain = _chain(path, urdf, base_link, tip_link)
    stops = {joint.child for joint in chain if joint.moves and joint.name not in held}
    hanging: dict[str, list[UrdfJoint]] = {}
    for joint in urdf.joints.values():
        hanging.setdefault(joint.parent, []).append(joint)
    mistakes, remarks = Mistakes(), list[Remark]()

    def carried(first: str) -> tuple[Inertia, bool, tuple[str, ...]]:
        """All that a joint carries up to the next, in the frame of its first link; whether held joints place any."""
        total, by_held, points = NO_BODY, False, list[str]()
        pending = [(first, RigidTransform.identity())]
        while pending:
            name, T_body_link = pending.pop()
            link = urdf.links[name]
            with mistakes.noted():
                total = total + link_inertia(path, link, remarks, lenient=lenient).seen_from(T_body_link)
                points += [name] if is_point(link) else []
            below = [joint for joint in hanging.get(name, []) if joint.child not in stops]
            by_held |= any(joint.name in held for joint in below)
            pending += [(joint.child, T_body_link @ joint.pose(held.get(joint.name, 0.0))) for joint in below]
        return total, by_held, tuple(points)

    joints = []
    placement, placed_by_held = RigidTransform.identity(), False
    for joint in chain:
        with mistakes.noted():
            _check_kind(path, joint, moves=joint.child in stops)
            placement = placement @ joint.pose(held.get(joint.name, 0.0))
            placed_by_held |= joint.name in held
            if joint.child not in stops:
                continue
            body, laden_by_held, point_links = carried(joint.child)
            joint.check(path)
            joints.append(
                Joint(
                    **vars(joint),
                    placement=placement,
                    body=body,
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
        T_base_root=frame_in_root(urdf, base_link, held).inverse(),
        remarks=(*remarks, *_follower_remarks(path, urdf, joints)),
    )


def frame_in_root(urdf: Urdf, link: str, held: Mapping[str, float]) -> RigidTransform:
    """Frame of a link in the root of its URDF, joints in between held where `held` says, else at zero."""
    T = RigidTransform.identity()
    for joint in urdf.joints_to(link):
        T = T @ joint.pose(held.get(joint.name, 0.0))
    return T


def _follower_remarks(path: Path, urdf: Urdf, moving: list[Joint]) -> Iterator[Remark]:
    """Joints off the chain that follow one of it: the model leaves them at zero."""
    followers = [joint for joint in urdf.joints.values() if joint.mimic]
    for leader in moving:
        names = [f"'{joint.name}'" for joint in followers if joint.mimic and joint.mimic.joint == leader.name]
        if names:
            yield Remark(
                "follower-at-zero",
                f"{path.name}: {', '.join(names)} would move with joint '{leader.name}' of the chain, but what is "
                "off the chain is taken to stay at zero.",
            )


def _check_kind(path: Path, joint: UrdfJoint, *, moves: bool) -> None:
    if not joint.moves and joint.type != "fixed":
        rule = "a joint on the chain must be one of revolute, continuous, prismatic, fixed."
        raise InputError(path, rule, key=f"joint '{joint.name}' type", value=joint.type)
    if moves and joint.mimic is not None:
        raise InputError(
            path,
            f"it moves with '{joint.mimic.joint}', but each joint on the chain must have a motor of its own. Choose a "
            f"tip before it, or hold '{joint.mimic.joint}' still: 'fixed' in the cell file.",
            key=f"joint '{joint.name}' mimic",
        )


def _chain(path: Path, urdf: Urdf, base_link: str, tip_link: str) -> list[UrdfJoint]:
    joints = urdf.joints_to(tip_link)
    place = [tip_link, *(joint.parent for joint in reversed(joints))]
    if base_link not in place:
        raise InputError(path, f"is not below base_link '{base_link}'.", key="tip_link", value=tip_link)
    return joints[len(joints) - place.index(base_link) :]


def arm_chain(path: Path, urdf: Urdf, base_link: str | None, tip_link: str) -> tuple[Robot, Array]:
    """The chain of a URDF from a base link to a tip link, which stands and holds nowhere yet.

    Returns:
        The arm, efforts that the URDF lacks infinite, and the centre of mass of what each joint carries up to the next,
        base frame with every joint at zero, Shape (n, 3) [m].
    """
    model = build_robot_model(path, urdf, base_link, tip_link)
    attributes = model.attributes(len(WRENCH_COMPONENTS), urdf=str(path), sha256="", fixed={}, held={})
    robot = Robot(name=tip_link, **attributes)
    pairs = zip(model.zero_frames()[:-1], model.joints, strict=True)
    return robot, np.array([frame.p + frame.R @ joint.body.com for frame, joint in pairs])
