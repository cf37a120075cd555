# SPDX-License-Identifier: MIT
"""One arm of a cell, with its motors."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, without_infinity
from mrts.base.errors import InputError, as_array
from mrts.base.formats.record import MadeAgain, Rule, Shape, check_attributes
from mrts.base.input_file import LARGEST_NUMBER, SMALLEST_NUMBER
from mrts.base.manifest import MOST
from mrts.base.rigid_transform import PLANE_TOLERANCE, RigidTransform, is_rotation, multiply, plane_normal
from mrts.base.words import interval_text
from mrts.cell.hands import Contact
from mrts.cell.points import ArmPointLimit

PRINTED_TOLERANCE = 1e-4
"""How far a position that is given may pass its limit [rad or m]: it may carry few digits."""

ROUNDED_SLOPE = 1e-9
"""Share by which a torque-speed curve may miss falling and concave: corners printed with few digits lie on one line."""

EFFECTS = ("armature", "coulomb", "viscous")
"""What moves a motor's torque, a number a joint."""

RATINGS = ("torque_rate", "jerk", "rated", "power")
"""What a motor bears at most, likewise."""

PER_JOINT = (*EFFECTS, *RATINGS)

NONE_GIVEN = dict.fromkeys(EFFECTS, 0.0) | dict.fromkeys(RATINGS, np.inf)
"""What they are where nothing is known: no effect, no limit."""

PerJoint = Annotated[Array, Shape("n")]
OfWrench = Annotated[Array, Shape("w")]

DEGREES_SUSPECTED = 4 * np.pi
"""A joint position beyond two turns is rather degrees than radians."""

JOINT_HEAD = ("type", "torque", "position", "velocity")


Effect = Annotated[Array, Shape("n", finite=True, least=0.0, most=LARGEST_NUMBER)]
Rating = Annotated[Array, Shape("n", least=SMALLEST_NUMBER)]


@dataclass(frozen=True, kw_only=True, eq=False)
class JointMotors(MadeAgain):
    """The motors of n joints, on the joint side of their gears; of a prismatic joint read kg, N, N s/m, m/s.

    Attributes:
        armature: Rotor inertia times gear ratio squared, Shape (n,) [kg m²].
        coulomb: Dry friction, Shape (n,) [N m].
        viscous: Friction that grows with the speed, Shape (n,) [N m s/rad].
        torque_speed: One a joint: corners |q̇|, |τ| of the largest torque while the motor drives, falling and concave
            from standstill to its largest speed, Shape (c, 2) [rad/s, N m]; None where there is none.
        torque_rate: Largest change of the torque, infinity where it is not known, Shape (n,) [N m/s].
        jerk: Likewise of the acceleration, Shape (n,) [rad/s³].
        rated: Continuous (rated) torque, likewise, Shape (n,) [N m].
        power: Largest power that the motor gives or takes up, likewise, Shape (n,) [W].

    Raises:
        InputError: If a number is negative or a curve rises, bends upward or does not start at standstill.
    """

    armature: Effect
    coulomb: Effect
    viscous: Effect
    torque_speed: Annotated[tuple[Array | None, ...], Shape("n")]
    torque_rate: Rating
    jerk: Rating
    rated: Rating
    power: Rating

    def __post_init__(self) -> None:
        check_attributes(self, JointMotors, "motors", n=len(self.torque_speed))
        curves = tuple(None if curve is None else _checked_curve(j, curve) for j, curve in enumerate(self.torque_speed))
        object.__setattr__(self, "torque_speed", curves)

    @classmethod
    def unknown(cls, joints: int) -> Self:
        """Ideal motors: no inertia, no friction, no limits but those of the torque."""
        return cls(torque_speed=(None,) * joints, **{name: np.full(joints, NONE_GIVEN[name]) for name in PER_JOINT})

    @cached_property
    def has_effect(self) -> bool:
        """Whether torques differ from those of ideal motors."""
        return self.has_friction or bool(np.any(self.armature))

    @cached_property
    def has_friction(self) -> bool:
        """Whether some of the torque overcomes friction."""
        return bool(np.any(self.coulomb) or np.any(self.viscous))

    def check_torques(self, where: str, lower: Array, upper: Array, joints: Sequence[str]) -> None:
        """Refuse torque limits of a robot, named in the message, that they contradict."""
        for j, joint in enumerate(joints):
            least, most = float(min(-lower[j], upper[j])), float(max(-lower[j], upper[j]))
            if self.coulomb[j] > 0 and not self.coulomb[j] < least:
                rule = f"Coulomb friction of joint '{joint}' is {self.coulomb[j]:g}, which no torque within its limits "
                rule = f"{rule}({lower[j]:g} to {upper[j]:g}) overcomes. Correct one of them."
                raise InputError(where, rule, key=f"motors.friction.coulomb[{j}]")
            curve = self.torque_speed[j]
            if curve is not None and not most <= curve[0, 1] * (1 + ROUNDED_SLOPE):
                rule = (
                    f"the curve of joint '{joint}' gives {curve[0, 1]:g} at standstill, but its torque limit is "
                    f"{most:g}: they contradict each other. Give a 'torque' of at most {curve[0, 1]:g}, or another "
                    "curve."
                )
                raise InputError(where, rule, key=f"motors.torque_speed[{j}]")


def torque_speed_lines(curve: Array) -> list[tuple[float, float]]:
    """The falling lines |τ| <= a - m |q̇| of a curve, as pairs a [N m], m [N m s/rad]."""
    steps = np.diff(curve, axis=0)
    slopes = -steps[:, 1] / steps[:, 0]
    return [(float(t + m * v), float(m)) for (v, t), m in zip(curve[:-1], slopes, strict=True) if m > 0]


def _checked_curve(joint: int, given: object) -> Array:
    key = f"torque_speed[{joint}]"
    curve = as_array(f"motors: {key}", given)

    def refuse(rule: str) -> InputError:
        return InputError("motors", rule, key=key, value=curve.tolist())

    if curve.ndim != 2 or curve.shape[1] != 2 or len(curve) < 2:  # noqa: PLR2004 (pairs, and at least two)
        raise refuse("must be at least two corners [speed, torque].")
    if not np.all((curve >= 0) & (curve <= LARGEST_NUMBER)):
        raise refuse(f"speeds and torques are sizes: they must be >= 0 and at most {LARGEST_NUMBER:.0e}.")
    if curve[0, 0] != 0:
        raise refuse("its first corner must be at standstill: [0, torque].")
    steps = np.diff(curve, axis=0)
    if np.any(steps[:, 0] <= 0):
        raise refuse("its speeds must rise from corner to corner.")
    if np.any(steps[:, 1] > 0):
        raise refuse("its torques must not rise: a motor gives no more torque at a higher speed.")
    slopes = -steps[:, 1] / steps[:, 0]
    if np.any(np.diff(slopes) < -ROUNDED_SLOPE * np.max(slopes)):
        raise refuse(
            "it must fall ever more steeply (be concave): between its corners more must not be possible than on "
            "straight lines. Leave out the corners that bend it upward."
        )
    curve.setflags(write=False)
    return curve


@dataclass(frozen=True, kw_only=True)
class RobotSource:
    """Where an arm is from, and what its URDF says besides.

    Attributes:
        urdf: As the cell file gives it.
        sha256: Hash of the URDF's bytes.
        base_link: Name in the URDF.
        tip_link: Name in the URDF.
        fixed: Joints that the cell file holds still, and where [rad or m].
        T_base_root: Root of the URDF in the base link, joints in between held or at zero.
        carried_mass: Of the links of each joint up to the next, 0 where the URDF gives none [kg].
        point_links: Those of these links that have a mass but no inertia.
        effort: Limits of the URDF that are its torque limits [N m, N]; None where it has others.
        velocity: Likewise its velocity limits, None where there is none [rad/s, m/s].
        joint_limits: A joint_limits.yaml as the cell file names it, and the hash of its bytes; None without one.
        friction: Likewise its Coulomb and viscous friction.
    """

    urdf: str
    sha256: str
    base_link: str
    tip_link: str
    fixed: Mapping[str, float]
    T_base_root: RigidTransform
    carried_mass: tuple[float, ...]
    point_links: tuple[tuple[str, ...], ...]
    effort: tuple[float, ...] | None
    velocity: tuple[float | None, ...] | None
    joint_limits: tuple[str, str] | None
    friction: tuple[tuple[float, ...], tuple[float, ...]] | None


@dataclass(frozen=True, repr=False)
class Robot(MadeAgain):
    """One arm; n_i joints, w wrench components (3 in a planar cell, else 6).

    Attributes:
        name: Name in the cell file.
        joints: Joint names, base to tip.
        joint_types: "revolute" or "prismatic".
        axes: Joint axes in the base frame with every joint at zero, Shape (n_i, 3).
        points: A point on each axis, likewise, Shape (n_i, 3) [m].
        T_base_tip: Tip in the base frame with every joint at zero.
        position_lower: Joint limits, minus infinity where there is none, Shape (n_i,) [rad or m].
        position_upper: Joint limits, infinity where there is none, Shape (n_i,) [rad or m].
        velocity_limit: Infinity where there is none, Shape (n_i,) [rad/s or m/s].
        acceleration_lower: Below 0, minus infinity where there is none, Shape (n_i,) [rad/s² or m/s²].
        acceleration_upper: Above 0, infinity where there is none, Shape (n_i,) [rad/s² or m/s²].
        T_world_base: Base link in the world.
        T_object_tip: Tip link in the object frame.
        posture: Joint positions near which the motion starts, Shape (n_i,) [rad or m].
        torque_lower: Shape (n_i,) [N m or N].
        torque_upper: Shape (n_i,) [N m or N].
        wrench_lower: On F_i, base axes, minus infinity where unbounded, Shape (w,) [N, N m].
        wrench_upper: On F_i, base axes, infinity where unbounded, Shape (w,) [N, N m].
        source: Where it is from.
        held: Joints of its URDF that stand still, and where [rad or m].
        held_numbers: What they make of the chain, an input of the generated functions, Shape (h_i,).
        motors: What stands between motors and joints.
        contacts: What its hand can exert on the object; all of them hold for its one wrench.
        contact_rate: Largest change of F_i, base axes, infinity where it is not known, Shape (w,) [N/s, N m/s].
        point_limits: Points of its links whose motion is limited.

    Raises:
        InputError: If an array has another shape, holds what is no number, a lower limit exceeds the upper one, or two
            contacts have one name.
    """

    name: str
    joints: Annotated[tuple[str, ...], Shape("n"), Rule(min_length=1, max_length=MOST)]
    joint_types: Annotated[tuple[Literal["revolute", "prismatic"], ...], Shape("n")]
    axes: Annotated[Array, Shape("n", 3, finite=True)]
    points: Annotated[Array, Shape("n", 3, finite=True)]
    T_base_tip: RigidTransform
    position_lower: PerJoint
    position_upper: PerJoint
    velocity_limit: Annotated[Array, Shape("n", least=SMALLEST_NUMBER)]
    acceleration_lower: Annotated[Array, Shape("n", most=-SMALLEST_NUMBER)]
    acceleration_upper: Annotated[Array, Shape("n", least=SMALLEST_NUMBER)]
    T_world_base: RigidTransform
    T_object_tip: RigidTransform
    posture: Annotated[Array, Shape("n", finite=True)]
    torque_lower: PerJoint
    torque_upper: PerJoint
    wrench_lower: OfWrench
    wrench_upper: OfWrench
    source: RobotSource
    held: Mapping[str, float]
    held_numbers: Annotated[Array, Shape("h", finite=True)]
    motors: JointMotors
    contacts: tuple[Contact, ...]
    contact_rate: Annotated[Array, Shape("w", least=SMALLEST_NUMBER)]
    point_limits: tuple[ArmPointLimit, ...]

    def __post_init__(self) -> None:
        where = f"robot '{self.name}'"
        n = check_attributes(self, Robot, where)["n"]
        for name in ("T_base_tip", "T_world_base", "T_object_tip"):
            object.__setattr__(self, name, _checked_pose(where, name, getattr(self, name)))
        for kind in ("position", "acceleration", "torque", "wrench"):
            lower, upper = getattr(self, f"{kind}_lower"), getattr(self, f"{kind}_upper")
            wrong = (lower > upper) | (lower == np.inf) | (upper == -np.inf)
            if kind == "torque":
                wrong |= lower == upper
            if np.any(wrong):
                at = int(np.argmax(wrong))
                rule = f"must be {'below' if kind == 'torque' else 'at most'} {kind}_upper, {upper[at]:g}."
                raise InputError(where, rule, key=f"{kind}_lower[{at}]", value=float(lower[at]))
        if len(self.motors.torque_speed) != n:
            raise InputError(where, f"must be those of its {n} joints.", key="motors")
        self.motors.check_torques(where, self.torque_lower, self.torque_upper, self.joints)
        names = [contact.name for contact in self.contacts]
        if len({*names}) < len(names):
            raise InputError(where, "must have names of their own.", key="contacts", value=names)
        for contact in self.contacts:
            if contact.A.shape[1] != len(self.wrench_lower):
                rule = f"must have rows over the {len(self.wrench_lower)} components of its wrench."
                raise InputError(where, rule, key=f"contacts: {contact.name}", value=contact.A.shape)
        object.__setattr__(self, "source", self._source_now())

    def _source_now(self) -> RobotSource:
        """Where it is from, without the limits and the friction of its URDF where it has others."""
        source, motors = self.source, self.motors
        effort, against = (*self.torque_upper.tolist(),), (*(-self.torque_lower).tolist(),)
        friction = (*motors.coulomb.tolist(),), (*motors.viscous.tolist(),)
        return replace(
            source,
            effort=source.effort if source.effort == effort == against else None,
            velocity=source.velocity if source.velocity == (*without_infinity(self.velocity_limit),) else None,
            friction=source.friction if source.friction == friction else None,
        )

    def __repr__(self) -> str:
        return f"<Robot '{self.name}': {', '.join(self.joints)}>"

    def joint_rows(self) -> Iterator[tuple[str, ...]]:
        """Name, kind, limits of torque and position, and largest velocity of each joint, in words."""
        units = zip(self.torque_units, self.position_units, strict=True)
        for index, (torque, position) in enumerate(units):
            fastest = self.velocity_limit[index]
            yield (
                self.joints[index],
                "continuous" if position == "rad" and np.isinf(self.position_upper[index]) else self.joint_types[index],
                interval_text(self.torque_lower[index], self.torque_upper[index], torque),
                interval_text(self.position_lower[index], self.position_upper[index], position),
                f"{fastest:.4g} {position}/s" if np.isfinite(fastest) else "none given",
            )

    @property
    def turns(self) -> NDArray[np.bool_]:
        """Which joints are revolute, Shape (n_i,)."""
        return np.asarray(np.array(self.joint_types) == "revolute")

    @cached_property
    def position_units(self) -> tuple[str, ...]:
        """Unit of each joint's position: "rad" for a revolute joint, "m" for a prismatic one."""
        return tuple("m" if kind == "prismatic" else "rad" for kind in self.joint_types)

    @cached_property
    def torque_units(self) -> tuple[str, ...]:
        """Unit of each joint's torque: "N m" for a revolute joint, "N" for a prismatic one."""
        return tuple("N" if kind == "prismatic" else "N m" for kind in self.joint_types)


def check_plane_kept(robot: Robot, plane: str) -> None:
    """Check that base, joints and grasp of an arm, every joint at zero, stay in the plane of a planar cell."""
    normal, where = plane_normal(plane), f"robot '{robot.name}'"
    if np.max(np.abs(robot.T_world_base.R @ normal - normal)) > PLANE_TOLERANCE:
        rule = f"in a cell with plane {plane} a base may turn about the plane's normal only."
        raise InputError(where, rule, key="base")
    along = np.abs(robot.axes @ normal)
    leaves = np.where(robot.turns, np.abs(along - 1), along) > PLANE_TOLERANCE
    if np.any(leaves):
        joint = robot.joints[int(np.argmax(leaves))]
        rule = (
            f"joint '{joint}' leaves the plane {plane}: a revolute axis must be normal to it, a prismatic axis must "
            "lie in it. Turn the base, or drop 'plane'."
        )
        raise InputError(where, rule, key="urdf")
    turned = multiply(robot.T_base_tip.R, robot.T_object_tip.R.T) @ normal
    if np.max(np.abs(turned - normal)) > PLANE_TOLERANCE:
        angle = np.degrees(np.arccos(np.clip(turned @ normal, -1, 1)))
        rule = (
            f"the tip frame '{robot.source.tip_link}' is tilted by {angle:.4g}° against the object. Choose a grasp "
            f"rotation that differs from the tip's own only about the plane's normal ({plane})."
        )
        raise InputError(where, rule, key="grasp")


def _checked_pose(where: str, key: str, given: RigidTransform) -> RigidTransform:
    R, p = as_array(f"{where}: {key}.R", given.R), as_array(f"{where}: {key}.p", given.p)
    small = np.all(np.abs(np.append(R, p)) <= LARGEST_NUMBER)
    if R.shape != (3, 3) or p.shape != (3,) or not small or not is_rotation(R):
        rule = (
            "must have a rotation R with Shape (3, 3), R Rᵀ = I, det R = 1, and a position p with Shape (3,), each "
            f"number at most {LARGEST_NUMBER:.0e} in size."
        )
        raise InputError(where, rule, key=key, value=given)
    R.flags.writeable = p.flags.writeable = False
    return given if R is given.R and p is given.p else RigidTransform(R, p)
