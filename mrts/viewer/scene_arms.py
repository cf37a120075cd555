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
from mrts.scene.arm_meshes import arm_meshes
from mrts.scene.cell_shapes import points_on_bodies
from mrts.scene.scene import SHARED_BASE, Rgb

JOINT_SHADE = 0.6
"""Of a joint's ball, as a share of the arm's colour."""

UNTURNED = (1.0, 0.0, 0.0, 0.0)
"""No rotation, as viser's quaternion."""

SHORTEST_LINK = 1e-3
"""Length that a link between joints at one point is drawn with [m], inside their balls: a page cannot shade none."""

Urdfs = Mapping[str, tuple[Path, str | None]]
"""URDF and base link of arms, by name."""


class DrawnArm(Protocol):
    """An arm in the scene."""

    def update(self, robot: Robot, R: Array, p: Array) -> None:
        """Move the bodies.

        Args:
            robot: The arm.
            R: As of `body_poses`, at one moment, Shape (n_i + 1, 3, 3).
            p: Likewise, Shape (n_i + 1, 3) [m].
        """


def drawn_arm(
    scene: viser.SceneApi,
    robot: Robot,
    urdfs: Urdfs,
    colour: Rgb,
    radius: float,
    warn: Callable[[str], None],
    *,
    shared_base: bool = False,
) -> DrawnArm:
    """Draw an arm.

    Args:
        scene: Where.
        robot: The arm.
        urdfs: As far as there are any; without one it is drawn from its kinematics.
        colour: Its own.
        radius: Of its links without meshes [m].
        warn: Told why it is drawn without its meshes.
        shared_base: Whether its base is another arm's too, and has the colour of neither.
    """
    if robot.name in urdfs:
        path, base_link = urdfs[robot.name]
        try:
            meshes = arm_meshes(path, base_link, robot.joints, robot.held)
        except InputError as error:
            warn(f"robot '{robot.name}' is drawn with simple shapes: {error}")
        else:
            if meshes:
                return _MeshArm(scene, robot, meshes, colour, SHARED_BASE if shared_base else colour)
    return _SimpleArm(scene, robot, radius, colour)


class _MeshArm:
    """An arm with the meshes of its URDF: a frame for each body, which carries its meshes."""

    def __init__(
        self, scene: viser.SceneApi, robot: Robot, meshes: list[tuple[int, Any]], colour: Rgb, base: Rgb
    ) -> None:
        self._frames = [
            scene.add_frame(f"/arms/{robot.name}/body{index}", show_axes=False)
            for index in range(len(robot.joints) + 1)
        ]
        for number, (body, mesh) in enumerate(meshes):
            name = f"/arms/{robot.name}/body{body}/mesh{number}"
            scene.add_mesh_simple(name, mesh.vertices, mesh.faces, color=colour if body else base, flat_shading=False)

    def update(self, robot: Robot, R: Array, p: Array) -> None:  # noqa: ARG002 (its meshes know where they are)
        """Move the bodies."""
        for frame, at, turn in zip(self._frames, p, wxyz(R), strict=True):
            frame.position, frame.wxyz = at, turn


class _SimpleArm:
    """An arm as cylinders from joint to joint, with a ball at each; two batches, so that a frame is a few messages."""

    def __init__(self, scene: viser.SceneApi, robot: Robot, radius: float, colour: Rgb) -> None:
        from trimesh.creation import cylinder, icosphere  # noqa: PLC0415 (half a second, where there are no meshes)

        red, green, blue = (round(JOINT_SHADE * part) for part in colour)
        ball, link = icosphere(subdivisions=2, radius=1.4 * radius), cylinder(radius, 1.0, sections=24)
        name, count = f"/arms/{robot.name}", len(robot.joints) + 2
        self._scales = np.ones((count - 1, 3), dtype=np.float32)
        self._balls = scene.add_batched_meshes_simple(
            f"{name}/points", ball.vertices, ball.faces, np.tile(UNTURNED, (count, 1)), np.zeros((count, 3)),
            batched_colors=_in_linear_light((red, green, blue)), lod="off",
        )  # fmt: skip
        self._links = scene.add_batched_meshes_simple(
            f"{name}/links", link.vertices, link.faces, np.tile(UNTURNED, (count - 1, 1)), np.zeros((count - 1, 3)),
            batched_scales=self._scales, batched_colors=_in_linear_light(colour), lod="off",
        )  # fmt: skip

    def update(self, robot: Robot, R: Array, p: Array) -> None:
        """Move the bodies."""
        points = points_on_bodies(robot, R[None], p[None])[0]
        self._balls.batched_positions = points.astype(np.float32)
        starts, steps = points[:-1], np.diff(points, axis=0)
        lengths = np.linalg.norm(steps, axis=1, keepdims=True)
        along = np.divide(steps, lengths, out=np.tile([0.0, 0.0, 1.0], (len(steps), 1)), where=lengths > 0)
        self._links.batched_positions = (starts + steps / 2).astype(np.float32)
        self._links.batched_wxyzs = wxyz(z_along(along)).astype(np.float32)
        scales = np.hstack([np.ones((len(steps), 2)), np.maximum(lengths, SHORTEST_LINK)]).astype(np.float32)
        if not np.allclose(scales, self._scales):
            self._links.batched_scales = self._scales = scales


def _in_linear_light(colour: Rgb) -> Rgb:
    """A colour as a page takes those of batches: all others it makes linear by itself (sRGB, IEC 61966-2-1)."""
    share = np.array(colour) / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)  # noqa: PLR2004 (the standard's)
    red, green, blue = (round(255 * part) for part in linear.tolist())
    return red, green, blue


def z_along(directions: Array) -> Array:
    """Rotations that take the z axis to unit vectors, Shape (…, 3), each Shape (3, 3)."""
    least = np.eye(3)[np.argmin(np.abs(directions), axis=-1)]
    x = np.cross(directions, least)
    x = x / np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(directions, x), directions], axis=-1)


def wxyz(R: Array) -> Array:
    """Rotations, Shape (…, 3, 3), as viser's quaternions, Shape (…, 4)."""
    return np.roll(quaternions_from_rotations(R), 1, axis=-1)
