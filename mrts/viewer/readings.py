# SPDX-License-Identifier: MIT
"""Bars of torques, wrenches and velocities against their limits; needs the extra 'view'."""

from math import inf

import viser

from mrts.scene.scene import FORCE, MOMENT
from mrts.viewer.panel import arrows_html, bars_html
from mrts.viewer.player_state import Bar, PlayerState
from mrts.viewer.scene import ViewerScene
from mrts.viewer.workbench.answer import Answer


class Readings:
    """The numbers of the moment that is shown."""

    def __init__(self, gui: viser.GuiApi, scene: ViewerScene) -> None:
        self._scene = scene
        with gui.add_folder("Nearest limits, at most"):
            self._nearest = gui.add_html("")
        with gui.add_folder("Joint torques"):
            self._torques = gui.add_html("")
        with gui.add_folder("Contact wrenches on the object, base axes"):
            self._wrenches, self._arrows = gui.add_html(""), gui.add_html("")
        with gui.add_folder("Joint velocities", expand_by_default=False):
            self._velocities = gui.add_html("")

    def show_answer(self, answer: Answer) -> None:
        """Show the limits that are nearest, and say what the arrows mean."""
        scene = self._scene
        lengths = (1 / scene.metres_per_newton, 1 / scene.metres_per_newton_metre)
        nearest = [] if answer.state is None else answer.state.card.bars
        bars = [Bar(one.label, 100 * one.share, -inf, 100.0, "%") for one in nearest]
        self._nearest.content = bars_html("nearest", {"": bars} if bars else {})
        self._arrows.content = "" if answer.state is None else arrows_html(FORCE, lengths[0], MOMENT, lengths[1])

    def show_moment(self, state: PlayerState | None) -> None:
        """Show the numbers at the chosen sample; None empties them."""
        if state is None:
            self._torques.content = self._wrenches.content = self._velocities.content = ""
            return
        colours, bars = self._scene.colours, state.bars()
        self._torques.content = bars_html("torque", bars.pop("torque"), colours)
        self._wrenches.content = bars_html("wrench", bars.pop("wrench"), colours)
        velocities = {robot: of for robot, of in bars.pop("velocity").items() if robot != "object"}
        kept = state.result.cell.enforces_velocity_limits
        self._velocities.content = bars_html("velocity", velocities, colours, kept=kept) + "".join(
            bars_html(kind, of_kind, colours) for kind, of_kind in bars.items()
        )
