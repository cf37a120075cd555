# SPDX-License-Identifier: MIT
"""A second result in the scene, beside the first or over it, played by the same clock; needs the extra 'view'."""

from collections.abc import Sequence

import numpy as np
import viser

from mrts.base.arrays import Array
from mrts.plots.labels import shortened
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory
from mrts.scene.arm_meshes import drawn_arms
from mrts.scene.cell_shapes import body_poses
from mrts.scene.cell_view import look_at_cell
from mrts.scene.held_body import held_body
from mrts.scene.scene import OBJECT, Rgb
from mrts.viewer.player_state import PlayerState
from mrts.viewer.scene import ViewerScene
from mrts.viewer.scene_arms import DrawnArm, wxyz
from mrts.viewer.workbench.answer import Answer

Others = Sequence[tuple[str, ScalingResult]]
"""Results with a trajectory, each with its name for people."""

BESIDE, OVER, HIDDEN = "beside it", "over it", "hidden"
PLACES = (BESIDE, OVER, HIDDEN)

APART = 1.9
"""From the middle of one cell to that of the other, as a share of the cell's size."""

COLOUR: Rgb = (140, 146, 156)
"""Of its arms."""


class OtherResult:
    """Arms and object of another result at the time of the first; it stands where it has ended.

    Args:
        server: Where.
        scene: Whose view has room for it.
        name: Of the result, for people.
        result: With a trajectory.

    Attributes:
        body: What it carries.
        offset: From where it stands over the first to where it stands beside it, Shape (3,) [m].
    """

    def __init__(self, server: viser.ViserServer, scene: ViewerScene, name: str, result: ScalingResult) -> None:
        assert result.trajectory is not None  # noqa: S101 (what is read to be played has one)
        self._done: ScaledTrajectory = result.trajectory
        self._view, drawing, cell = scene, server.scene, result.cell
        view = look_at_cell(cell, self._done.q, result.motion.object.position)
        across = np.cross(view.up, view.direction)
        self.offset = APART * view.size * across / np.linalg.norm(across)
        robots = cell.robots
        self._frames = [drawing.add_frame(f"/arms/{robot.name} of the other", show_axes=False) for robot in robots]
        self._arms = [
            DrawnArm(drawing, f"{robot.name} of the other", len(robot.joints) + 1, parts, COLOUR)
            for robot, parts in zip(robots, drawn_arms(cell, {}, lambda _text: None), strict=True)
        ]
        body = held_body(cell)
        mesh = body.vertices.astype(np.float32), body.faces.astype(np.uint32)
        self.body = drawing.add_mesh_simple("/other_object", *mesh, color=OBJECT, opacity=0.6, flat_shading=True)
        self._label = drawing.add_label("/other_name", shortened(name), anchor="bottom-center")
        self._above = 0.5 * view.size * view.up
        with server.gui.add_folder("Other result"):
            self._place = server.gui.add_dropdown("stands", PLACES, initial_value=BESIDE)
        self._shown = BESIDE
        scene.look_beside(self.offset)
        self._time = 0.0

    def show_answer(self, answer: Answer) -> None:
        """It is the same whatever is chosen."""

    def show_moment(self, state: PlayerState) -> None:
        """Go to the time of the first."""
        self._time = state.time
        self._draw()

    def step(self, elapsed: float) -> None:  # noqa: ARG002 (what every part is told)
        """Stand where it is wanted."""
        if self._place.value != self._shown:
            self._shown = self._place.value
            self._draw()
            self._view.look_beside(self._offset())

    def _offset(self) -> Array:
        return self.offset if self._shown == BESIDE else np.zeros(3)

    def _draw(self) -> None:
        visible = self._shown != HIDDEN
        offset = self._offset()
        done, cell = self._done, self._done.cell
        sample = int(np.argmin(np.abs(done.time - self._time)))
        for arm, robot, joints in zip(self._arms, cell.robots, cell.joint_slices.values(), strict=True):
            R, p = body_poses(robot, done.q[None, sample, joints])
            arm.update(R[0], p[0] + offset)
        carried = done.motion.object
        self.body.position, self.body.wxyz = carried.position[sample] + offset, wxyz(carried.rotation[sample])
        self._label.position = carried.position[sample] + offset + self._above
        for part in (*self._frames, self.body, self._label):
            part.visible = visible
