# SPDX-License-Identifier: MIT
"""Bodies of a cell file: what they look like, the inertia of a uniform one, whether hands press into the object."""

import io
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Mistakes, Remark
from mrts.base.formats.surface_text import MOST_DRAWN, coarser_surface, packed_surface
from mrts.base.input_file import LARGEST_NUMBER, FileReference
from mrts.base.rigid_transform import RigidTransform, multiply
from mrts.cell.cell_file import ObjectDescription, RobotDescription, inertia_problem
from mrts.cell.record import BodyShape, MeshSurface, mesh_surface

FORMATS = ("stl", "obj", "ply", "off")
"""Endings of mesh files; those whose files may name others (dae, gltf) are left out: a mesh is one file."""

NO_VOLUME = 1e-9
"""Least volume of a body as a share of the cube around it: less is a sheet, or rounding."""

OFF_CENTRE = 0.01
"""Share of its size by which a uniform body's centre may miss the origin of the object frame, the centre of mass: a CAD
model's rounding. Its inertia is about its own centre all the same."""

LARGE = 5.0
"""Longest size of an object that arms carry, beyond which its unit is doubted [m]."""

NEAR = 0.05
"""Share of the object's longest side within which a contact is at a face: palms have a thickness, shapes are rough."""

NEAREST = 2.0
"""So many times the distance of the nearest face another one counts as near as well."""

ON_FACE = 1e-3
"""Share of the longest side within which two faces are equally near, as at an edge."""

OUTWARD = 0.5
"""Cosine with a face's outward normal from which a direction points out of it, and below its negative into it: 60°."""


Faces = tuple[Array, Array, float]
"""Faces of a shape as seen from a point, in its axes: distances, Shape (f,) [m], outward normals, Shape (f, 3), and the
longest side of the shape [m]."""


def mesh_surfaces(path: Path, folder: Path, shape: BodyShape, key: str) -> tuple[dict[str, MeshSurface], Any]:
    """What is drawn of the mesh of a shape, by its file, and its surface as trimesh has it [m]; None of others."""
    if shape.mesh is None:
        return {}, None
    reference, scale = FileReference(shape.mesh, f"{key}.mesh", "mesh"), shape.scale or 1.0
    surface = _read_mesh(reference.path(path, folder), reference.content(path, folder), scale)
    vertices, triangles = packed_surface(*coarser_surface(surface.vertices / scale, surface.faces, MOST_DRAWN))
    sha256 = reference.sha256(path, folder)
    return {shape.mesh: MeshSurface(sha256=sha256, vertices=vertices, triangles=triangles)}, surface


def build_object(
    path: Path, folder: Path, carried: ObjectDescription
) -> tuple[dict[str, MeshSurface], Array, tuple[Remark, ...]]:
    """What is drawn of an object's mesh, its inertia, given or of a uniform body of its shape, and what to know."""
    shape, inertia = carried.shape, carried.inertia_matrix()
    if shape is None:
        assert inertia is not None  # noqa: S101 (an object has one or the other)
        return {}, inertia, ()
    drawn, surface = mesh_surfaces(path, folder, shape, "object.shape")
    T, size = shape.pose.transform, _size(shape, surface)
    if inertia is None:
        centre, own = _uniform(path, folder, shape, carried.mass, surface)
        _check_centre(path, T, centre, size)
        inertia = multiply(multiply(T.R, own), T.R.T)
        if problem := inertia_problem(inertia):
            raise InputError(path, f"the inertia of a uniform body of this shape {problem}", key="object.shape")
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


def check_contact_normals(
    path: Path, robots: Sequence[RobotDescription], shape: BodyShape | None, surfaces: Mapping[str, MeshSurface]
) -> list[Remark]:
    """Check that pads and suction cups press into the object, unless they say `pull: true`.

    Its shape tells, or its centre of mass hints. What the two pads of a gripper admit is the same both ways.

    Returns:
        Normals that seem to point the wrong way, where no face tells.
    """
    mistakes, remarks = Mistakes(), []
    for index, robot in enumerate(robots):
        T = robot.grasp.transform
        for place, described in enumerate(robot.contact):
            ((kind, hand),) = described.items()
            if "normal" not in hand or hand.get("pull"):
                continue
            key = f"robots[{index}] ({robot.name}).contact[{place}].{kind}.normal"
            given = np.asarray(hand["normal"])
            direction = T.R @ (given / np.linalg.norm(given))
            outward = [] if shape is None else list(_faces_at(shape, surfaces, T.p))
            slopes = [float(direction @ normal) for normal in outward]
            if slopes and max(slopes) >= OUTWARD and min(slopes) > -OUTWARD:
                face = outward[int(np.argmax(slopes))]
                into = ", ".join(f"{value:.3g}" for value in np.round(-T.R.T @ face, 3) + 0.0)
                rule = (
                    "points out of the object: it must point from the hand into it, which at this face of its shape is "
                    f"[{into}] in tip axes. Turn it round, or give 'pull: true' beside it if this hand presses "
                    "outward, as from inside a hollow."
                )
                mistakes.add(InputError(path, rule, key=key, value=hand["normal"]))
            if not outward and direction @ T.p > OUTWARD * np.linalg.norm(T.p):
                text = (
                    f"{path.name}: {key} = {hand['normal']} points away from the object's centre of mass, but should "
                    "point from the hand into the object; 'pull: true' beside it says that it is meant."
                )
                remarks.append(Remark("contact-normal", text))
    mistakes.raise_noted()
    return remarks


def _faces_at(shape: BodyShape, surfaces: Mapping[str, MeshSurface], point: Array) -> Iterator[Array]:
    """Outward normals, object axes, of the faces that a point of the object frame is at."""
    T = shape.pose.transform
    local = T.R.T @ (point - T.p)
    faces = _mesh_faces(mesh_surface(shape, surfaces), local) if shape.mesh is not None else _plain_faces(shape, local)
    if faces is None:
        return
    distance, outward, size = faces
    if np.min(distance) <= NEAR * size:
        yield from outward[distance <= NEAREST * np.min(distance) + ON_FACE * size] @ T.R.T


def _plain_faces(shape: BodyShape, point: Array) -> Faces:
    """Of a box or a cylinder; of a cylinder's round face its nearest and its farthest side."""
    if shape.box is not None:
        half = np.array(shape.box) / 2
        outward = np.concatenate([np.eye(3), -np.eye(3)])
        nearest = np.where(outward != 0, outward * half, np.clip(point, -half, half))
    else:
        assert shape.cylinder is not None  # noqa: S101 (one kind is given)
        radius, length = shape.cylinder.radius, shape.cylinder.length
        half = np.array([radius, radius, length / 2])
        off = float(np.hypot(point[0], point[1]))
        side = np.array([point[0] / off, point[1] / off, 0.0]) if off > 0 else np.array([1.0, 0.0, 0.0])
        along, up = np.array([0.0, 0.0, np.clip(point[2], -half[2], half[2])]), np.array([0.0, 0.0, 1.0])
        outward = np.array([side, -side, up, -up])
        flat = min(off, radius) * side
        nearest = np.array([along + radius * side, along - radius * side, flat + half[2] * up, flat - half[2] * up])
    return np.linalg.norm(point - nearest, axis=1), outward, float(2 * np.max(half))


def _mesh_faces(drawn: tuple[Array, NDArray[np.int64]], point: Array) -> Faces | None:
    """Of the mesh as it is drawn; None where it is not closed, so that nothing says which side is out."""
    import trimesh  # noqa: PLC0415 (half a second, for cells that have a mesh)

    surface: Any = trimesh.Trimesh(*drawn)
    if not surface.is_watertight or not surface.is_winding_consistent or surface.volume == 0:
        return None
    corners = np.asarray(surface.triangles)
    tiled = np.tile(point, (len(corners), 1))
    nearest = trimesh.triangles.closest_point(corners, tiled)  # type: ignore[no-untyped-call]  # trimesh has no types
    outward = np.asarray(surface.face_normals) * np.sign(surface.volume)
    return np.linalg.norm(point - nearest, axis=1), outward, float(np.max(surface.extents))
