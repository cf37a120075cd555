# SPDX-License-Identifier: MIT
"""Arms in a viser scene; needs the extra 'view'."""

from collections.abc import Sequence

import numpy as np
import viser

from mrts.base.arrays import Array
from mrts.scene.arm_meshes import ArmMesh
from mrts.scene.scene import Rgb, wxyz


class DrawnArm:
    """An arm: a frame for each body, which carries its meshes."""

    def __init__(
        self, scene: viser.SceneApi, name: str, bodies: int, parts: Sequence[ArmMesh], colour: Rgb | None = None
    ) -> None:
        self._frames = [scene.add_frame(f"{name}/body{index}", show_axes=False) for index in range(bodies)]
        self._parts = [
            (
                part,
                scene.add_mesh_simple(
                    f"{name}/body{part.body}/mesh{number}", part.mesh.vertices, part.mesh.faces,
                    color=colour or part.own, flat_shading=False,
                ),
            )
            for number, part in enumerate(parts)
        ]  # fmt: skip
        self._deciding: int | None = None

    def update(self, R: Array, p: Array) -> None:
        """Move the bodies.

        Args:
            R: As of `body_poses`, at one moment, Shape (n_i + 1, 3, 3).
            p: Likewise, Shape (n_i + 1, 3) [m].
        """
        for frame, at, turn in zip(self._frames, p, wxyz(R), strict=True):
            frame.position, frame.wxyz = at, turn

    def mark(self, deciding: int | None) -> None:
        """Let the body stand out that decides how fast the motion may be played, or none."""
        if deciding != self._deciding:
            self._deciding = deciding
            for part, mesh in self._parts:
                if part.marks:
                    mesh.color = part.colour(deciding)


def z_along(directions: Array) -> Array:
    """Rotations that take the z axis to unit vectors, Shape (…, 3), each Shape (3, 3)."""
    least = np.eye(3)[np.argmin(np.abs(directions), axis=-1)]
    x = np.cross(directions, least)
    x = x / np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(directions, x), directions], axis=-1)
