# SPDX-License-Identifier: MIT
"""The limits of a cell that is looked at without a motion; needs the extra 'view'."""

from collections.abc import Mapping

import viser

from mrts.scene.scene import Rgb
from mrts.viewer.panel import limits_html
from mrts.viewer.player_state import PlayerState
from mrts.viewer.workbench.answer import Answer


class LimitTable:
    """A table that follows the choices.

    Args:
        gui: Where, in the container that is open.
        colours: Of the arms, by name.
    """

    def __init__(self, gui: viser.GuiApi, colours: Mapping[str, Rgb]) -> None:
        self._colours, self._table = colours, gui.add_html("")

    def show_answer(self, answer: Answer) -> None:
        """Show the limits as they were chosen."""
        if answer.held is not None:
            self._table.content = limits_html(answer.held.cell, self._colours)

    def show_moment(self, state: PlayerState) -> None:
        """Limits stay as they are."""

    def step(self, elapsed: float) -> None:
        """It has no controls."""
