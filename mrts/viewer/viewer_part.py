# SPDX-License-Identifier: MIT
"""What stands beside the scene and the panel and follows them: plots, files, comparison."""

from typing import Protocol

from mrts.viewer.player_state import PlayerState
from mrts.viewer.workbench.answer import Answer


class ViewerPart(Protocol):
    """A part of the viewer. The thread that follows the controls calls it; none of its methods may wait."""

    def show_answer(self, answer: Answer) -> None:
        """Show an answer: other choices, or another speed; its state is None where arms do not reach."""

    def show_moment(self, state: PlayerState) -> None:
        """Show the state's chosen sample."""

    def step(self, elapsed: float) -> None:
        """Do what its own controls ask for, forty times a second.

        Args:
            elapsed: Since the last call [s].
        """
