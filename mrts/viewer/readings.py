# SPDX-License-Identifier: MIT
"""Bars of torques, wrenches and velocities against their limits; needs the extra 'view'."""

import viser

from mrts.scene.scene import FORCE, MOMENT
from mrts.viewer.panel import arrows_html, bars_html
from mrts.viewer.player_state import PlayerState
from mrts.viewer.scene import ViewerScene
from mrts.viewer.workbench.answer import Answer


class Readings:
    """The numbers of the moment that is shown.

    Args:
        gui: Where, in the container that is open.
        scene: Whose arrows and colours they explain.
    """

    def __init__(self, gui: viser.GuiApi, scene: ViewerScene) -> None:
        self._scene = scene
        with gui.add_folder("Joint torques"):
            self._torques = gui.add_html("")
        with gui.add_folder("Contact wrenches on the object, base axes"):
            self._wrenches, self._arrows = gui.add_html(""), gui.add_html("")
        with gui.add_folder("Joint velocities", expand_by_default=False):
            self._velocities = gui.add_html("")

    def show_answer(self, answer: Answer) -> None:
        """Say what the arrows mean."""
        scene = self._scene
        lengths = (1 / scene.metres_per_newton, 1 / scene.metres_per_newton_metre)
        self._arrows.content = "" if answer.state is None else arrows_html(FORCE, lengths[0], MOMENT, lengths[1])

    def show_moment(self, state: PlayerState | None) -> None:
        """Show the numbers at the chosen sample; None empties them."""
        if state is None:
            self._torques.content = self._wrenches.content = self._velocities.content = ""
            return
        colours = self._scene.colours
        self._torques.content = bars_html("torque", state.torque_bars(), colours)
        self._wrenches.content = bars_html("wrench", state.wrench_bars(), colours)
        further = "".join(bars_html(kind, bars, colours) for kind, bars in state.further_bars().items())
        velocities = bars_html("velocity", state.velocity_bars(), colours, kept=state.keeps_velocities)
        self._velocities.content = velocities + further
