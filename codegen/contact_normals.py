# SPDX-License-Identifier: MIT
"""Whether the normals of pads and suction cups point into the object: its shape tells, or its centre of mass hints.

A gripper's axis has no sign: what its two pads admit is the same both ways.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, Mistakes
from mrts.base.remark import Remark
from mrts.cell.cell_file import RobotDescription
from mrts.cell.record import BodyShape, MeshSurface, mesh_surface

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


def check_contact_normals(
    path: Path, robots: Sequence[RobotDescription], shape: BodyShape | None, surfaces: Mapping[str, MeshSurface]
) -> list[Remark]:
    """Check that pads and suction cups press into the object, unless they say `pull: true`.

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
            with mistakes.noted():
                if slopes and max(slopes) >= OUTWARD and min(slopes) > -OUTWARD:
                    face = outward[int(np.argmax(slopes))]
                    into = ", ".join(f"{value:.3g}" for value in np.round(-T.R.T @ face, 3) + 0.0)
                    rule = (
                        "points out of the object: it must point from the hand into it, which at this face of its "
                        f"shape is [{into}] in tip axes. Turn it round, or give 'pull: true' beside it if this hand "
                        "presses outward, as from inside a hollow."
                    )
                    raise InputError(path, rule, key=key, value=hand["normal"])
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
