# SPDX-License-Identifier: MIT
"""A second result in the scene, beside the first or over it, played by the same clock; needs the extra 'view'."""

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import viser

from mrts.base.arrays import Array
from mrts.drawing.bodies.cell_shapes import body_poses
from mrts.drawing.bodies.cell_view import look_at_cell
from mrts.drawing.bodies.held_body import held_body
from mrts.plots.labels import shortened
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory
from mrts.viewer.player_state import PlayerState
from mrts.viewer.scene import OBJECT, THICKNESS, ViewerScene
from mrts.viewer.scene_arms import Rgb, drawn_arm, wxyz
from mrts.viewer.viewer_part import ViewerPart
from mrts.viewer.workbench.answer import Answer

Others = Sequence[tuple[str, ScalingResult]]
"""Results with a trajectory, each with its name for people."""

BESIDE, OVER, HIDDEN = "beside it", "over it", "hidden"
PLACES = (BESIDE, OVER, HIDDEN)

APART = 1.9
"""From the middle of one cell to that of the other, as a share of the cell's size."""

COLOUR: Rgb = (140, 146, 156)
"""Of its arms."""


def other_results(server: viser.ViserServer, scene: ViewerScene, others: Others) -> list[ViewerPart]:
    """Show the first of some results in the scene; more have no room there.

    Args:
        server: Where; its control stands in the container that is open.
        scene: Of the first.
        others: May be none.
    """
    return [OtherResult(server, scene, *other) for other in others[:1]]


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
        self._robots = [replace(robot, name=f"{robot.name} of the other") for robot in cell.robots]
        self._frames = [drawing.add_frame(f"/arms/{robot.name}", show_axes=False) for robot in self._robots]
        self._arms = [
            drawn_arm(drawing, robot, MappingProxyType({}), COLOUR, THICKNESS * view.size, lambda _text: None)
            for robot in self._robots
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
        """From where it would stand over the first, Shape (3,) [m]."""
        return self.offset if self._shown == BESIDE else np.zeros(3)

    def _draw(self) -> None:
        visible = self._shown != HIDDEN
        offset = self._offset()
        done, cell = self._done, self._done.cell
        sample = int(np.argmin(np.abs(done.time - self._time)))
        for arm, robot, joints in zip(self._arms, self._robots, cell.joint_slices.values(), strict=True):
            R, p = body_poses(robot, done.q[None, sample, joints])
            arm.update(robot, R[0], p[0] + offset)
        carried = done.motion.object
        self.body.position, self.body.wxyz = carried.position[sample] + offset, wxyz(carried.rotation[sample])
        self._label.position = carried.position[sample] + offset + self._above
        for part in (*self._frames, self.body, self._label):
            part.visible = visible
