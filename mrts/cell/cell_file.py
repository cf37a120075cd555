# SPDX-License-Identifier: MIT
"""The cell file: n arms, their bases and grasps, the object, the limits; what each key of a robot becomes."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.record import Angle, Finite, Name, Pose, Positive, Record, Rule, Vector3
from mrts.base.load_box import Variation
from mrts.base.manifest import MOST, WRENCH_UNITS
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.hands import Bounds, check_contact, limit_sides, one_each, read_contacts
from mrts.cell.points import CarriedThing, LinkPointLimit, ObjectRates, PointLimit
from mrts.cell.record import BodyShape, Obstacle
from mrts.cell.robot import NONE_GIVEN, JointMotors

INERTIA_TOLERANCE = 1e-9
"""Share by which an inertia may miss symmetry, the triangle inequality, and 0: printed with few digits."""

ROBOT_NAMES_TAKEN = frozenset({"time", "components", "object"})
"""Keys that stand beside the robots' names in results, and what limits of the object are told as."""


MOST_POINTS = 100
"""Limited points of an arm or the object, things on it."""

MOST_CONTACTS = 20
"""Of one robot."""

PerJoint = Finite | Annotated[list[Finite], Rule(min_length=1)]
"""One number for all joints, or one each."""

LimitPerJoint = Finite | Annotated[list[Finite | None], Rule(min_length=1)]
"""Likewise; null where it is not known."""

Limits = Annotated[list[Positive | None], Rule(min_length=1)]
"""One a joint, null where there is none."""

ContactEntry = Annotated[dict[str, dict[str, Any]], check_contact]
Curve = Annotated[list[Annotated[list[Finite], Rule(min_length=2, max_length=2)]], Rule(min_length=2)]

OF_FRICTION = ("coulomb", "viscous")

POSES = {"base": "T_world_base", "grasp": "T_object_tip"}
"""Attributes of a robot by the keys that give them."""

OF_ARM = (*POSES, "posture", "torque", "velocity", "acceleration", "wrench", "contact_rate", "contact", "motors")
"""Keys of a robot that say more than its URDF, each by itself."""


class ObjectDescription(Record):
    """The carried object.

    Attributes:
        mass: [kg].
        inertia: At the com in the object frame: principal moments, Shape (3,), or matrix, Shape (3, 3) [kg m²]; None is
            that of a uniform body of its shape.
        shape: What it looks like.
        variation: What is uncertain of it.
        velocity: How fast it may move.
        acceleration: How fast that may change.
        frames: Points of it whose motion is limited.
        carries: Things that stand loose on it.
    """

    mass: Positive
    inertia: Annotated[list[Finite | Vector3], Rule(min_length=3, max_length=3)] | None = None
    shape: BodyShape | None = None
    variation: Variation | None = None
    velocity: ObjectRates = {}  # noqa: RUF012
    acceleration: ObjectRates = {}  # noqa: RUF012
    frames: Annotated[list[PointLimit], Rule(max_length=MOST_POINTS)] = []  # noqa: RUF012 (each record has its own copies)
    carries: Annotated[list[CarriedThing], Rule(max_length=MOST_POINTS)] = []  # noqa: RUF012

    def inertia_matrix(self) -> Array | None:
        """Inertia at the com in the object frame, Shape (3, 3) [kg m²]; None where it is that of its shape."""
        if self.inertia is None:
            return None
        inertia = np.array(self.inertia, dtype=float)
        return inertia if inertia.ndim == 2 else np.diag(inertia)  # noqa: PLR2004 (a matrix)

    def problem(self) -> str:
        """The rule that its inertia breaks; empty if none."""
        if len({isinstance(entry, list) for entry in self.inertia or ()}) > 1:
            return "its inertia must be three moments or three rows of three values"
        inertia = self.inertia_matrix()
        if inertia is None:
            needed = "its 'inertia' is required, or its 'shape', from which that of a uniform body follows"
            return needed if self.shape is None else ""
        problem = inertia_problem(inertia)
        return problem and f"its inertia {problem}"


class MotorsDescription(Record):
    """Motors of one arm, on the joint side of their gears; see docs/cell_file.md.

    Attributes:
        armature: Rotor inertia times gear ratio squared [kg m², kg].
        friction: `coulomb` [N m, N] and `viscous` [N m s/rad, N s/m], what is absent is none; None takes the
            <dynamics> of the URDF, 'none' ignores them.
        torque_speed: Corners |q̇|, |τ|: one curve for all joints, or one a joint, null where there is none.
        torque_rate: [N m/s, N/s].
        jerk: [rad/s³, m/s³].
        rated: Continuous (rated) torque [N m, N].
        power: Most that the motor gives or takes up [W].
    """

    armature: PerJoint | None = None
    friction: dict[Literal["coulomb", "viscous"], PerJoint] | Literal["none"] | None = None
    torque_speed: Curve | Annotated[list[Curve | None], Rule(min_length=1)] | None = None
    torque_rate: LimitPerJoint | None = None
    jerk: LimitPerJoint | None = None
    rated: LimitPerJoint | None = None
    power: LimitPerJoint | None = None


class RobotDescription(Record):
    """One arm of the cell; see docs/cell_file.md for every key."""

    name: Name
    urdf: Annotated[str, Rule(min_length=1)]
    base_link: str | None = None
    tip_link: str
    base: Pose = Pose()
    grasp: Pose = Pose()
    posture: Annotated[list[Angle], Rule(min_length=1)]
    torque: Annotated[list[Positive], Rule(min_length=1)] | Bounds | None = None
    joint_limits: Annotated[str, Rule(min_length=1)] | None = None
    velocity: Limits | None = None
    acceleration: Limits | Bounds | None = None
    frames: Annotated[list[LinkPointLimit], Rule(max_length=MOST_POINTS)] = []  # noqa: RUF012
    wrench: Bounds = Bounds()
    contact_rate: Annotated[list[Positive | None], Rule(min_length=2, max_length=2)] | None = None
    contact: Annotated[list[ContactEntry], Rule(max_length=MOST_CONTACTS)] = []  # noqa: RUF012
    fixed: dict[str, Angle] = {}  # noqa: RUF012 (each record has its own copies)
    motors: MotorsDescription = MotorsDescription()


def robot_values(
    where: Path | str, key: str, value: Any, robot: Mapping[str, Any], components: Sequence[str]
) -> dict[str, Any]:
    """Attributes of a robot that a key of a cell file gives.

    Args:
        where: The cell file, for messages.
        key: Path of the key, which ends in its name.
        value: Of the key's kind in `RobotDescription`, not None; of a pose a transform as well.
        robot: Attributes without this key.
        components: Of a wrench.

    Raises:
        InputError: If the value does not fit the robot.
    """
    name, joints = key.rpartition(".")[2], robot["joints"]
    if name in POSES:
        return {POSES[name]: value if isinstance(value, RigidTransform) else value.transform}
    found: dict[str, Any] = {}
    if name == "posture":
        found[name] = one_each(where, key, value, joints)
    elif name == "velocity":
        found["velocity_limit"] = one_each(where, key, value, joints, np.inf)
    elif name == "contact_rate":
        force, moment = (np.inf if rate is None else rate for rate in value)
        found[name] = np.array([force if WRENCH_UNITS[one] == "N" else moment for one in components])
    elif name == "contact":
        found["contacts"] = read_contacts(where, key, value, components, robot["T_object_tip"].R)
    elif name == "motors":
        found[name] = _motors(where, key, value, robot["motors"], joints)
    else:
        lower, upper = _sides(where, key, value, components if name == "wrench" else joints)
        found |= {f"{name}_lower": lower, f"{name}_upper": upper}
    return found


def _sides(
    where: Path | str, key: str, value: Bounds | list[float | None], names: Sequence[str]
) -> tuple[Array, Array]:
    if isinstance(value, Bounds):
        lower, upper = limit_sides(where, key, value.lower, value.upper, names)
    else:
        upper = one_each(where, key, value, names, np.inf)
        lower = -upper
    if key.endswith("torque") and not np.all(np.isfinite([lower, upper])):
        raise InputError(where, "must be numbers: each motor has a largest torque.", key=key)
    return lower, upper


def _motors(
    where: Path | str, key: str, given: MotorsDescription, motors: JointMotors, joints: Sequence[str]
) -> JointMotors:
    columns: dict[str, Any] = {}
    for name, value in given:
        if value is None:
            continue
        if name == "friction":
            said = {} if value == "none" else value
            columns |= {of: one_each(where, f"{key}.friction.{of}", said.get(of, 0.0), joints) for of in OF_FRICTION}
        elif name == "torque_speed":
            one = value[0] is not None and not isinstance(value[0][0], list)
            curves = [value] * len(joints) if one else value
            if len(curves) != len(joints):
                rule = f"must be one curve for all joints, or one for each of {', '.join(joints)}, null for none."
                raise InputError(where, rule, key=f"{key}.{name}", value=value)
            columns[name] = tuple(None if curve is None else np.array(curve) for curve in curves)
        else:
            columns[name] = one_each(where, f"{key}.{name}", value, joints, NONE_GIVEN[name])
    try:
        return replace(motors, **columns)
    except InputError as error:
        raise error.inside(where, f"{key}.friction" if error.key.startswith(OF_FRICTION) else key) from None


class CellDescription(Record):
    """A validated cell file."""

    name: Name
    gravity: Vector3
    plane: Literal["xy", "xz", "yz"] | None = None
    power: Positive | None = None
    inertia: Literal["strict", "lenient"] = "strict"
    object: ObjectDescription
    surroundings: Annotated[list[Obstacle], Rule(max_length=MOST)] = []  # noqa: RUF012
    robots: Annotated[list[RobotDescription], Rule(min_length=1)]

    def problem(self) -> str:
        """The rule that its robots' names break; empty if none."""
        names = [robot.name for robot in self.robots]
        for name in names:
            if names.count(name) > 1:
                return f"two robots are called '{name}'; each needs a name of its own"
            if name in ROBOT_NAMES_TAKEN:
                return f"a robot cannot be called '{name}': results use that name"
        return ""


def inertia_problem(inertia: Array, *, triangle: float = INERTIA_TOLERANCE, rods: bool = False) -> str:
    """Why an inertia matrix, Shape (3, 3) [kg m²], is not that of a body; empty if it is.

    A body's inertia is symmetric and positive definite, and no principal moment exceeds the sum of the others.

    Args:
        inertia: At the com.
        triangle: Share by which the largest moment may exceed that sum.
        rods: Whether the least moment may be 0, as that of a rod without thickness.
    """
    if not np.all(np.isfinite(inertia)):
        return "holds a value that is not a finite number."
    scale = float(np.max(np.abs(inertia)))
    if np.max(np.abs(inertia - inertia.T)) > INERTIA_TOLERANCE * scale:
        return "is not symmetric; give ixy = iyx, ixz = izx, iyz = izy."
    moments = np.linalg.eigvalsh(inertia)
    shown = ", ".join(f"{moment:.6g}" for moment in moments)
    if moments[0] < -INERTIA_TOLERANCE * scale or (moments[0] <= 0 and not rods):
        return f"is not positive definite: its principal moments are {shown} kg m². All must be > 0."
    if triangle_excess(inertia) > triangle:
        return (
            f"breaks the triangle inequality: its principal moments are {shown} kg m², and no body has one "
            "larger than the sum of the other two."
        )
    return ""


def triangle_excess(inertia: Array) -> float:
    """Share by which the largest principal moment exceeds the sum of the others; negative if it does not."""
    least, middle, largest = np.linalg.eigvalsh(inertia)
    total = float(least + middle)
    return float(largest) / total - 1 if total > 0 else np.inf
