# SPDX-License-Identifier: MIT
"""Velocity, acceleration and jerk limits of joints from MoveIt's joint_limits.yaml."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from mrts.base.errors import InputError, Remark
from mrts.base.formats.record import Finite, Rule, checked_fields
from mrts.base.input_file import FileReference, read_data
from mrts.base.words import first_names

QUANTITIES = ("velocity", "acceleration", "jerk")

SHOWN = 6
"""Names that a message lists."""

WRAPPERS = ("/**", "ros__parameters", "robot_description_planning")
"""Keys that files of ROS parameters put around those of MoveIt."""


KINDS: dict[str, Any] = {f"has_{of}_limits": bool for of in QUANTITIES}
KINDS |= {f"max_{of}": Finite | None for of in QUANTITIES}
"""Of the keys of an entry; `has_…: false` says that there is no such limit."""

DEFAULTS = {name: True if name.startswith("has_") else None for name in KINDS}

FACTORS: dict[str, Any] = {f"default_{of}_scaling_factor": Annotated[float, Rule(gt=0, le=1)] for of in QUANTITIES[:2]}
"""Of the file: what its limits, and velocities of the URDF, are multiplied by."""


def add_joint_limits(
    values: dict[str, Any], path: Path, key: str, robot: str, text: str, folder: Path
) -> Iterator[Remark]:
    """Put the limits of a joint_limits.yaml in the place of those that a robot has of its URDF.

    Args:
        values: Attributes of the robot.
        path: The cell file.
        key: Where it names the file.
        robot: Name of the robot.
        text: What it names.
        folder: Of the cell file.

    Returns:
        What of the file is not taken as it reads.
    """
    reference, joints = FileReference(text, key, "joint limits file"), values["joints"]
    file, sha256 = reference.path(path, folder), reference.sha256(path, folder)
    data = read_data(file, "joint limits file")
    while isinstance(data, dict) and (wrapper := next((name for name in WRAPPERS if name in data), None)) is not None:
        data = data[wrapper]
    entries = data.get("joint_limits") if isinstance(data, dict) else None
    if not isinstance(entries, dict):
        raise InputError(file, "must be MoveIt's joint_limits.yaml: a mapping of joints.", key="joint_limits")
    known = [name for name in joints if name in entries]
    if not known:
        here = first_names([str(name) for name in entries], SHOWN)
        rule = f"has no joint of robot '{robot}' ({first_names(joints, SHOWN)}): it names {here}."
        raise InputError(file, rule, key="joint_limits")
    read, passed = {}, dict[str, str]()
    for name in known:
        given = {} if entries[name] is None else entries[name]
        if not isinstance(given, dict):
            rule = "must be a mapping, such as {has_velocity_limits: true, max_velocity: 2.0}."
            raise InputError(file, rule, key=f"joint_limits.{name}", value=given)
        passed |= {other: name for other in given if other not in KINDS}
        try:
            read[name] = _limits({key: given[key] for key in KINDS if key in given})
        except InputError as error:
            raise error.inside(file, f"joint_limits.{name}") from None
    try:
        given = {key: data[key] for key in FACTORS if key in data}
        scales = checked_fields(FACTORS, dict.fromkeys(FACTORS, 1.0), given)
    except InputError as error:
        raise error.inside(file) from None
    factors = dict(zip(QUANTITIES, scales.values(), strict=False))
    velocity, acceleration, jerk = (
        np.array([read[j][of] if j in read else np.nan for j in joints]) * factors.get(of, 1.0) for of in QUANTITIES
    )
    most = np.where(np.isnan(acceleration), np.inf, acceleration)
    if not np.isnan(jerk).all():
        values["motors"] = replace(values["motors"], jerk=np.where(np.isnan(jerk), np.inf, jerk))
    of_urdf = values["velocity_limit"] * factors["velocity"]
    values |= {
        "velocity_limit": np.where(np.isnan(velocity), of_urdf, velocity),
        "acceleration_lower": -most,
        "acceleration_upper": most,
        "source": replace(values["source"], velocity=None, joint_limits=(text, sha256)),
    }
    return _remarks(robot, key, file.name, factors, passed)


def _limits(entry: dict[str, Any]) -> dict[str, float]:
    """Of each quantity, infinity where it says that there is none, NaN where it says nothing."""
    given, limits = checked_fields(KINDS, DEFAULTS, entry), {}
    for of in QUANTITIES:
        most = given[f"max_{of}"]
        limits[of] = np.inf if not given[f"has_{of}_limits"] else np.nan if most is None else most
        if limits[of] <= 0:
            raise InputError("", f"'max_{of}' must be > 0 unless 'has_{of}_limits' is false.")
    return limits


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
