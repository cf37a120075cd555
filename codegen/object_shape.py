# SPDX-License-Identifier: MIT
"""`object.shape` and `surroundings` of the cell file: what bodies look like, and the inertia of a uniform one."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from mrts_codegen.mesh_file import Mesh, read_mesh

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.file_reference import FileReference
from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform, multiply
from mrts.cell.cell_file import ObstacleDescription, ShapeDescription
from mrts.cell.points import point_names
from mrts.cell.record import MeshRecord, ObstacleRecord, ShapeRecord

OFF_CENTRE = 0.01
"""Share of its size by which a uniform body's centre may miss the origin of the object frame, the centre of mass: a CAD
model's rounding. Its inertia is about its own centre all the same."""

LARGE = 5.0
"""Longest size of an object that arms carry, beyond which its unit is doubted [m]."""


def build_surroundings(
    path: Path, folder: Path, given: list[ObstacleDescription], robots: Sequence[str]
) -> tuple[ObstacleRecord, ...]:
    """The bodies of the surroundings."""
    names, found = point_names(given, "obstacle"), list[ObstacleRecord]()
    if len({*names, *robots, "object"}) <= len(names) + len(robots):
        rule = "must have names of their own, none of them 'object' or a robot's."
        raise InputError(path, rule, key="surroundings", value=names)
    for at, (shape, name) in enumerate(zip(given, names, strict=True)):
        record, _ = _shape_record(path, folder, shape, f"surroundings[{at}]")
        found.append(ObstacleRecord(**dict(record), name=name))
    return tuple(found)


def _shape_record(path: Path, folder: Path, shape: ShapeDescription, key: str) -> tuple[ShapeRecord, Mesh | None]:
    mesh, of_mesh, scale = None, None, shape.scale or 1.0
    if shape.mesh is not None:
        reference = FileReference(shape.mesh, f"{key}.mesh", "mesh")
        mesh = read_mesh(reference.path(path, folder), reference.content(path, folder), scale)
        drawn = {"vertices": mesh.vertices, "triangles": mesh.triangles}
        of_mesh = MeshRecord(file=shape.mesh, scale=scale, sha256=mesh.sha256, **drawn)
    return ShapeRecord(box=shape.box, cylinder=shape.cylinder, mesh=of_mesh, pose=shape.pose.transform), mesh


def build_shape(
    path: Path, folder: Path, shape: ShapeDescription, mass: float, inertia: Array | None
) -> tuple[ShapeRecord, Array, tuple[Remark, ...]]:
    """The shape of an object, and the inertia that it gives it.

    Returns:
        The shape, the inertia, and what to know.
    """
    record, mesh = _shape_record(path, folder, shape, "object.shape")
    T = record.pose
    if inertia is None:
        inertia = multiply(multiply(T.R, _inertia(path, shape, T, mass, mesh)), T.R.T)
    return record, inertia, _remarks(path, _size(shape, mesh), mesh)


def _inertia(path: Path, shape: ShapeDescription, T: RigidTransform, mass: float, mesh: Mesh | None) -> Array:
    """Of a uniform body about its centre, axes of the shape, Shape (3, 3) [kg m²]."""
    centre = np.zeros(3)
    if shape.box is not None:
        squares = np.square(shape.box)
        inertia = np.diag(mass / 12 * (np.sum(squares) - squares))
    elif shape.cylinder is not None:
        radius, length = shape.cylinder.radius, shape.cylinder.length
        across = mass / 12 * (3 * radius**2 + length**2)
        inertia = np.diag([across, across, mass / 2 * radius**2])
    else:
        assert mesh is not None  # noqa: S101 (one kind is given)
        centre, unit = mesh.solid("Close it, or give the object's 'inertia'.")
        inertia = mass * unit
    _check_centre(path, T, centre, _size(shape, mesh))
    return np.asarray(inertia)


def _check_centre(path: Path, T: RigidTransform, centre: Array, size: float) -> None:
    off = T.R @ centre + T.p
    if np.linalg.norm(off) <= OFF_CENTRE * size:
        return
    there, fitting = (", ".join(f"{value:.6g}" for value in place) for place in (off, T.p - off))
    turned = ", …" if np.any(np.eye(3) != T.R) else ""
    raise InputError(
        path,
        f"the centre of this shape is at [{there}] of the object frame, whose origin is the centre of mass, so the "
        f"inertia does not follow. Give 'pose: {{xyz: [{fitting}]{turned}}}' in the shape to move it there (and "
        "count the grasps anew), or give the object's 'inertia'.",
        key="object.shape",
    )


def _size(shape: ShapeDescription, mesh: Mesh | None) -> float:
    if mesh is not None:
        return mesh.size
    return max(shape.box) if shape.box else max(2 * shape.cylinder.radius, shape.cylinder.length)  # type: ignore[union-attr]  # one kind is given


def _remarks(path: Path, size: float, mesh: Mesh | None) -> tuple[Remark, ...]:
    if size <= LARGE:
        return ()
    advice = "give 'scale: 0.001' if its file is in millimetres" if mesh is not None else "lengths are in m"
    return (Remark("large-shape", f"{path.name}: object.shape is {size:.4g} m long; {advice}."),)
