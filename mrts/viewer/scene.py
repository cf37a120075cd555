# SPDX-License-Identifier: MIT
"""The cell in a viser scene: arms, object, contact wrenches; needs the extra 'view'."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.rigid_transform import quaternions_from_rotations
from mrts.cell.robot import Robot
from mrts.drawing.arm_meshes import arm_meshes
from mrts.drawing.cell_shapes import body_poses, contact_forces, joint_points
from mrts.drawing.cell_view import FIELD_OF_VIEW, CellView, look_at_cell
from mrts.drawing.object_surface import object_surface
from mrts.viewer.player_state import PlayerState

ARM, JOINT, OBJECT = (150, 160, 172), (70, 80, 95), (230, 185, 90)
FORCE, MOMENT = (190, 50, 0), (0, 110, 80)
"""Colours, 0 to 255; those of the arrows are darker than they look in the scene's light."""

THICKNESS = 0.02
"""Radius of an arm that is drawn without meshes, as a share of the cell's size."""

ARROW = 0.5
"""Longest arrow at the first choice of speed, as a share of the cell's size."""

ROUNDED_DOWN = 1e-9
"""A length below a round one by this share is that one: rounding of their quotient."""

SHORTEST = 1e-3
"""Arrows below this share of the cell's size have no direction worth drawing."""


class ViewerScene:
    """Draws a state and follows it.

    Args:
        server: Where.
        state: What.
        urdfs: URDF and base link by robot, as far as there are any.
        warn: Told which arm is drawn without its meshes, and why.

    Attributes:
        metres_per_newton: Length of a force's arrow for 1 N, 1, 2 or 5 times a power of ten [m].
        metres_per_newton_metre: Likewise of a moment's.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        state: PlayerState,
        urdfs: Mapping[str, tuple[Path, str | None]],
        warn: Callable[[str], None],
    ) -> None:
        self._scene, self._state = server.scene, state
        result = state.result
        view = look_at_cell(result.cell, result.motion)
        self._size = view.size
        self._scene.set_up_direction(view.up)
        server.initial_camera.up = view.up
        server.initial_camera.position = view.camera
        server.initial_camera.look_at = view.target
        server.initial_camera.fov = FIELD_OF_VIEW
        self._draw_surroundings(view)
        self._arms = [
            _MeshArm(self._scene, robot, meshes)
            if (meshes := _meshes(robot, urdfs, warn))
            else _SimpleArm(self._scene, robot, THICKNESS * view.size)
            for robot in result.cell.robots
        ]
        surface = object_surface(result.cell)
        self._box = self._scene.add_mesh_simple(
            "/object", *surface, color=OBJECT, opacity=0.85, flat_shading=True, side="double"
        )
        nothing = np.zeros((0, 2, 3))
        thin = 0.4 * THICKNESS * view.size
        self._forces, self._moments = (
            self._scene.add_arrows(
                name, nothing, colour, shaft_radius=thin, head_radius=2.2 * thin, head_length=5 * thin
            )
            for name, colour in (("/forces", FORCE), ("/moments", MOMENT))
        )
        self.metres_per_newton = self.metres_per_newton_metre = 1.0
        self.rescale()

    def rescale(self) -> None:
        """Choose the arrows' lengths for the trajectory as it is now."""
        done, cell = self._state.trajectory, self._state.result.cell
        forces = np.array([unit == "N" for unit in cell.wrench_units] * len(cell.robots))
        largest = [float(np.max(np.abs(done.wrench[:, part]), initial=0.0)) for part in (forces, ~forces)]
        self.metres_per_newton, self.metres_per_newton_metre = (
            _round_down(ARROW * self._size / value) if value > 0 else 1.0 for value in largest
        )

    def update(self) -> None:
        """Draw the chosen sample."""
        state, cell = self._state, self._state.result.cell
        motion, at = state.result.motion, slice(state.sample, state.sample + 1)
        position, rotation = motion.object.position[at], motion.object.rotation[at]
        for arm, joints in zip(self._arms, cell.joint_slices.values(), strict=True):
            arm.update(motion.q[at, joints])
        self._box.position, self._box.wxyz = position[0], _wxyz(rotation[0])
        contacts = [
            contact_forces(cell, robot, position, rotation, state.trajectory.wrench[at, part])
            for robot, part in zip(cell.robots, cell.wrench_slices.values(), strict=True)
        ]
        points = np.concatenate([contact.point for contact in contacts])
        forces = np.concatenate([contact.force for contact in contacts])
        moments = np.concatenate([contact.moment for contact in contacts])
        self._forces.points = self._arrows(points, forces * self.metres_per_newton)
        self._moments.points = self._arrows(points, moments * self.metres_per_newton_metre)

    def _arrows(self, start: Array, step: Array) -> NDArray[np.float32]:
        long = np.linalg.norm(step, axis=1) > SHORTEST * self._size
        return np.stack([start[long], start[long] + step[long]], axis=1).astype(np.float32)

    def _draw_surroundings(self, view: CellView) -> None:
        size = view.size
        self._scene.add_frame("/world", axes_length=0.2 * size, axes_radius=0.006 * size, origin_radius=0.0)
        cell_size = _round_down(size / 4)
        self._scene.add_grid(
            "/floor",
            width=float(np.ceil(6 * size / cell_size) * cell_size),
            height=float(np.ceil(6 * size / cell_size) * cell_size),
            cell_size=cell_size,
            section_size=5 * cell_size,
            wxyz=_wxyz(_z_along(view.up)),
            position=view.floor,
        )


class _MeshArm:
    """An arm with the meshes of its URDF: a frame for each body, which carries its meshes."""

    def __init__(self, scene: viser.SceneApi, robot: Robot, meshes: list[tuple[int, Any]]) -> None:
        self._robot = robot
        self._frames = [
            scene.add_frame(f"/arms/{robot.name}/body{index}", show_axes=False)
            for index in range(len(robot.joints) + 1)
        ]
        for number, (body, mesh) in enumerate(meshes):
            scene.add_mesh_trimesh(f"/arms/{robot.name}/body{body}/mesh{number}", mesh)

    def update(self, q: Array) -> None:
        """Move to joint positions, Shape (1, n_i) [rad or m]."""
        rotations, positions = body_poses(self._robot, q)
        for frame, R, p in zip(self._frames, rotations[0], positions[0], strict=True):
            frame.position, frame.wxyz = p, _wxyz(R)


class _SimpleArm:
    """An arm as cylinders from joint to joint, with a ball at each."""

    def __init__(self, scene: viser.SceneApi, robot: Robot, radius: float) -> None:
        self._robot = robot
        self._balls = [
            scene.add_icosphere(f"/arms/{robot.name}/point{index}", 1.4 * radius, JOINT)
            for index in range(len(robot.joints) + 2)
        ]
        self._links = [
            scene.add_cylinder(f"/arms/{robot.name}/link{index}", radius, 1.0, ARM)
            for index in range(len(robot.joints) + 1)
        ]

    def update(self, q: Array) -> None:
        """Move to joint positions, Shape (1, n_i) [rad or m]."""
        points = joint_points(self._robot, q)[0]
        for ball, point in zip(self._balls, points, strict=True):
            ball.position = point
        for link, start, end in zip(self._links, points, points[1:], strict=False):
            length = float(np.linalg.norm(end - start))
            link.visible = length > 0
            if length > 0:
                link.position, link.wxyz = (start + end) / 2, _wxyz(_z_along((end - start) / length))
                link.scale = (1.0, 1.0, length)


def _meshes(
    robot: Robot, urdfs: Mapping[str, tuple[Path, str | None]], warn: Callable[[str], None]
) -> list[tuple[int, Any]]:
    if robot.name not in urdfs:
        return []
    path, base_link = urdfs[robot.name]
    try:
        return arm_meshes(path, base_link, robot.joints, robot.held)
    except InputError as error:
        warn(f"robot '{robot.name}' is drawn with simple shapes: {error}")
        return []


def _round_down(value: float) -> float:
    """1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(digit for digit in (1, 2, 5) if digit <= value / power * (1 + ROUNDED_DOWN)) * power)


def _z_along(direction: Array) -> Array:
    """A rotation that takes the z axis to a unit vector, Shape (3, 3)."""
    x = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(direction, x), direction], axis=1)


def _wxyz(R: Array) -> Array:
    return np.roll(quaternions_from_rotations(R), 1)
