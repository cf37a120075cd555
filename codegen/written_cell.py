# SPDX-License-Identifier: MIT
"""The cell file of a cell as it is now: written from its manifest, read again, and compared."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from mrts_codegen.cell_file import CellDescription
from mrts_codegen.cell_manifest import cell_manifest
from mrts_codegen.cell_model import build_cell_model
from mrts_codegen.urdf.link_inertia import NEAREST_INERTIA
from mrts_codegen.urdf.urdf_file import parse_urdf
from mrts_codegen.urdf.urdf_joint import friction
from mrts_codegen.urdf_reference import mesh_reference, robot_reference

from mrts.base.errors import InputError
from mrts.base.formats.package_uri import is_uri
from mrts.base.input_file import validated
from mrts.base.manifest import ChainsRecord, Manifest, PoseRecord, RobotRecord, ShapeRecord
from mrts.base.rigid_transform import rpy_from_rotation
from mrts.base.yaml_parser import parse_yaml, yaml_text

COMPARED = ("name", "plane", "gravity", "object", "robots")
"""What a cell file says of a manifest."""

FILES = frozenset({"urdf", "file"})
"""Keys that say where a file is, which need not be alike: its hash is compared."""

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
    robots = []
    for robot in manifest.robots:
        reference = robot_reference(robot)
        file = reference.path(where, folder)
        urdf = file, parse_urdf(file, reference.content(where, folder))
        robots.append(_described_robot(where, robot, _reference(robot.urdf, file, beside), urdf))
    shape = manifest.object.shape
    described_shape = None if shape is None else _described_shape(where, shape, folder, beside)
    text = yaml_text(_described(manifest, described_shape, robots))
    description = validated(where, parse_yaml(text), CellDescription, "cell file")
    chains = ChainsRecord(**{name: getattr(manifest, name) for name in ChainsRecord.model_fields})
    _check_same(where, manifest, cell_manifest(build_cell_model(where, description, beside or folder), chains))
    return text


def _reference(given: str, file: Path, beside: Path | None) -> str:
    """How the cell file names a file: as a package's, relative to itself, or absolute."""
    if is_uri(given):
        return given
    resolved = file.resolve()
    if beside is not None and resolved.is_relative_to(beside):
        return resolved.relative_to(beside).as_posix()
    return resolved.as_posix()


def _described_shape(where: Path, shape: ShapeRecord, folder: Path, beside: Path | None) -> dict[str, Any]:
    described: dict[str, Any] = {"box": shape.box}
    if shape.cylinder is not None:
        described["cylinder"] = shape.cylinder.model_dump()
    if shape.mesh is not None:
        file = mesh_reference(shape.mesh.file).path(where, folder)
        described |= {"mesh": _reference(shape.mesh.file, file, beside), "scale": shape.mesh.scale}
    pose = _pose(shape.pose)
    return _known(described | {"pose": pose if any(pose["xyz"]) or any(pose["rpy"]) else None})


def _described(manifest: Manifest, shape: dict[str, Any] | None, robots: list[dict[str, Any]]) -> dict[str, Any]:
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
        "shape": shape,
        "variation": variation or None,
        "velocity": speeds or None,
    }
    whole = {
        "name": manifest.name,
        "gravity": manifest.gravity,
        "plane": manifest.plane,
        "inertia": "lenient" if any(remark.code == NEAREST_INERTIA for remark in manifest.remarks) else None,
        "object": _known(thing),
    }
    return _known(whole) | {"robots": robots}


def _described_robot(where: Path, robot: RobotRecord, reference: str, urdf: tuple[Path, Any]) -> dict[str, Any]:
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
            "xacro_args": robot.xacro_args or None,
            "base_link": robot.base_link,
            "tip_link": robot.tip_link,
            "base": _pose(robot.world_base),
            "grasp": _pose(robot.object_tip),
            "posture": robot.posture,
            "torque": None if robot.torque_from_urdf else upper if symmetric else {"lower": lower, "upper": upper},
            "wrench": limited or None,
            "contact_rate": None if rates == [None, None] else rates,
            "contact": [contact.given for contact in robot.contacts] or None,
            "fixed": _fixed(robot, urdf) or None,
            "motors": _motors(robot, urdf) or None,
        }
    )


def _pose(pose: PoseRecord) -> dict[str, list[float]]:
    return {"xyz": pose.position, "rpy": rpy_from_rotation(np.array(pose.rotation))}


def _fixed(robot: RobotRecord, urdf: tuple[Path, Any]) -> dict[str, float]:
    """Joints that are held by themselves; others follow them."""
    followers = {joint.name for joint in urdf[1].joints if joint.mimic is not None}
    return {name: position for name, position in robot.held.items() if name not in followers}


def _motors(robot: RobotRecord, urdf: tuple[Path, Any]) -> dict[str, Any]:
    """What is known of them; friction is left out where it is that of the URDF."""
    motors = robot.motors
    described: dict[str, Any] = {"armature": motors.armature} if any(motors.armature) else {}
    joints = {joint.name: joint for joint in urdf[1].joints}
    of_urdf = [friction(urdf[0], joints[joint.name]) for joint in robot.joints]
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
    if key.endswith("sha256"):
        what = "mesh" if key.startswith("object.") else "URDF"
        raise InputError(where, f"the {what} is another one than the cell was made from.", key=key[: -len("_sha256")])
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
        named = [name for name in ours if name not in FILES]
        pairs = [(f"{key}.{name}".lstrip("."), ours[name], theirs[name]) for name in named]
    elif isinstance(ours, list) and isinstance(theirs, list) and len(ours) == len(theirs):
        pairs = [(f"{key}[{place}]", *both) for place, both in enumerate(zip(ours, theirs, strict=True))]
    else:
        same = ours == theirs or (".rotation[" in key and abs(ours - theirs) <= SAME_ROTATION)
        return None if same else (key, ours, theirs)
    found = (_difference(one, other, inside) for inside, one, other in pairs)
    return next((different for different in found if different is not None), None)
