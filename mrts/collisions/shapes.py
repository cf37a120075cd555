# SPDX-License-Identifier: MIT
"""Shapes of bodies as coal takes them: links of a URDF, the object, the surroundings."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.argument_types import require_extra
from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.formats.surface_text import unpacked_surface
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.generation import urdf_of
from mrts.cell.record import ShapeRecord
from mrts.cell.robot import Robot
from mrts.collisions.bodies import mesh_file, posed_urdf, reading_meshes

FLAT = 1e-6
"""Least side of the box that stands for a mesh without volume [m]."""


@dataclass(frozen=True, eq=False)
class Shape:
    """A shape that a body carries.

    Attributes:
        name: As messages give it.
        arm: Which one it is of; the object is one more, the world another.
        body: Which of its bodies, 0 the base; of the object and of the world 0.
        geometry: Of coal.
        pose: Its frame in that of the body.
        center: Of a ball around it, in the body's frame, Shape (3,) [m].
        radius: Of that ball [m].
    """

    name: str
    arm: int
    body: int
    geometry: Any
    pose: RigidTransform
    center: Array
    radius: float


def coal_module() -> Any:
    """The library coal.

    Raises:
        InputError: If it is not installed.
    """
    require_extra("collisions", "collision", "coal")
    import coal  # noqa: PLC0415 (the extra 'collision')

    return coal


def link_shapes(robot: Robot, arm: int, folder: Path | None) -> list[Shape]:
    """Shapes of an arm's links: of each its <collision>, else its <visual>; meshes as their convex hulls.

    Its URDF is relative to a folder.
    """
    if folder is None:
        rule = "it is not known where its URDF is: read its cell file, mrts.load_cell(path)."
        raise InputError(f"robot '{robot.name}'", rule)
    path, found = urdf_of(robot, folder), list[Shape]()
    with reading_meshes(path):
        source = robot.source
        model, bodies, base = posed_urdf(path, source.base_link, robot.joints, robot.held, visuals=False)
        for link, body in bodies.items():
            of_link = model.link_map[link]
            T_base_link = model.get_transform(link, base)
            for part in of_link.collisions or of_link.visuals:
                T = T_base_link if part.origin is None else T_base_link @ part.origin
                geometry = _link_geometry(path, part.geometry)
                if geometry is not None:
                    pose = RigidTransform(T[:3, :3], T[:3, 3])
                    found.append(_shape(f"{robot.name}/{link}", arm, body, geometry, pose))
    return found


def _link_geometry(path: Path, given: Any) -> Any:
    coal = coal_module()
    if given.box is not None:
        return coal.Box(*map(float, given.box.size))
    if given.sphere is not None:
        return coal.Sphere(float(given.sphere.radius))
    if given.cylinder is not None:
        return coal.Cylinder(float(given.cylinder.radius), float(given.cylinder.length))
    if given.mesh is None:
        return None
    import trimesh  # noqa: PLC0415 (half a second, for arms that have meshes)

    mesh: Any = trimesh.load(mesh_file(path, given.mesh.filename), force="mesh", skip_materials=True)
    scale = 1.0 if given.mesh.scale is None else given.mesh.scale
    return _hull(np.asarray(mesh.vertices) * scale) if len(mesh.vertices) else None


def record_shape(name: str, arm: int, record: ShapeRecord, *, hollow: bool = False) -> Shape:
    """The shape of the object or of an obstacle; a mesh as its convex hull, or "hollow" as its triangles."""
    coal = coal_module()
    if record.box is not None:
        geometry = coal.Box(*record.box)
    elif record.cylinder is not None:
        geometry = coal.Cylinder(record.cylinder.radius, record.cylinder.length)
    else:
        assert record.mesh is not None  # noqa: S101 (the record has one of the three)
        vertices, triangles = unpacked_surface(record.mesh.vertices, record.mesh.triangles)
        geometry = _surface(vertices, triangles) if hollow else _hull(vertices)
    return _shape(name, arm, 0, geometry, record.pose)


def _shape(name: str, arm: int, body: int, geometry: Any, pose: RigidTransform) -> Shape:
    geometry.computeLocalAABB()
    return Shape(name, arm, body, geometry, pose, pose.R @ geometry.aabb_center + pose.p, float(geometry.aabb_radius))


def _hull(points: Array) -> Any:
    from scipy.spatial import QhullError  # noqa: PLC0415 (only for meshes)
    from trimesh.convex import convex_hull  # noqa: PLC0415

    coal = coal_module()
    try:
        hull = convex_hull(points)
    except QhullError:  # flat: the box around it
        low, high = np.min(points, axis=0), np.max(points, axis=0)
        corners = np.stack(np.meshgrid(*np.stack([low, np.maximum(high, low + FLAT)], axis=1)), axis=-1)
        hull = convex_hull(corners.reshape(-1, 3))
    return coal.Convex(*_coal_lists(hull.vertices, hull.faces))


def _surface(vertices: Array, triangles: NDArray[np.int64]) -> Any:
    model = coal_module().BVHModelOBBRSS()
    model.beginModel(len(triangles), len(vertices))
    model.addSubModel(*_coal_lists(vertices, triangles))
    model.endModel()
    return model


def _coal_lists(vertices: Array, triangles: NDArray[Any]) -> tuple[Any, Any]:
    coal = coal_module()
    points, corners = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for vertex in np.asarray(vertices, dtype=np.float64):
        points.append(vertex)
    for triangle in triangles.tolist():
        corners.append(coal.Triangle(*triangle))
    return points, corners
