# SPDX-License-Identifier: MIT
"""The cell in a viser scene: arms, the body they hold, its path, contact wrenches, gaps."""

import numpy as np
import viser
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.scaling.scaled_trajectory import LimitUse
from mrts.scene.arm_meshes import Warn, drawn_arms, name_place
from mrts.scene.cell_view import FIELD_OF_VIEW, look_at
from mrts.scene.held_body import held_body, outlines, shape_surface
from mrts.scene.scene import (
    FORCE,
    MOMENT,
    OBJECT,
    OUTLINE,
    OVER_LIMIT,
    PATH,
    SEE_THROUGH,
    SURROUNDINGS,
    Scene,
    arm_colour,
    blended,
    round_down,
    wxyz,
)
from mrts.viewer.player_state import HeldPoses

ARROW_RADIUS, HAND = 0.008, 0.034
"""Of the shaft of an arrow, and radius of a hand, as a share of the cell's size."""

ARROW = 0.5
"""Longest arrow at the first choice of speed, as a share of the cell's size."""

SHORTEST = 1e-3
"""Arrows below this share of the cell's size have no direction worth drawing."""

OUTLINE_WIDTH, PATH_WIDTH = 1.5, 3.0
"""Of the object's edges at start and goal, and of its path [pixels]."""

OPACITY = 0.9
"""Of the object."""

NO_LINES = np.zeros((0, 2, 3), dtype=np.float32)


class ViewerScene:
    """Draws answers and moments.

    Attributes:
        size: Radius of a ball that holds all parts at all times [m].
        metres_per_newton: Length of a force's arrow for 1 N, 1, 2 or 5 times a power of ten [m].
        metres_per_newton_metre: The same of a moment's.
    """

    def __init__(self, server: viser.ViserServer, shown: Scene, warn: Warn) -> None:
        self._scene = server.scene
        cell, self._view = shown.cell, look_at(shown)
        self.size = self._view.size
        self.metres_per_newton = self.metres_per_newton_metre = 1.0
        self._look(server.initial_camera)
        self._scene.configure_default_lights(enabled=True, cast_shadow=False)  # shadows cost most of the frames
        self._draw_surroundings()
        self._draw_cell(cell, warn)
        self._body_key = b""
        scene, thin = self._scene, ARROW_RADIUS * self.size
        self._forces, self._moments, self._gaps = (
            scene.add_arrows(name, NO_LINES, colour, shaft_radius=thin, head_radius=2.2 * thin, head_length=5 * thin)
            for name, colour in (("/carried/forces", FORCE), ("/carried/moments", MOMENT), ("/gaps", OVER_LIMIT))
        )
        self._path = scene.add_line_segments(
            "/path", np.zeros((1, 2, 3)), PATH, thickness=PATH_WIDTH, thickness_units="screen"
        )
        self._names = [
            scene.add_label(f"/names/{robot.name}", robot.name, anchor="top-center") for robot in cell.robots
        ]
        self._end_names = [
            scene.add_label("/start_name", "start", anchor="top-left"),
            scene.add_label("/goal_name", "goal", anchor="bottom-right"),
        ]
        self.show(shown)

    def show(self, course: Scene, *, anew: bool = True) -> None:
        """Draw what does not move along the motion: its path, its ends; anew also the object and where arms stand.

        Arrows keep their scale unless they are drawn anew.
        """
        self._course = course
        if anew:
            self._draw_body(course.cell)
            self.metres_per_newton, self.metres_per_newton_metre = (
                round_down(ARROW * self.size / value) if value > 0 else 1.0 for value in course.strongest
            )
        for name, robot in zip(self._names, course.cell.robots, strict=True):
            name.position = name_place(course.cell, robot)
        poses = np.hstack([course.position, course.rotation.reshape(-1, 9)])
        moves = bool(np.any(np.ptp(poses, axis=0) > 0))
        for outline, at in zip(self._outlines, (0, -1), strict=True):
            outline.position, outline.wxyz = course.position[at], wxyz(course.rotation[at])
        for label, at in zip(self._end_names, (0, -1), strict=True):
            label.position, label.visible = course.position[at], moves
        steps = np.stack([course.position[:-1], course.position[1:]], axis=1).astype(np.float32)
        passed = course.passed[:-1] | course.passed[1:]
        colours = np.where(passed[:, None, None], np.array(OVER_LIMIT), np.array(PATH)).astype(np.uint8)
        self._path.points, self._path.colors = steps, np.repeat(colours, 2, axis=1)

    def mark(self, deciding: LimitUse | None) -> None:
        """Let the joint or the hand stand out whose limit decides how fast the motion may be played, or none."""
        for robot, part, drawn in self._parts:
            drawn.color = part.colour(None if deciding is None else deciding.body(robot))

    def show_moment(self, place: float, held: HeldPoses | None = None) -> None:
        """Draw a sample, or what is between two while it plays; where arms do not reach, what is missing there."""
        course = self._course
        for frames, (R, p) in zip(self._frames, course.bodies, strict=True):
            for frame, at, turn in zip(frames, blended(p, place), wxyz(blended(R, place)), strict=True):
                frame.position, frame.wxyz = at, turn
        position, rotation = blended(course.position, place), blended(course.rotation, place)
        self._carried.position, self._carried.wxyz = position, wxyz(rotation)
        point, force, turning = (blended(each, place) for each in course.contacts)
        points = (point - position) @ rotation
        self._forces.points = self._arrows(points, force @ rotation * self.metres_per_newton)
        self._moments.points = self._arrows(points, turning @ rotation * self.metres_per_newton_metre)
        missing = [] if held is None else np.flatnonzero(~held.reached[int(place)]).tolist()
        gaps = np.array([(course.lines[index][int(place), -1], point[index]) for index in missing]).reshape(-1, 2, 3)
        self._gaps.points = gaps.astype(np.float32)

    def darken(self, *, on: bool) -> None:
        """Draw the floor for a dark page, or for a light one."""
        self._floor.cell_color, self._floor.section_color = ((60,) * 3, (90,) * 3) if on else ((220,) * 3, (180,) * 3)

    def _arrows(self, start: Array, step: Array) -> NDArray[np.float32]:
        long = np.linalg.norm(step, axis=1) > SHORTEST * self.size
        return np.stack([start[long], start[long] + step[long]], axis=1).astype(np.float32)

    def _draw_cell(self, cell: Cell, warn: Warn) -> None:
        """Arms, a frame for each body that carries its meshes, that of the object, and what stands around them."""
        scene = self._scene
        self._frames, self._parts = [], []
        for index, (robot, parts) in enumerate(zip(cell.robots, drawn_arms(cell, warn), strict=True)):
            names = [f"/arms/{robot.name}/body{body}" for body in range(len(robot.joints) + 1)]
            self._frames.append([scene.add_frame(of, show_axes=False) for of in names])
            for number, part in enumerate(parts):
                mesh, at = part.mesh, f"{names[part.body]}/mesh{number}"
                drawn = scene.add_mesh_simple(at, mesh.vertices, mesh.faces, color=part.own, flat_shading=False)
                self._parts.append((robot, part, drawn))
            hand, radius = f"{names[-1]}/hand", HAND * self.size
            scene.add_icosphere(hand, radius, arm_colour(index), position=robot.T_base_tip.p)
        for number, one in enumerate(cell.surroundings):
            vertices, faces = shape_surface(cell, one)
            scene.add_mesh_simple(
                f"/surroundings/{number}", vertices.astype(np.float32), faces.astype(np.uint32),
                color=SURROUNDINGS, opacity=SEE_THROUGH, flat_shading=True, side="double", cast_shadow=False,
            )  # fmt: skip
        self._carried = scene.add_frame("/carried", show_axes=False)

    def _draw_body(self, cell: Cell) -> None:
        """The object where its shape is another one, and its edges at the start and the goal."""
        vertices, faces = body = held_body(cell)
        if vertices.tobytes() == self._body_key:
            return
        self._body_key = vertices.tobytes()
        self._scene.add_mesh_simple(
            "/carried/object", vertices.astype(np.float32), faces.astype(np.uint32),
            color=OBJECT, opacity=OPACITY, flat_shading=True,
        )  # fmt: skip
        self._outlines = [
            self._scene.add_line_segments(
                f"/{name}", outlines(body), OUTLINE, thickness=OUTLINE_WIDTH, thickness_units="screen"
            )
            for name in ("start", "goal")
        ]

    def _look(self, camera: viser.InitialCameraConfig) -> None:
        view, found = self._view, self._view.camera()
        self._scene.set_up_direction(view.up)
        camera.up, camera.position, camera.look_at = view.up, found.position, found.target
        camera.fov = FIELD_OF_VIEW

    def _draw_surroundings(self) -> None:
        view, size = self._view, self.size
        self._scene.add_frame("/world", axes_length=0.12 * size, axes_radius=0.004 * size, origin_radius=0.0)
        cell_size = round_down(size / 4)
        side = float(np.ceil(6 * size / cell_size) * cell_size)
        self._floor = self._scene.add_grid(
            "/floor",
            width=side,
            height=side,
            cell_size=cell_size,
            section_size=5 * cell_size,
            wxyz=wxyz(view.level),
            position=view.floor,
        )
