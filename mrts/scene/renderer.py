# SPDX-License-Identifier: MIT
"""Pictures of a moving cell by MuJoCo's renderer, which needs libEGL and no display."""

import os
import sys
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, require_extra
from mrts.program.rate_limits import RateLimits
from mrts.scaling.scaled_trajectory import LimitUse, ScaledTrajectory
from mrts.scene.arm_meshes import Warn, drawn_arms
from mrts.scene.cell_view import FIELD_OF_VIEW, Camera, CellView
from mrts.scene.held_body import Surface, held_body, outlines, shape_surface
from mrts.scene.scene import (
    FORCE,
    OBJECT,
    OUTLINE,
    PATH,
    SEE_THROUGH,
    SURROUNDINGS,
    Rgb,
    Scene,
    blended,
    rgba,
    round_down,
    wxyz,
)

ARROW_RADIUS, PATH_RADIUS = 0.008, 0.004
"""As a share of the cell's size."""

HALF_DRAWN = 2.0
"""MuJoCo draws an arrow half as long as it is connected."""

NEARER = 0.1
"""Of its distance from the camera, at which an arrow is drawn."""

SHORTEST = 0.01
"""Forces below this share of the cell's size are not drawn."""

PATH_POINTS = 48
"""Of the line along which the object moves."""

TILES = 5
"""Of the floor, in the cell's size; rounded to 1, 2 or 5 times a power of ten."""

OUTLINE_RADIUS = 0.0025
"""Of the object's edges at the start and the goal, as a share of the cell's size."""

MOST_FACES = 200_000
"""Of a mesh of MuJoCo's; larger ones become several."""

FEWEST_VERTICES = 4
"""Of such a mesh."""

LEAST_AREA = 1e-12
"""Of such a mesh [m²]: MuJoCo refuses what has none, and nobody sees less."""

BACKDROP, FLOOR, GROOVE = (0.96, 0.97, 0.98), (0.93, 0.94, 0.95), (0.80, 0.82, 0.85)
"""Red, green and blue, 0 to 1."""

Frame = NDArray[np.uint8]
"""Shape (height, width, 3)."""


@dataclass(frozen=True, eq=False)
class Clip:
    """A motion that is played, the limit that decides its speed, and rates that it keeps."""

    title: str
    trajectory: ScaledTrajectory
    deciding: LimitUse | None
    rates: RateLimits | None = None

    @cached_property
    def scene(self) -> Scene:
        """Where everything is at the trajectory's samples."""
        return Scene.of(self.trajectory)


def require_renderer() -> Any:
    """MuJoCo, once it is known to draw without a display.

    Raises:
        InputError: If it, or the library that it draws by, is not installed.
    """
    if sys.platform == "linux" and "mujoco" not in sys.modules:  # it looks once, when it is imported
        os.environ.setdefault("MUJOCO_GL", "egl")
    require_extra("pictures and films", "film", "mujoco")
    try:
        import mujoco  # noqa: PLC0415 (an extra, and a quarter of a second)

        mujoco.GLContext(8, 8).free()
    except Exception as error:  # noqa: BLE001 (each way to draw raises its own)
        rule = "pictures and films are drawn by libEGL, which lacks or does not work: on Debian, apt install libegl1 "
        rule += "libgl1-mesa-dri; or apt install libosmesa6 and set MUJOCO_GL=osmesa; set it before mujoco is imported "
        rule += f"({type(error).__name__}: {error})."
        raise InputError("MUJOCO_GL", rule, value=os.environ.get("MUJOCO_GL", "")) from None
    return mujoco


class SceneRenderer:
    """Draws moments of one clip, in a size [pixels]; it is closed by the thread that made it."""

    def __init__(
        self, clip: Clip, view: CellView, camera: Camera, size: tuple[int, int], metres_per_newton: float, warn: Warn
    ) -> None:
        self._mujoco = mujoco = require_renderer()
        self._clip, self._view, self._camera, self._metres_per_newton = clip, view, camera, metres_per_newton
        cell, scene = clip.trajectory.cell, clip.scene
        self._spec = mujoco.MjSpec()
        self._add_stage(size)
        body = held_body(cell)
        self._add_surface(self._spec.worldbody.add_body(name="object", mocap=True), "object", body, OBJECT)
        for number, one in enumerate(cell.surroundings):
            name = f"surroundings/{number}"
            self._add_surface(self._spec.worldbody, name, shape_surface(cell, one), SURROUNDINGS, SEE_THROUGH)
        for number, parts in enumerate(drawn_arms(cell, warn)):
            robot, found = cell.robots[number], clip.deciding
            deciding = None if found is None else found.body(robot)
            bodies = [
                self._spec.worldbody.add_body(name=f"{number}/{index}", mocap=True)
                for index in range(len(robot.joints) + 1)
            ]
            for place, part in enumerate(parts):
                mesh = part.mesh
                for start in range(0, len(mesh.faces), MOST_FACES):
                    faces, name = mesh.faces[start : start + MOST_FACES], f"{number}/{place}/{start}"
                    self._add_mesh(bodies[part.body], name, mesh.vertices, faces, part.colour(deciding))
        self._model = self._spec.compile()
        self._data = mujoco.MjData(self._model)
        self._renderer = mujoco.Renderer(self._model, size[1], size[0])
        self._edges = outlines(body)
        chosen = np.unique(np.linspace(0, len(scene.position) - 1, PATH_POINTS).astype(int))
        self._path = scene.position[chosen]

    def close(self) -> None:
        """Free what the renderer holds."""
        self._renderer.close()

    def picture(self, time: float) -> Frame:
        """A picture of a moment of the played time [s]."""
        scene, place = self._clip.scene, self._clip.scene.place(time)
        self._move("object", blended(scene.rotation, place), blended(scene.position, place))
        for number, (R, p) in enumerate(scene.bodies):
            for index, (turn, at) in enumerate(zip(blended(R, place), blended(p, place), strict=True)):
                self._move(f"{number}/{index}", turn, at)
        self._mujoco.mj_kinematics(self._model, self._data)
        self._mujoco.mj_camlight(self._model, self._data)
        self._renderer.update_scene(self._data, camera="camera")
        self._add_path()
        self._add_forces(*(blended(each, place) for each in scene.contacts[:2]))
        drawn: Frame = self._renderer.render()
        return drawn

    def _add_path(self) -> None:
        capsule, size, scene = self._mujoco.mjtGeom.mjGEOM_CAPSULE, self._view.size, self._clip.scene
        for start, end in pairwise(self._path):
            self._connect(capsule, start, end, PATH_RADIUS * size, PATH)
        for sample in (0, -1):
            for start, end in scene.position[sample] + self._edges @ scene.rotation[sample].T:
                self._connect(capsule, start, end, OUTLINE_RADIUS * size, OUTLINE)

    def _add_forces(self, points: Array, forces: Array) -> None:
        """Arrows, seen over all else, because most begin inside a hand or the object: drawn smaller, but nearer."""
        arrow, eye, size = self._mujoco.mjtGeom.mjGEOM_ARROW, self._camera.position, self._view.size
        for point, force in zip(points, self._metres_per_newton * forces, strict=True):
            if np.linalg.norm(force) > SHORTEST * size:
                start, step = eye + NEARER * (point - eye), NEARER * HALF_DRAWN * force
                self._connect(arrow, start, start + step, NEARER * ARROW_RADIUS * size, FORCE)

    def _add_stage(self, size: tuple[int, int]) -> None:
        mujoco, spec, view, camera = self._mujoco, self._spec, self._view, self._camera
        spec.visual.global_.offwidth, spec.visual.global_.offheight = size
        spec.visual.quality.shadowsize, spec.visual.quality.offsamples = 2048, 4
        spec.visual.headlight.ambient, spec.visual.headlight.diffuse = (0.5,) * 3, (0.35,) * 3
        spec.visual.headlight.specular = (0.1,) * 3
        spec.visual.rgba.haze = (*BACKDROP, 1)
        spec.visual.map.znear, spec.visual.map.zfar, spec.visual.map.haze = 0.02, 30, 0.8
        spec.visual.map.shadowclip = 2
        spec.stat.extent, spec.stat.center = view.size, camera.target
        world, right, up, forward = spec.worldbody, *camera.axes
        world.add_camera(
            name="camera", pos=camera.position, quat=wxyz(np.stack([right, up, -forward], axis=1)),
            fovy=np.rad2deg(FIELD_OF_VIEW),
        )  # fmt: skip
        lamp = 0.9 * view.up - 0.45 * forward - 0.35 * right + 0.2 * up
        world.add_light(
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, pos=camera.target + 3 * view.size * lamp, dir=-lamp,
            diffuse=(0.35,) * 3, specular=(0.1,) * 3, castshadow=True,
        )  # fmt: skip
        spec.add_texture(
            name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
            rgb1=BACKDROP, rgb2=BACKDROP, width=8, height=48,
        )  # fmt: skip
        spec.add_texture(
            name="tiles", type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
            mark=mujoco.mjtMark.mjMARK_EDGE, rgb1=FLOOR, rgb2=FLOOR, markrgb=GROOVE, width=96, height=96,
        )  # fmt: skip
        tile = round_down(view.size / TILES)
        floor = spec.add_material(name="floor", texrepeat=(1 / tile, 1 / tile), texuniform=True, specular=0.0)
        floor.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
        plane = mujoco.mjtGeom.mjGEOM_PLANE
        world.add_geom(type=plane, size=(0, 0, 0.1), pos=view.floor, material="floor", quat=wxyz(view.level))

    def _add_surface(self, body: Any, name: str, surface: Surface, colour: Rgb, opacity: float = 1.0) -> None:
        corners = surface[0][surface[1]].reshape(-1, 3)  # no face shares a corner, so that each is shaded flat
        self._add_mesh(body, name, corners, np.arange(len(corners)).reshape(-1, 3), colour, opacity)

    def _add_mesh(
        self, body: Any, name: str, vertices: Array, faces: NDArray[np.integer], colour: Rgb, opacity: float = 1.0
    ) -> None:
        corners = np.asarray(vertices)[faces]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        if len(vertices) < FEWEST_VERTICES or np.sum(area) < LEAST_AREA:
            return
        mesh = self._spec.add_mesh(name=name, inertia=self._mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        mesh.uservert, mesh.userface = np.ravel(vertices).tolist(), np.ravel(faces).tolist()
        kind = self._mujoco.mjtGeom.mjGEOM_MESH
        body.add_geom(type=kind, meshname=name, rgba=rgba(colour, opacity), contype=0, conaffinity=0)

    def _move(self, name: str, R: Array, p: Array) -> None:
        body = self._model.body(name).mocapid[0]
        self._data.mocap_pos[body], self._data.mocap_quat[body] = p, wxyz(R)

    def _connect(self, shape: Any, start: Array, end: Array, radius: float, colour: Rgb) -> None:
        mujoco, scene = self._mujoco, self._renderer.scene
        if scene.ngeom >= scene.maxgeom or np.linalg.norm(end - start) == 0:
            return
        geom = scene.geoms[scene.ngeom]
        scene.ngeom += 1
        mujoco.mjv_initGeom(geom, shape, np.full(3, radius), start, np.eye(3).ravel(), np.array(rgba(colour)))
        mujoco.mjv_connector(geom, shape, radius, start, end)
        geom.category = mujoco.mjtCatBit.mjCAT_DECOR
