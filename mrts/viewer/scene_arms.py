# SPDX-License-Identifier: MIT
"""Arms in a viser scene: with the meshes of their URDF, or as cylinders and balls; needs the extra 'view'."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import viser

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.rigid_transform import quaternions_from_rotations
from mrts.cell.robot import Robot
from mrts.drawing.bodies.arm_meshes import arm_meshes
from mrts.drawing.bodies.cell_shapes import body_poses, joint_points

Rgb = tuple[int, int, int]
"""0 to 255."""

JOINT_SHADE = 0.6
"""Of a joint's ball, as a share of the arm's colour."""

Urdfs = Mapping[str, tuple[Path, str | None]]
"""URDF and base link of arms, by name."""


class DrawnArm(Protocol):
    """An arm in the scene."""

    def update(self, robot: Robot, q: Array) -> None:
        """Move to joint positions, Shape (1, n_i) [rad or m], of the robot where it stands now."""


def drawn_arm(
    scene: viser.SceneApi, robot: Robot, urdfs: Urdfs, colour: Rgb, radius: float, warn: Callable[[str], None]
) -> DrawnArm:
    """Draw an arm.

    Args:
        scene: Where.
        robot: The arm.
        urdfs: As far as there are any; without one it is drawn from its kinematics.
        colour: Its own.
        radius: Of its links without meshes [m].
        warn: Told why it is drawn without its meshes.
    """
    if robot.name in urdfs:
        path, base_link = urdfs[robot.name]
        try:
            meshes = arm_meshes(path, base_link, robot.joints, robot.held)
        except InputError as error:
            warn(f"robot '{robot.name}' is drawn with simple shapes: {error}")
        else:
            if meshes:
                return _MeshArm(scene, robot, meshes, colour)
    return _SimpleArm(scene, robot, radius, colour)


class _MeshArm:
    """An arm with the meshes of its URDF: a frame for each body, which carries its meshes."""

    def __init__(self, scene: viser.SceneApi, robot: Robot, meshes: list[tuple[int, Any]], colour: Rgb) -> None:
        self._frames = [
            scene.add_frame(f"/arms/{robot.name}/body{index}", show_axes=False)
            for index in range(len(robot.joints) + 1)
        ]
        for number, (body, mesh) in enumerate(meshes):
            name = f"/arms/{robot.name}/body{body}/mesh{number}"
            scene.add_mesh_simple(name, mesh.vertices, mesh.faces, color=colour, flat_shading=False)

    def update(self, robot: Robot, q: Array) -> None:
        """Move to joint positions, Shape (1, n_i) [rad or m]."""
        rotations, positions = body_poses(robot, q)
        for frame, R, p in zip(self._frames, rotations[0], positions[0], strict=True):
            frame.position, frame.wxyz = p, wxyz(R)


class _SimpleArm:
    """An arm as cylinders from joint to joint, with a ball at each."""

    def __init__(self, scene: viser.SceneApi, robot: Robot, radius: float, colour: Rgb) -> None:
        red, green, blue = (round(JOINT_SHADE * part) for part in colour)
        self._balls = [
            scene.add_icosphere(f"/arms/{robot.name}/point{index}", 1.4 * radius, (red, green, blue))
            for index in range(len(robot.joints) + 2)
        ]
        self._links = [
            scene.add_cylinder(f"/arms/{robot.name}/link{index}", radius, 1.0, colour)
            for index in range(len(robot.joints) + 1)
        ]

    def update(self, robot: Robot, q: Array) -> None:
        """Move to joint positions, Shape (1, n_i) [rad or m]."""
        points = joint_points(robot, q)[0]
        for ball, point in zip(self._balls, points, strict=True):
            ball.position = point
        for link, start, end in zip(self._links, points, points[1:], strict=False):
            length = float(np.linalg.norm(end - start))
            link.visible = length > 0
            if length > 0:
                link.position, link.wxyz = (start + end) / 2, wxyz(z_along((end - start) / length))
                link.scale = (1.0, 1.0, length)


def z_along(direction: Array) -> Array:
    """A rotation that takes the z axis to a unit vector, Shape (3, 3)."""
    x = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(direction, x), direction], axis=1)


def wxyz(R: Array) -> Array:
    """A rotation as viser's quaternion, Shape (4,)."""
    return np.roll(quaternions_from_rotations(R), 1)
