# SPDX-License-Identifier: MIT
"""Velocity, acceleration and jerk limits of the joints, from the cell file and from MoveIt's joint_limits.yaml."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from mrts_codegen.urdf_reference import FileReference

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.pose import Finite
from mrts.base.formats.record import Record, Rule, checked
from mrts.base.input_file import text_of
from mrts.base.remark import Remark
from mrts.base.words import first_names
from mrts.base.yaml_parser import parse_yaml
from mrts.cell.motors import given_acceleration, given_velocity

if TYPE_CHECKING:
    from mrts_codegen.cell_file import RobotDescription

QUANTITIES = ("velocity", "acceleration", "jerk")

SHOWN = 6
"""Names that a message lists."""

WRAPPERS = ("/**", "ros__parameters", "robot_description_planning")
"""Keys that files of ROS parameters put around those of MoveIt."""


class JointMotionLimits(NamedTuple):
    """Limits of the motion of n joints, each Shape (n,); infinity where there is none.

    Attributes:
        velocity: [rad/s, m/s].
        acceleration_lower: [rad/s², m/s²].
        acceleration_upper: Likewise.
        jerk: [rad/s³, m/s³]; None where no joint_limits.yaml gives one.
        from_urdf: Whether the velocities are all those of the URDF.
        file: A joint_limits.yaml as the cell file names it, and the hash of its bytes; None without one.
        remarks: What of that file is not taken as it reads.
    """

    velocity: Array
    acceleration_lower: Array
    acceleration_upper: Array
    jerk: Array | None
    from_urdf: bool
    file: tuple[str, str] | None
    remarks: tuple[Remark, ...]


def joint_motion_limits(
    path: Path, key: str, robot: "RobotDescription", joints: Sequence[str], of_urdf: Array, folder: Path
) -> JointMotionLimits:
    """The limits of a robot: keys of the cell file before its joint_limits.yaml, and that before the URDF."""
    if robot.joint_limits is None:
        free = np.full(len(joints), np.inf)
        found = JointMotionLimits(of_urdf, -free, free, jerk=None, from_urdf=True, file=None, remarks=())
    else:
        found = _of_file(path, f"{key}.joint_limits", robot, joints, of_urdf, folder)
    if robot.velocity is not None:
        velocity = given_velocity(path, f"{key}.velocity", robot.velocity, joints)
        found = found._replace(velocity=velocity, from_urdf=False)
    if robot.acceleration is not None:
        lower, upper = given_acceleration(path, f"{key}.acceleration", robot.acceleration, joints)
        found = found._replace(acceleration_lower=lower, acceleration_upper=upper)
    return found


def joint_limits_reference(text: str) -> FileReference:
    """What a cell file says of a joint_limits.yaml."""
    return FileReference(text, key="robots[].joint_limits", what="joint limits file")


class MoveItLimits(Record):
    """An entry of MoveIt's joint_limits.yaml; `has_…: false` says that there is no such limit."""

    has_velocity_limits: bool = True
    max_velocity: Finite | None = None
    has_acceleration_limits: bool = True
    max_acceleration: Finite | None = None
    has_jerk_limits: bool = True
    max_jerk: Finite | None = None

    def problem(self) -> str:
        """The rule that its limits break; empty if none."""
        wrong = [of for of in QUANTITIES if self.limit(of) <= 0]
        return f"'max_{wrong[0]}' must be > 0 unless 'has_{wrong[0]}_limits' is false" if wrong else ""

    def limit(self, quantity: str) -> float:
        """Infinity where it says that there is none, NaN where it says nothing."""
        most: float | None = getattr(self, f"max_{quantity}")
        return np.inf if not getattr(self, f"has_{quantity}_limits") else np.nan if most is None else most


Share = Rule(gt=0, le=1)


def _of_file(
    path: Path, key: str, robot: "RobotDescription", joints: Sequence[str], of_urdf: Array, folder: Path
) -> JointMotionLimits:
    reference = joint_limits_reference(str(robot.joint_limits))
    file, content = reference.path(path, folder), reference.content(path, folder)
    try:
        data = parse_yaml(text_of(file, "joint limits file", content))
    except ValueError as error:
        raise InputError(file, f"this joint limits file {error}.") from None
    while isinstance(data, dict) and (wrapper := next((name for name in WRAPPERS if name in data), None)) is not None:
        data = data[wrapper]
    entries = data.get("joint_limits") if isinstance(data, dict) else None
    if not isinstance(entries, dict):
        raise InputError(file, "must be MoveIt's joint_limits.yaml: a mapping of joints.", key="joint_limits")
    known = [name for name in joints if name in entries]
    if not known:
        here = first_names([str(name) for name in entries], SHOWN)
        rule = f"has no joint of robot '{robot.name}' ({first_names(joints, SHOWN)}): it names {here}."
        raise InputError(file, rule, key="joint_limits")
    read, passed = {}, dict[str, str]()
    for name in known:
        given = {} if entries[name] is None else entries[name]
        if not isinstance(given, dict):
            rule = "must be a mapping, such as {has_velocity_limits: true, max_velocity: 2.0}."
            raise InputError(file, rule, key=f"joint_limits.{name}", value=given)
        passed |= {other: name for other in given if other not in MoveItLimits.model_fields}
        try:
            read[name] = checked(MoveItLimits, {of: given[of] for of in MoveItLimits.model_fields if of in given})
        except InputError as error:
            raise error.inside(file, f"joint_limits.{name}") from None
    factors = {of: _factor(file, data, of) for of in QUANTITIES[:2]}
    velocity, acceleration, jerk = (
        np.array([read[j].limit(of) if j in read else np.nan for j in joints]) * factors.get(of, 1.0)
        for of in QUANTITIES
    )
    most = np.where(np.isnan(acceleration), np.inf, acceleration)
    return JointMotionLimits(
        velocity=np.where(np.isnan(velocity), of_urdf * factors["velocity"], velocity),
        acceleration_lower=-most,
        acceleration_upper=most,
        jerk=None if np.isnan(jerk).all() else np.where(np.isnan(jerk), np.inf, jerk),
        from_urdf=False,
        file=(reference.text, hashlib.sha256(content).hexdigest()),
        remarks=tuple(_remarks(robot.name, key, file.name, factors, passed)),
    )


def _factor(file: Path, data: dict[str, Any], quantity: str) -> float:
    key = f"default_{quantity}_scaling_factor"
    try:
        value = checked(float, data.get(key, 1.0))
        Share.check(value, value)
    except InputError as error:
        raise error.inside(file, key) from None
    return float(value)


def _remarks(
    robot: str, key: str, file: str, factors: Mapping[str, float], passed: Mapping[str, str]
) -> Iterator[Remark]:
    scaled = [f"{quantity} by {factor:g}" for quantity, factor in factors.items() if factor < 1]
    if scaled:
        yield Remark(
            "joint-limits-scaled",
            f"robot '{robot}': limits of {file}, and velocities of the URDF, are multiplied by its default scaling "
            f"factors ({', '.join(scaled)}), as MoveIt does unless a request says otherwise. Take them out of the file "
            "for the whole range.",
        )
    if passed:
        names = first_names([f"{name} of {joint}" for name, joint in passed.items()], SHOWN)
        yield Remark("joint-limits-passed-over", f"robot '{robot}': of {file} ({key}), mrts does not read {names}.")
