# SPDX-License-Identifier: MIT
"""The gizmo that moves bases, grasps and ends of the motion in the scene; needs the extra 'view'."""

from queue import Empty, SimpleQueue

import numpy as np
import viser

from mrts.base.rigid_transform import RigidTransform, rotations_from_quaternions
from mrts.scene.scene import wxyz
from mrts.viewer.controls.places import Place, free_axes, in_plane
from mrts.viewer.workbench.choices import Choices, Given

NAME = "/gizmo"

ARM = 0.3
"""Length of its arrows, as a share of the cell's size."""


class PlaceGizmo:
    """One gizmo, at the place that is chosen.

    Its rotation is what turned the place from where it was given, so that in a plane its axes are those of the world.

    Attributes:
        place: What it moves; None hides it.
        dragged: Whether a user holds it.
    """

    def __init__(self, server: viser.ViserServer, given: Given, size: float) -> None:
        axes = free_axes(given.cell)[0]
        self._given = given
        self.place: Place | None = None
        self.dragged = False
        self._handle = server.scene.add_transform_controls(
            NAME, scale=ARM * size, line_width=3.0, active_axes=("x" in axes, "y" in axes, "z" in axes),
            depth_test=False, visible=False,
        )  # fmt: skip
        self._held = RigidTransform.identity()
        self._events: SimpleQueue[tuple[str, RigidTransform]] = SimpleQueue()
        self._handle.on_update(self._note)

    async def _note(self, event: viser.TransformControlsEvent) -> None:
        """Keep what a browser did for the thread that follows the controls."""
        handle = event.target
        quaternion = np.roll(np.asarray(handle.wxyz, dtype=np.float64), -1)
        pose = RigidTransform(rotations_from_quaternions(quaternion), np.array(handle.position, dtype=np.float64))
        self._events.put((event.phase, pose))

    def choose(self, place: Place | None) -> None:
        """Move another place, or none."""
        self.place, self.dragged = place, False
        self._handle.visible = place is not None

    def follow(self, choices: Choices, held: RigidTransform) -> None:
        """Stand where the place is, unless a user holds it."""
        if self.place is None or self.dragged:
            return
        self._held = held
        given = self.place.in_world(self.place.given_pose(self._given), held)
        now = self.place.in_world(self.place.pose(choices, self._given), held)
        self._handle.position = now.p
        self._handle.wxyz = wxyz(now.R @ given.R.T)

    def moved(self, choices: Choices) -> tuple[Choices | None, bool]:
        """Choices as the gizmo was moved since the last call, None if it was not, and whether it was let go."""
        last, ended = None, False
        try:
            while True:
                phase, pose = self._events.get_nowait()
                self.dragged = phase != "end"
                ended = ended or phase == "end"
                if phase == "update":
                    last = pose
        except Empty:
            pass
        if last is None or self.place is None:
            return None, ended
        given = self.place.given_pose(self._given)
        at_start = self.place.in_world(given, self._held)
        pose = self.place.from_world(RigidTransform(last.R @ at_start.R, last.p), self._held)
        return self.place.with_pose(choices, in_plane(self._given.cell, pose, given)), ended
