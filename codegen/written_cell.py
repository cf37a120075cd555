# SPDX-License-Identifier: MIT
"""The cell file of a cell as it is now: written from its manifest, read again, and compared."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from mrts_codegen.cell_file import CellDescription
from mrts_codegen.cell_model import build_cell_model
from mrts_codegen.urdf.link_inertia import NEAREST_INERTIA
from mrts_codegen.urdf_reference import mesh_reference, robot_reference

from mrts.base.arrays import without_infinity
from mrts.base.errors import InputError
from mrts.base.formats.package_uri import is_uri
from mrts.base.input_file import validated
from mrts.base.rigid_transform import RigidTransform, rpy_from_rotation
from mrts.base.yaml_parser import parse_yaml, yaml_text
from mrts.cell.record import CellManifest, CellRecord, ShapeRecord
from mrts.cell.robot import Robot

FILES = frozenset({"urdf", "file"})
"""Keys that say where a file is, which need not be alike: its hash is compared."""

SAME_ROTATION = 1e-12
"""Largest difference of an entry of a rotation that comes back from its angles: rounding, or a matrix of other make."""


def cell_file_text(manifest: CellManifest, folder: Path, beside: Path | None) -> str:
    """Text of a cell file that reads back to a cell.

    URDFs are relative to `folder`; those that lie where the file will stand, `beside`, or below are named relative to
    it.
    """
    where = Path(f"cell '{manifest.name}'")
    text = yaml_text(_described(where, manifest, folder, beside))
    description = validated(where, parse_yaml(text), CellDescription, "cell file")
    read = build_cell_model(where, description, beside or folder).record
    _check_same(where, manifest, read)
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


def _described(where: Path, manifest: CellManifest, folder: Path, beside: Path | None) -> dict[str, Any]:
    box, shape = manifest.load_box, manifest.object_shape
    xx, yy, zz, xy, xz, yz = manifest.load[4:].tolist()
    variation: dict[str, Any] = {} if box is None else {name: list(ends) for name, ends in box.ranges.items()}
    if box is not None and box.outer_hull:
        variation["hull"] = "outer"
    linear, angular = without_infinity(manifest.object_velocity_limit)
    carried = {
        "mass": float(manifest.load[0]),
        "inertia": [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]] if any((xy, xz, yz)) else [xx, yy, zz],
        "shape": None if shape is None else _described_shape(where, shape, folder, beside),
        "variation": variation or None,
        "velocity": _known({"linear": linear, "angular": angular}) or None,
    }
    return _known(
        {
            "name": manifest.name,
            "gravity": manifest.gravity.tolist(),
            "plane": manifest.plane,
            "inertia": "lenient" if any(remark.code == NEAREST_INERTIA for remark in manifest.remarks) else None,
            "object": _known(carried),
            "robots": [_described_robot(where, robot, folder, beside) for robot in manifest.robots],
        }
    )


def _described_robot(where: Path, robot: Robot, folder: Path, beside: Path | None) -> dict[str, Any]:
    source, lower, upper = robot.source, robot.torque_lower.tolist(), robot.torque_upper.tolist()
    symmetric = np.array_equal(robot.torque_lower, -robot.torque_upper)
    for contact in robot.contacts:
        if contact.given is None:
            raise InputError(
                where,
                "a cell file cannot hold a contact that was made row by row. Make it with mrts.pad_contact, "
                "rows_contact or their neighbours.",
                key=f"robot '{robot.name}': contact '{contact.name}'",
            )
    bounds = {"lower": without_infinity(robot.wrench_lower), "upper": without_infinity(robot.wrench_upper)}
    rates = without_infinity(robot.contact_rate[[0, -1]])
    return _known(
        {
            "name": robot.name,
            "urdf": _reference(source.urdf, robot_reference(source).path(where, folder), beside),
            "xacro_args": source.xacro_args or None,
            "base_link": source.base_link,
            "tip_link": source.tip_link,
            "base": _pose(robot.T_world_base),
            "grasp": _pose(robot.T_object_tip),
            "posture": robot.posture.tolist(),
            "torque": None if robot.has_urdf_torque else upper if symmetric else {"lower": lower, "upper": upper},
            "wrench": {side: values for side, values in bounds.items() if values != [None] * len(values)} or None,
            "contact_rate": None if rates == [None, None] else rates,
            "contact": [contact.given for contact in robot.contacts] or None,
            "fixed": source.fixed or None,
            "motors": _motors(robot) or None,
        }
    )


def _pose(T: RigidTransform) -> dict[str, list[float]]:
    return {"xyz": T.p.tolist(), "rpy": rpy_from_rotation(T.R)}


def _motors(robot: Robot) -> dict[str, Any]:
    motors = robot.motors
    described: dict[str, Any] = {"armature": motors.armature.tolist()} if np.any(motors.armature) else {}
    if not robot.has_urdf_friction:
        friction = {"coulomb": motors.coulomb.tolist(), "viscous": motors.viscous.tolist()}
        described["friction"] = friction if motors.has_friction else "none"
    if any(curve is not None for curve in motors.torque_speed):
        described["torque_speed"] = [None if curve is None else curve.tolist() for curve in motors.torque_speed]
    for name in ("torque_rate", "jerk", "rated"):
        values = without_infinity(getattr(motors, name))
        if any(value is not None for value in values):
            described[name] = values
    return described


def _known(values: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}


def _check_same(where: Path, ours: CellManifest, read: CellRecord) -> None:
    """Refuse what a cell file cannot hold: what it reads back to is another cell."""
    said = {*CellRecord.model_fields} - {"remarks"}
    different = _difference(ours.model_dump(include=said), read.model_dump(include=said))
    if different is None:
        return
    key, value, found = different
    if key.endswith("sha256"):
        what = "mesh" if key.startswith("object_shape.") else "URDF"
        file = key.removesuffix(".sha256") if what == "mesh" else key.removesuffix("source.sha256") + "urdf"
        raise InputError(where, f"the {what} is another one than the cell was made from.", key=file)
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
        same = ours == theirs or (".R[" in key and abs(ours - theirs) <= SAME_ROTATION)
        return None if same else (key, ours, theirs)
    found = (_difference(one, other, inside) for inside, one, other in pairs)
    return next((different for different in found if different is not None), None)
