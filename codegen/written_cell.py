# SPDX-License-Identifier: MIT
"""The cell file of a cell as it is now: written from its manifest, read again, and compared."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from mrts_codegen.cell_file import CellDescription
from mrts_codegen.cell_manifest import cell_manifest
from mrts_codegen.cell_model import build_cell_model
from mrts_codegen.urdf.urdf_file import read_urdf
from mrts_codegen.urdf.urdf_joint import friction
from mrts_codegen.urdf_reference import resolve_urdf

from mrts.base.errors import InputError
from mrts.base.input_file import validated
from mrts.base.manifest import ChainsRecord, Manifest, PoseRecord, RobotRecord
from mrts.base.rigid_transform import rpy_from_rotation
from mrts.base.yaml_parser import parse_yaml, yaml_text

COMPARED = ("name", "plane", "gravity", "object", "robots")
"""What a cell file says of a manifest."""


SAME_ROTATION = 1e-12
"""Largest difference of an entry of a rotation that comes back from its angles: rounding, or a matrix of other make."""


def cell_file_text(manifest: Manifest, folder: Path, beside: Path | None) -> str:
    """Text of a cell file that reads back to a cell.

    Args:
        manifest: Of the cell as it is now.
        folder: That its URDFs are relative to, absolute.
        beside: Where the file will stand, absolute; URDFs there or below are given relative to it.

    Raises:
        InputError: If a cell file cannot hold the cell, or a URDF is not there as it was.
    """
    where = Path(f"cell '{manifest.name}'")
    urdfs = [resolve_urdf(where, folder, robot.urdf) for robot in manifest.robots]
    references = [_reference(robot.urdf, urdf, beside) for robot, urdf in zip(manifest.robots, urdfs, strict=True)]
    robots = [
        _described_robot(where, robot, reference, urdf)
        for robot, reference, urdf in zip(manifest.robots, references, urdfs, strict=True)
    ]
    text = yaml_text(_described(manifest, robots))
    description = validated(where, parse_yaml(text), CellDescription, "cell file")
    chains = ChainsRecord(**{name: getattr(manifest, name) for name in ChainsRecord.model_fields})
    _check_same(where, manifest, cell_manifest(build_cell_model(where, description, beside or folder), chains))
    return text


def _reference(given: str, urdf: Path, beside: Path | None) -> str:
    """How the file names a URDF: as an installed package's, relative to the file, or absolute."""
    if given.startswith("package://"):
        return given
    resolved = urdf.resolve()
    if beside is not None and resolved.is_relative_to(beside):
        return resolved.relative_to(beside).as_posix()
    return resolved.as_posix()


def _described(manifest: Manifest, robots: list[dict[str, Any]]) -> dict[str, Any]:
    carried = manifest.object
    inertia = carried.inertia
    diagonal = not any(inertia[row][column] for row in range(3) for column in range(3) if row != column)
    variation: dict[str, Any] = {name: list(ends) for name, ends in carried.variation.items()}
    if carried.outer_hull:
        variation["hull"] = "outer"
    speeds = _known({"linear": carried.linear_velocity, "angular": carried.angular_velocity})
    thing = {
        "mass": carried.mass,
        "inertia": [inertia[axis][axis] for axis in range(3)] if diagonal else inertia,
        "variation": variation or None,
        "velocity": speeds or None,
    }
    whole = {"name": manifest.name, "gravity": manifest.gravity, "plane": manifest.plane, "object": _known(thing)}
    return _known(whole) | {"robots": robots}


def _described_robot(where: Path, robot: RobotRecord, reference: str, urdf: Path) -> dict[str, Any]:
    lower = [joint.torque_lower for joint in robot.joints]
    upper = [joint.torque_upper for joint in robot.joints]
    symmetric = all(least == -most for least, most in zip(lower, upper, strict=True))
    for contact in robot.contacts:
        if contact.given is None:
            raise InputError(
                where,
                "a cell file cannot hold a contact that was made row by row. Make it with mrts.pad_contact, "
                "rows_contact or their neighbours.",
                key=f"robot '{robot.name}': contact '{contact.name}'",
            )
    bounds = {"lower": robot.wrench_lower, "upper": robot.wrench_upper}
    limited = {side: values for side, values in bounds.items() if any(value is not None for value in values)}
    rates = [robot.contact_rate[0], robot.contact_rate[-1]]
    return _known(
        {
            "name": robot.name,
            "urdf": reference,
            "base_link": robot.base_link,
            "tip_link": robot.tip_link,
            "base": _pose(robot.world_base),
            "grasp": _pose(robot.object_tip),
            "posture": robot.posture,
            "torque": upper if symmetric else {"lower": lower, "upper": upper},
            "wrench": limited or None,
            "contact_rate": None if rates == [None, None] else rates,
            "contact": [contact.given for contact in robot.contacts] or None,
            "fixed": _fixed(robot, urdf) or None,
            "motors": _motors(robot, urdf) or None,
        }
    )


def _pose(pose: PoseRecord) -> dict[str, list[float]]:
    return {"xyz": pose.position, "rpy": rpy_from_rotation(np.array(pose.rotation))}


def _fixed(robot: RobotRecord, urdf: Path) -> dict[str, float]:
    """Joints that are held by themselves; others follow them."""
    followers = {joint.name for joint in read_urdf(urdf).joints if joint.mimic is not None}
    return {name: position for name, position in robot.held.items() if name not in followers}


def _motors(robot: RobotRecord, urdf: Path) -> dict[str, Any]:
    """What is known of them; friction is left out where it is that of the URDF."""
    motors = robot.motors
    described: dict[str, Any] = {"armature": motors.armature} if any(motors.armature) else {}
    joints = {joint.name: joint for joint in read_urdf(urdf).joints}
    of_urdf = [friction(urdf, joints[joint.name]) for joint in robot.joints]
    if of_urdf != list(zip(motors.coulomb, motors.viscous, strict=True)):
        some = any(motors.coulomb) or any(motors.viscous)
        described["friction"] = {"coulomb": motors.coulomb, "viscous": motors.viscous} if some else "none"
    for name in ("torque_speed", "torque_rate", "jerk", "rated"):
        values = getattr(motors, name)
        if any(value is not None for value in values):
            described[name] = values
    return described


def _known(values: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}


def _check_same(where: Path, ours: Manifest, read: Manifest) -> None:
    """Refuse what a cell file cannot hold: what it reads back to is another cell."""
    written, again = (manifest.model_dump(include=set(COMPARED)) for manifest in (ours, read))
    different = _difference(written, again)
    if different is None:
        return
    key, value, found = different
    if key.endswith(".urdf_sha256"):
        raise InputError(where, "the URDF is another one than the cell was made from.", key=key.removesuffix("_sha256"))
    raise InputError(
        where,
        f"a cell file cannot hold this value, it would be read as {json.dumps(found)}: it is another one's to say (the "
        "URDF's), or one value for several.",
        key=key,
        value=value,
    )


def _difference(ours: Any, theirs: Any, key: str = "") -> tuple[str, Any, Any] | None:
    """The first number, text or length in which two values of JSON differ; rotations come back to rounding."""
    if isinstance(ours, dict) and isinstance(theirs, dict) and ours.keys() == theirs.keys():
        pairs = [(f"{key}.{name}".lstrip("."), value, theirs[name]) for name, value in ours.items() if name != "urdf"]
    elif isinstance(ours, list) and isinstance(theirs, list) and len(ours) == len(theirs):
        pairs = [(f"{key}[{place}]", *both) for place, both in enumerate(zip(ours, theirs, strict=True))]
    else:
        same = ours == theirs or (".rotation[" in key and abs(ours - theirs) <= SAME_ROTATION)
        return None if same else (key, ours, theirs)
    found = (_difference(one, other, inside) for inside, one, other in pairs)
    return next((different for different in found if different is not None), None)
