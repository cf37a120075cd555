# SPDX-License-Identifier: MIT
"""`object.shape` and `surroundings` of the cell file: what bodies look like, and the inertia of a uniform one."""

import hashlib
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.file_reference import FileReference
from mrts.base.formats.surface_text import MOST_DRAWN, coarser_surface, packed_surface
from mrts.base.input_file import LARGEST_NUMBER
from mrts.base.remark import Remark
from mrts.base.rigid_transform import RigidTransform, multiply
from mrts.cell.points import point_names
from mrts.cell.record import BodyShape, MeshSurface, Obstacle

FORMATS = ("stl", "obj", "ply", "off")
"""Endings of mesh files; those whose files may name others (dae, gltf) are left out: a mesh is one file."""

NO_VOLUME = 1e-9
"""Least volume of a body as a share of the cube around it: less is a sheet, or rounding."""

OFF_CENTRE = 0.01
"""Share of its size by which a uniform body's centre may miss the origin of the object frame, the centre of mass: a CAD
model's rounding. Its inertia is about its own centre all the same."""

LARGE = 5.0
"""Longest size of an object that arms carry, beyond which its unit is doubted [m]."""


def build_surroundings(
    path: Path, folder: Path, given: list[Obstacle], robots: Sequence[str]
) -> tuple[tuple[Obstacle, ...], dict[str, MeshSurface]]:
    """The bodies of the surroundings, and what is drawn of their meshes, by file."""
    names, surfaces = point_names(given, "obstacle"), dict[str, MeshSurface]()
    if len({*names, *robots, "object"}) <= len(names) + len(robots):
        rule = "must have names of their own, none of them 'object' or a robot's."
        raise InputError(path, rule, key="surroundings", value=names)
    for at, shape in enumerate(given):
        surfaces |= _surfaces(path, folder, shape, f"surroundings[{at}]")[0]
    return tuple(one.model_copy(update={"name": name}) for one, name in zip(given, names, strict=True)), surfaces


def _surfaces(path: Path, folder: Path, shape: BodyShape, key: str) -> tuple[dict[str, MeshSurface], Any]:
    """What is drawn of the mesh of a shape, by its file, and its surface as trimesh has it [m]; None of others."""
    if shape.mesh is None:
        return {}, None
    reference, scale = FileReference(shape.mesh, f"{key}.mesh", "mesh"), shape.scale or 1.0
    content = reference.content(path, folder)
    surface = _read_mesh(reference.path(path, folder), content, scale)
    vertices, triangles = packed_surface(*coarser_surface(surface.vertices / scale, surface.faces, MOST_DRAWN))
    sha256 = hashlib.sha256(content).hexdigest()
    return {shape.mesh: MeshSurface(sha256=sha256, vertices=vertices, triangles=triangles)}, surface


def build_shape(
    path: Path, folder: Path, shape: BodyShape, mass: float, inertia: Array | None
) -> tuple[dict[str, MeshSurface], Array, tuple[Remark, ...]]:
    """What is drawn of an object's mesh, the inertia that its shape gives it, and what to know."""
    drawn, surface = _surfaces(path, folder, shape, "object.shape")
    T, size = shape.pose.transform, _size(shape, surface)
    if inertia is None:
        centre, own = _uniform(path, folder, shape, mass, surface)
        _check_centre(path, T, centre, size)
        inertia = multiply(multiply(T.R, own), T.R.T)
    advice = "give 'scale: 0.001' if its file is in millimetres" if shape.mesh is not None else "lengths are in m"
    large = Remark("large-shape", f"{path.name}: object.shape is {size:.4g} m long; {advice}.")
    return drawn, inertia, (large,) if size > LARGE else ()


def _uniform(path: Path, folder: Path, shape: BodyShape, mass: float, surface: Any) -> tuple[Array, Array]:
    """Centre of a uniform body, Shape (3,) [m], and its inertia about it, Shape (3, 3) [kg m²], axes of the shape."""
    if shape.box is not None:
        squares = np.square(shape.box)
        return np.zeros(3), np.diag(mass / 12 * (np.sum(squares) - squares))
    if shape.cylinder is not None:
        radius, length = shape.cylinder.radius, shape.cylinder.length
        across = mass / 12 * (3 * radius**2 + length**2)
        return np.zeros(3), np.diag([across, across, mass / 2 * radius**2])
    file = FileReference(str(shape.mesh)).path(path, folder)
    problem = ""
    with np.errstate(invalid="ignore", divide="ignore"):  # by a volume of 0
        moments = surface.mass_properties
    if not surface.is_watertight:
        problem = "this mesh is not closed (watertight), so it encloses no volume."
    elif not surface.is_winding_consistent:
        problem = "the triangles of this mesh do not agree on which side is out, so its volume is not known."
    elif abs(moments.volume) <= NO_VOLUME * _size(shape, surface) ** 3:
        problem = "this mesh encloses no volume."
    if problem:
        raise InputError(file, f"{problem} Close it, or give the object's 'inertia'.")
    unit = np.array(moments.inertia) / float(moments.volume)  # inside out: both change sign
    return np.array(moments.center_mass), mass * unit


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


def _size(shape: BodyShape, surface: Any) -> float:
    """Its longest side [m]."""
    if surface is not None:
        return float(np.max(np.ptp(surface.vertices, axis=0)))
    return max(shape.box) if shape.box else max(2 * shape.cylinder.radius, shape.cylinder.length)  # type: ignore[union-attr]  # one kind is given


def _read_mesh(path: Path, content: bytes, scale: float) -> Any:
    """The surface of a mesh file as trimesh has it [m]."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise InputError(path, f"a mesh of an object is a file of {', '.join(FORMATS)}. Export it as one of them.")
    import trimesh  # noqa: PLC0415 (half a second, for cells that have a mesh)

    try:
        # from memory, without a resolver: an OBJ's materials, or whatever a file names, is not opened
        given = trimesh.load_mesh(io.BytesIO(content), file_type=kind)
        surface: Any = trimesh.Trimesh(given.vertices * scale, given.faces)
    except Exception as error:  # noqa: BLE001 (the readers of the formats raise what they like)
        raise InputError(path, f"cannot be read as a mesh ({type(error).__name__}: {error}).") from None
    if not len(surface.faces) or not np.all(np.abs(surface.vertices) <= LARGEST_NUMBER):
        raise InputError(path, "this mesh must have triangles, and vertices that are finite numbers.")
    if np.max(np.ptp(surface.vertices, axis=0)) <= 0:
        raise InputError(path, "all vertices of this mesh are one point.")
    return surface
