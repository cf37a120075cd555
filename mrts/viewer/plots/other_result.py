# SPDX-License-Identifier: MIT
"""A second result in the scene, beside the first or over it, played by the same clock; needs the extra 'view'."""

from collections.abc import Sequence

import numpy as np
import viser

from mrts.plots.labels import shortened
from mrts.scaling.result import ScalingResult
from mrts.scene.arm_meshes import drawn_arms
from mrts.scene.cell_view import look_at_cell
from mrts.scene.held_body import held_body
from mrts.scene.scene import OBJECT, Rgb, Scene, wxyz
from mrts.viewer.player_state import PlayerState
from mrts.viewer.scene import ViewerScene
from mrts.viewer.scene_arms import DrawnArm
from mrts.viewer.workbench.answer import Answer

Others = Sequence[tuple[str, ScalingResult]]
"""Results with a trajectory, each with its name for people."""

BESIDE, OVER, HIDDEN = "beside it", "over it", "hidden"
PLACES = (BESIDE, OVER, HIDDEN)

NAME = "/other"

APART = 1.9
"""From the middle of one cell to that of the other, as a share of the cell's size."""

COLOUR: Rgb = (140, 146, 156)
"""Of its arms."""


class OtherResult:
    """Arms and object of another result at the time of the first; it stands where it has ended.

    Attributes:
        frame: What holds all of it.
        body: What it carries.
        offset: From where it stands over the first to where it stands beside it, Shape (3,) [m].
    """

    def __init__(self, server: viser.ViserServer, scene: ViewerScene, name: str, result: ScalingResult) -> None:
        assert result.trajectory is not None  # noqa: S101 (what is read to be played has one)
        self._done, self._view, drawing, cell = result.trajectory, scene, server.scene, result.cell
        self._scene = Scene.of(self._done)
        view = look_at_cell(cell, self._scene.q, self._scene.position)
        across = np.cross(view.up, view.direction)
        self.offset = APART * view.size * across / np.linalg.norm(across)
        self.frame = drawing.add_frame(NAME, show_axes=False)
        self._arms = [
            DrawnArm(drawing, f"{NAME}/{robot.name}", len(robot.joints) + 1, parts, COLOUR)
            for robot, parts in zip(cell.robots, drawn_arms(cell, {}, lambda _text: None), strict=True)
        ]
        body = held_body(cell)
        mesh = body.vertices.astype(np.float32), body.faces.astype(np.uint32)
        self.body = drawing.add_mesh_simple(f"{NAME}/object", *mesh, color=OBJECT, opacity=0.6, flat_shading=True)
        self._label = drawing.add_label(f"{NAME}/name", shortened(name), anchor="bottom-center")
        self._above = 0.5 * view.size * view.up
        with server.gui.add_folder("Other result"):
            self._place = server.gui.add_dropdown("stands", PLACES, initial_value=BESIDE)
        self._shown = ""
        self.step(0.0)

    def show_answer(self, answer: Answer) -> None:
        """It is the same whatever is chosen."""

    def show_moment(self, state: PlayerState) -> None:
        """Go to the time of the first."""
        moment = self._scene.moment(int(np.argmin(np.abs(self._done.time - state.time))))
        for arm, (R, p) in zip(self._arms, moment.bodies, strict=True):
            arm.update(R, p)
        self.body.position, self.body.wxyz = moment.position, wxyz(moment.rotation)
        self._label.position = moment.position + self._above

    def step(self, elapsed: float) -> None:  # noqa: ARG002 (what every part is told)
        """Stand where it is wanted."""
        if self._place.value != self._shown:
            self._shown = self._place.value
            offset = self.offset if self._shown == BESIDE else np.zeros(3)
            self.frame.position, self.frame.visible = offset, self._shown != HIDDEN
            self._view.look_beside(offset)
