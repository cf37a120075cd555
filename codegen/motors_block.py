# SPDX-License-Identifier: MIT
"""The `motors` of a robot in the cell file."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.pose import Finite
from mrts.base.formats.record import Record, Rule
from mrts.base.remark import Remark
from mrts.cell.motors import NONE_GIVEN, RATINGS, JointMotors

if TYPE_CHECKING:
    from mrts_codegen.cell_file import RobotDescription
    from mrts_codegen.urdf.robot_model import RobotModel

PerJoint = Finite | Annotated[list[Finite], Rule(min_length=1)]
"""One number for all joints, or one each."""

LimitPerJoint = Finite | Annotated[list[Finite | None], Rule(min_length=1)]
"""Likewise; null where it is not known."""

Corner = Annotated[list[Finite], Rule(min_length=2, max_length=2)]
Curve = Annotated[list[Corner], Rule(min_length=2)]
Curves = Annotated[list[Curve | None], Rule(min_length=1)]

OF_FRICTION = ("coulomb", "viscous")
"""The keys of `friction`."""

FEWEST_JOINTS = 3
"""Joints of an arm from which on equal friction is no accident."""

FRICTION_RULE = (
    "must be 'none', which ignores that of the URDF, or give coulomb, viscous or both, such as {coulomb: 5, viscous: 8}"
)


class FrictionDescription(Record):
    """Friction on the joint side; what is absent is none.

    Attributes:
        coulomb: [N m, N for prismatic joints].
        viscous: [N m s/rad, N s/m].
    """

    coulomb: PerJoint = 0.0
    viscous: PerJoint = 0.0

    @classmethod
    def model_validate(cls, data: object) -> Self:
        """What a mapping that is not empty says; one rule is told of all that is none."""
        if not isinstance(data, dict) or not data:
            raise InputError("", f"{FRICTION_RULE}.", value=data)
        return super().model_validate(data)


class MotorsDescription(Record):
    """Motors of one arm, on the joint side of their gears; see docs/cell_file.md.

    Attributes:
        armature: Rotor inertia times gear ratio squared [kg m², kg].
        friction: None takes the <dynamics> of the URDF, 'none' ignores them.
        torque_speed: Corners |q̇|, |τ|: one curve for all joints, or one a joint, null where there is none.
        torque_rate: [N m/s, N/s].
        jerk: [rad/s³, m/s³].
        rated: Continuous (rated) torque [N m, N].
        power: Most that the motor gives or takes up [W].
    """

    armature: PerJoint = 0.0
    friction: FrictionDescription | Literal["none"] | None = None
    torque_speed: Curve | Curves | None = None
    torque_rate: LimitPerJoint | None = None
    jerk: LimitPerJoint | None = None
    rated: LimitPerJoint | None = None
    power: LimitPerJoint | None = None


def build_motors(
    path: Path, key: str, robot: "RobotDescription", model: "RobotModel", limits: tuple[Array, Array]
) -> tuple[JointMotors, tuple[Remark, ...]]:
    """The motors of a robot, and what to say of where their friction is from."""
    given, joints = robot.motors, [joint.name for joint in model.joints]

    def one_a_joint(name: str, values: float | Sequence[float | None] | None, unknown: float = 0.0) -> Array:
        each = list(values) if isinstance(values, Sequence) else [values] * len(joints)
        if len(each) != len(joints):
            rule = f"must be one number for all joints, or {len(joints)}: one for each of {', '.join(joints)}."
            raise InputError(path, rule, key=f"{key}.{name}", value=values)
        return np.array([unknown if value is None else value for value in each], dtype=float)

    remarks: tuple[Remark, ...] = ()
    if given.friction is None:
        friction = {name: [getattr(joint, name) for joint in model.joints] for name in OF_FRICTION}
        if any(map(any, friction.values())):
            remarks = (_of_urdf(robot.name, friction),)
    else:
        chosen = FrictionDescription() if given.friction == "none" else given.friction
        friction = {name: getattr(chosen, name) for name in OF_FRICTION}
    columns = {name: one_a_joint(f"friction.{name}", friction[name]) for name in OF_FRICTION}
    for name in ("armature", *RATINGS):
        columns[name] = one_a_joint(name, getattr(given, name), NONE_GIVEN[name])
    curves = _curves(path, f"{key}.torque_speed", given.torque_speed, joints)
    try:
        motors = JointMotors(torque_speed=curves, **columns)
    except InputError as error:
        block = "friction." if error.key.startswith(OF_FRICTION) else ""
        raise error.inside(path, f"{key}.{block}".rstrip(".")) from None
    contradiction = motors.problem_with(*limits, joints)
    if contradiction is not None:
        of_urdf = contradiction[0].startswith("friction") and bool(remarks)
        advice = " It is that of the URDF's <dynamics>, which 'motors: {friction: none}' ignores." if of_urdf else ""
        raise InputError(path, contradiction[1] + advice, key=f"{key}.{contradiction[0]}")
    return motors, remarks


def _of_urdf(robot: str, friction: dict[str, list[float]]) -> Remark:
    shown = "; ".join(
        f"{name} {', '.join(f'{value:g}' for value in values)}" for name, values in friction.items() if any(values)
    )
    same = any(_same_round_number(values) for values in friction.values())
    return Remark(
        "friction-placeholders" if same else "urdf-friction",
        f"robot '{robot}': friction is that of the URDF's <dynamics> ({shown}), which "
        f"{'looks like' if same else 'is often'} a placeholder. Give "
        "'motors: {friction: …}' in the cell file, or 'motors: {friction: none}' to ignore it.",
    )


def _same_round_number(values: list[float]) -> bool:
    """Whether all joints have the same number, of one digit: of joints of different size, none that was measured is."""
    return len(values) >= FEWEST_JOINTS and {*values} == {float(f"{values[0]:.0e}")} != {0.0}


def _curves(
    path: Path, key: str, given: list[list[float]] | list[list[list[float]] | None] | None, joints: list[str]
) -> tuple[Array | None, ...]:
    if given is None:
        return (None,) * len(joints)
    one = given[0] is not None and not isinstance(given[0][0], list)
    curves = [given] * len(joints) if one else given
    if len(curves) != len(joints):
        rule = (
            f"must be one curve for all joints, or {len(joints)}: one for each of {', '.join(joints)}, null for none."
        )
        raise InputError(path, rule, key=key, value=given)
    return tuple(None if curve is None else np.array(curve, dtype=float) for curve in curves)
