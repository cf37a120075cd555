# SPDX-License-Identifier: MIT
"""Arms as meshes, each with the body that carries it: the visuals of a URDF, or bars from joint to joint."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.cell.generation import urdf_of
from mrts.cell.robot import Robot
from mrts.following.bodies import posed_urdf, reading_meshes
from mrts.scene.scene import OVER_LIMIT, SHARED_BASE, Rgb, arm_colour

if TYPE_CHECKING:
    from trimesh import Trimesh


BASE_RADIUS, TIP_RADIUS = 0.036, 0.02
"""Radius of an arm of bars at its base and its tip, as a share of its length when it is straight."""

LINK, AXIS_LENGTH = 0.8, 1.25
"""Radius of a bar, and half length of the cylinder along a joint's axis, as shares of that radius."""

JOINT = (62, 70, 82)
"""Colour of the joints of such an arm."""

AROUND = 32
"""Corners of a cylinder's circle."""

SAME_PLACE = 1e-3
"""Bases of two arms that are nearer are one: the torso of one machine [m]."""

SHARP = 0.6
"""Angle between faces from which the side between them is an edge [rad]."""

Warn = Callable[[str], None]
"""Told which arm is drawn with bars, though it has a URDF, and why."""


@dataclass(frozen=True, eq=False)
class ArmMesh:
    """A part of an arm that one body carries.

    Attributes:
        body: 0 stands with the base, k is moved by the first k joints (`mrts.following.bodies.body_poses`).
        mesh: In base axes with every joint of the chain at zero [m].
        own: Its colour.
        marks: Whether it shows that its body's joint decides how fast the motion may be played.
    """

    body: int
    mesh: "Trimesh"
    own: Rgb
    marks: bool

    def colour(self, deciding: int | None = None) -> Rgb:
        """Its colour where a body of the arm decides, or none does."""
        return OVER_LIMIT if self.marks and self.body == deciding else self.own


def drawn_arms(cell: Cell, warn: Warn) -> list[list[ArmMesh]]:
    """The parts of each arm of a cell: bars where it is not known where its URDF is, or that has no meshes."""
    found = []
    for index, robot in enumerate(cell.robots):
        meshes = []
        if cell.folder is not None:
            try:
                path, base_link = urdf_of(robot, cell.folder), robot.source.base_link
                meshes = arm_meshes(path, base_link, robot.joints, robot.held)
            except InputError as error:
                warn(f"robot '{robot.name}' is drawn with simple shapes: {error}")
        colour = arm_colour(index)
        base = SHARED_BASE if shares_base(cell, robot) else colour
        parts = [ArmMesh(body, mesh, colour if body else base, marks=True) for body, mesh in meshes]
        found.append(parts or bars(robot, colour))
    return found


def shares_base(cell: Cell, robot: Robot) -> bool:
    """Whether another arm stands where this one does, on the same machine."""
    bases = [other.T_world_base.p for other in cell.robots if other is not robot]
    return any(float(np.linalg.norm(base - robot.T_world_base.p)) < SAME_PLACE for base in bases)


def name_place(cell: Cell, robot: Robot) -> Array:
    """Where an arm's name stands, Shape (3,) [m]: at its base, or at its first joint where another has that too."""
    base = robot.T_world_base
    return base.p + base.R @ robot.points[0] if shares_base(cell, robot) else base.p


def bars(robot: Robot, colour: Rgb) -> list[ArmMesh]:
    """An arm as bars from joint to joint, with a cylinder along every joint's axis."""
    from trimesh.creation import cylinder, icosphere  # noqa: PLC0415 (half a second, for what is drawn)
    from trimesh.graph import smooth_shade  # noqa: PLC0415

    points = np.concatenate([np.zeros((1, 3)), robot.points, robot.T_base_tip.p[None]])
    length = float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    radii = length * np.linspace(BASE_RADIUS, TIP_RADIUS, len(points))
    ends = [(body, icosphere(subdivisions=2, radius=radii[body])) for body in (0, len(robot.joints))]
    ends[0][1].apply_translation(points[0])
    ends[1][1].apply_translation(points[-1])
    parts = [ArmMesh(body, mesh, colour, marks=body > 0) for body, mesh in ends]

    def add(body: int, start: np.ndarray, end: np.ndarray, radius: float, own: Rgb, *, marks: bool) -> None:
        if np.linalg.norm(end - start) > radius / 2:
            mesh = cylinder(radius, segment=np.stack([start, end]), sections=AROUND)
            parts.append(ArmMesh(body, smooth_shade(mesh, angle=SHARP), own, marks))

    for body, (start, end) in enumerate(pairwise(points)):
        add(body, start, end, LINK * radii[body + 1], colour, marks=False)
    for body, (kind, axis) in enumerate(zip(robot.joint_types, robot.axes, strict=True), start=1):
        point, radius = points[body], radii[body]
        if kind == "prismatic":  # a rod that slides
            add(body, point - length * axis, point, LINK * radius, JOINT, marks=True)
        along = AXIS_LENGTH * radius * axis
        add(body, point - along, point + along, radius, JOINT, marks=True)
    return parts


def arm_meshes(
    path: Path, base_link: str | None, joints: tuple[str, ...], held: Mapping[str, float] | None = None
) -> "list[tuple[int, Trimesh]]":
    """Body and mesh, as in `ArmMesh`, of every visual of an arm from a base link, None for the URDF's root.

    Other joints than those of the chain stand where they are held, else at zero; what they could still move and no
    joint of the chain carries, such as the other arm of a torso, is left out.

    Raises:
        InputError: If the file or one of its meshes cannot be read.
    """
    from trimesh import Trimesh  # noqa: PLC0415 (half a second, for cells that have meshes to show)

    with reading_meshes(path):
        model, body, base = posed_urdf(path, base_link, joints, held or {})
        graph, found = model.scene.graph, []
        for node in graph.nodes_geometry:
            link = graph.transforms.parents[node]
            pose, name = graph.get(node, base)
            shape = model.scene.geometry[name]
            if link in body and isinstance(shape, Trimesh) and len(shape.faces):
                found.append((body[link], shape.copy().apply_transform(pose)))
    return found
