# SPDX-License-Identifier: MIT
"""A cell on a floor, sample by sample: arms, object, its path, and the forces on it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.drawing.bodies.arm_meshes import arm_meshes
from mrts.drawing.bodies.cell_shapes import body_poses, contact_forces, joint_points, shares_base
from mrts.drawing.bodies.cell_view import look_at_cell
from mrts.drawing.bodies.held_body import held_body
from mrts.drawing.colours import SHARED_BASE
from mrts.drawing.round_numbers import round_down
from mrts.film.camera import framing_camera
from mrts.film.raster import Picture, drawn, shaded_floor
from mrts.film.solids import Colour, Solid, arrow, ball, faceted, tube
from mrts.scaling.scaled_trajectory import ScaledTrajectory

ARMS: tuple[Colour, ...] = ((86, 140, 196), (222, 128, 62), (96, 168, 128), (190, 130, 170))
"""Of one arm after the other, and again from the first."""

JOINT, OBJECT, FORCE, PATH = (62, 70, 82), (232, 190, 96), (196, 52, 30), (90, 100, 112)

BASE_THICKNESS, TIP_THICKNESS = 0.036, 0.02
"""Radius of an arm without meshes at its base and its tip, as a share of its length when it is straight."""

ARROW = 0.3
"""Longest force, as a share of the cell's size."""

ARROW_THICKNESS, PATH_THICKNESS = 0.008, 0.004
"""Likewise, of radii."""

SHORTEST = 0.01
"""Forces below this share of the cell's size are not drawn."""

PATH_POINTS = 48
"""Of the line along which the object moves."""

TILES = 5
"""Of the floor, in the cell's size; rounded to 1, 2 or 5 times a power of ten."""

FADING = 2.2
"""Distance from the cell's middle at which the floor's lines have faded, in its size."""

LINE = 0.012
"""Width of the floor's lines, as a share of a tile."""

BACKDROP = np.array([[236, 240, 245], [252, 253, 254]], dtype=np.float32)
"""Colours of the picture's upper and lower edge."""

FLOOR, GROOVE = np.array([[238, 240, 243], [206, 211, 218]], dtype=np.float32)
"""Its colour, and that of its lines."""

Warn = Callable[[str], None]


def silent(_text: str) -> None:
    """Takes a warning, and does nothing."""


@dataclass(frozen=True, eq=False)
class Take:
    """A motion that is played.

    Attributes:
        title: What it is, for people.
        trajectory: Motion, speed, torques and wrenches.
        urdfs: URDF and base link by robot, for meshes; robots that are not named are drawn with simple shapes.
    """

    title: str
    trajectory: ScaledTrajectory
    urdfs: Mapping[str, tuple[Path, str | None]] = field(default_factory=dict)

    @property
    def cell(self) -> Cell:
        """Whose motion it is."""
        return self.trajectory.cell

    def at(self, time: float) -> tuple[Array, Array, Array, Array]:
        """Joints, Shape (m,), the object's position and rotation, and wrenches between the two nearest samples.

        Args:
            time: At the played speed; before the start and after the end it stands [s].
        """
        done, carried = self.trajectory, self.trajectory.motion.object
        place = float(np.interp(time, done.time, np.arange(len(done.time))))
        first = min(int(place), len(done.time) - 2) if len(done.time) > 1 else 0
        last, share = min(first + 1, len(done.time) - 1), place - first

        def between(values: Array) -> Array:
            return np.asarray((1 - share) * values[first] + share * values[last])

        nearest = last if share > 0.5 else first  # noqa: PLR2004 (the nearer of two)
        return between(done.q), between(carried.position), carried.rotation[nearest], between(done.wrench)


class Stage:
    """Pictures of cells that play takes; all are seen from one place, and their forces drawn to one scale.

    Args:
        takes: At least one; the first says what is upward, and where the floor is.
        size: Width and height of pictures [pixels].
        backward: From the cell to the camera; None looks from the front.
        warn: Told which arm is drawn without its meshes, and why.
    """

    def __init__(
        self,
        takes: Sequence[Take],
        size: tuple[int, int],
        backward: Array | None = None,
        warn: Warn = silent,
    ) -> None:
        first = takes[0]
        motion = first.trajectory.motion
        view = look_at_cell(first.cell, motion.q, motion.object.position)
        self._up, self._ground = view.up, view.floor
        self._middle = view.target
        self._size = view.size
        backward = view.direction if backward is None else backward
        self.camera = framing_camera(np.concatenate([_reached(take) for take in takes]), backward, view.up, size)
        right, up, forward = self.camera.axes
        lamp = 0.9 * view.up - 0.45 * forward - 0.35 * right + 0.2 * up
        self._lamp = lamp / np.linalg.norm(lamp)
        strongest = max(_strongest(take) for take in takes)
        self._metres_per_newton = ARROW * view.size / strongest if strongest > 0 else 0.0
        self._arms = {
            take: [
                _Arm(
                    robot,
                    ARMS[place % len(ARMS)],
                    take.urdfs.get(robot.name),
                    warn,
                    shared_base=shares_base(take.cell, robot),
                )
                for place, robot in enumerate(take.cell.robots)
            ]
            for take in takes
        }

        self._held = {
            take: faceted(body.vertices, body.faces, OBJECT)
            for take, body in ((take, held_body(take.cell)) for take in takes)
        }

    def picture(self, take: Take, time: float) -> Picture:
        """A picture of a moment.

        Args:
            take: One of the takes.
            time: At its played speed [s].
        """
        cell, (q, position, rotation, wrench) = take.cell, take.at(time)
        solids = [self._held[take].moved(rotation, position), *_path(take, PATH_THICKNESS * self._size)]
        for arm, joints in zip(self._arms[take], cell.joint_slices.values(), strict=True):
            solids += arm.solids(q[joints])
        forces = []
        for robot, part in zip(cell.robots, cell.wrench_slices.values(), strict=True):
            here = contact_forces(cell, robot, position[None], rotation[None], wrench[None, part])
            step = self._metres_per_newton * here.force[0]
            if np.linalg.norm(step) > SHORTEST * self._size:
                forces += arrow(here.point[0], step, ARROW_THICKNESS * self._size, FORCE)
        floor = shaded_floor(self._floor, self.camera, solids, self._lamp, (self._up, self._ground))
        scene = drawn(floor, self.camera, solids, self._lamp)
        return drawn(scene, self.camera, forces, self._lamp) if forces else scene  # over all else: most begin inside

    @cached_property
    def _floor(self) -> Picture:
        """The floor with its tiles, which fade away from the cell, before the backdrop."""
        width, height = self.camera.size
        shade = np.linspace(0, 1, height, dtype=np.float32)[:, None, None]
        whole = np.broadcast_to(BACKDROP[0] + shade * (BACKDROP[1] - BACKDROP[0]), (height, width, 3)).copy()
        picture = whole.reshape(-1, 3)
        rays = self.camera.rays(np.arange(width * height))
        falling = rays @ self._up
        with np.errstate(divide="ignore"):
            away = ((self._ground - self.camera.position) @ self._up) / falling
        below = (away > 0) & np.isfinite(away)
        if not np.any(below):
            return whole
        ground = self.camera.position + rays[below] * away[below][:, None] - self._middle
        level = np.cross(self._up, np.eye(3)[np.argmin(np.abs(self._up))])
        level /= np.linalg.norm(level)
        tile = round_down(self._size / TILES)
        places = ground @ np.stack([level, np.cross(self._up, level)]).T
        near = np.clip(1 - np.linalg.norm(places, axis=1) / (FADING * self._size), 0, 1)[:, None].astype(np.float32)
        beside = np.abs(places / tile - np.round(places / tile)) * tile  # from the nearest line [m]
        pixel = np.abs(away[below] / self.camera.focal)[:, None]  # its size there, along the picture [m]
        steep = np.abs(falling[below] / np.linalg.norm(rays[below], axis=1))[:, None]
        wide = LINE * tile
        cover = np.clip((wide + pixel / steep - beside) / (pixel / steep), 0, 1) * np.minimum(wide / pixel, 1)
        line = (np.max(cover, axis=1)[:, None] * near).astype(np.float32)
        ground_colour = FLOOR * near + picture[below] * (1 - near)
        picture[below] = ground_colour * (1 - line) + GROOVE * line
        return whole


class _Arm:
    """An arm with the meshes of its URDF, or with bars from joint to joint."""

    def __init__(
        self,
        robot: Robot,
        colour: Colour,
        urdf: tuple[Path, str | None] | None,
        warn: Warn,
        *,
        shared_base: bool,
    ) -> None:
        self._robot, self._colour = robot, colour
        try:
            meshes = [] if urdf is None else arm_meshes(*urdf, robot.joints, robot.held)
        except InputError as error:
            warn(f"robot '{robot.name}' is drawn with simple shapes: {error}")
            meshes = []
        self._meshes = [
            (body, _solid(mesh, SHARED_BASE if shared_base and not body else colour)) for body, mesh in meshes
        ]
        straight = joint_points(robot, np.zeros((1, len(robot.joints))))[0]
        self._length = float(np.sum(np.linalg.norm(np.diff(straight, axis=0), axis=1)))

    def solids(self, q: Array) -> list[Solid]:
        """At joint positions, Shape (n_i,) [rad or m]."""
        rotations, positions = (of_bodies[0] for of_bodies in body_poses(self._robot, q[None]))
        if self._meshes:
            return [solid.moved(rotations[body], positions[body]) for body, solid in self._meshes]
        points = joint_points(self._robot, q[None])[0]
        share = np.linspace(0, 1, len(points))
        radii = self._length * (BASE_THICKNESS + share * (TIP_THICKNESS - BASE_THICKNESS))
        solids = [ball(points[-1], 1.1 * radii[-1], JOINT)]
        for start, end, thick, thin in zip(points, points[1:], radii, radii[1:], strict=False):
            if np.linalg.norm(end - start) > thin / 2:
                solids.append(tube(start, end, (0.8 * thick, 0.8 * thin), self._colour))
            solids.append(ball(start, thick, self._colour))
        for R, axis, point, radius in zip(rotations[1:], self._robot.axes, points[1:], radii[1:], strict=False):
            along = 1.25 * radius * (R @ axis)
            solids.append(tube(point - along, point + along, (0.85 * radius, 0.85 * radius), JOINT))
        return solids


def _solid(mesh: Any, colour: Colour) -> Solid:
    return Solid(np.asarray(mesh.vertices), np.asarray(mesh.vertex_normals), np.asarray(mesh.faces), colour)


def _path(take: Take, radius: float) -> list[Solid]:
    """The line along which the object moves."""
    whole = take.trajectory.motion.object.position
    chosen = np.unique(np.linspace(0, len(whole) - 1, PATH_POINTS).astype(int))
    points = whole[chosen]
    return [
        tube(start, end, (radius, radius), PATH, casts=False)
        for start, end in pairwise(points)
        if np.linalg.norm(end - start) > 0
    ]


def _reached(take: Take) -> Array:
    """Points that hold all that moves: joints of arms, and corners of a ball about the object, Shape (P, 3) [m]."""
    cell, motion = take.cell, take.trajectory.motion
    slices = cell.joint_slices
    lines = [joint_points(robot, motion.q[:, slices[robot.name]]).reshape(-1, 3) for robot in cell.robots]
    reach = float(np.max(np.linalg.norm(held_body(cell).vertices, axis=1)))
    around = [motion.object.position + sign * reach * axis for sign in (-1, 1) for axis in np.eye(3)]
    return np.concatenate([*lines, *around])


def _strongest(take: Take) -> float:
    """The largest force of one arm on the object [N]."""
    cell, done = take.cell, take.trajectory
    forces = np.array([unit == "N" for unit in cell.wrench_units])
    sizes = [np.linalg.norm(done.wrench[:, part][:, forces], axis=1) for part in cell.wrench_slices.values()]
    return float(np.max(sizes, initial=0.0))
