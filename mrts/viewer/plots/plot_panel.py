# SPDX-License-Identifier: MIT
"""The time plots in the viewer's panel; needs the extra 'view'."""

import viser

from mrts.drawing.limit_shares import limit_shares
from mrts.viewer.player_state import PlayerState
from mrts.viewer.plots.other_result import Others
from mrts.viewer.plots.time_plots import PLOT_STYLE, PlottedMotion, cursor_html, plots_html
from mrts.viewer.workbench.answer import Answer

RENEWAL = 0.2
"""Time between new plots while a slider moves [s]: they are some ten thousand letters."""


class PlotPanel:
    """Plots that follow what is shown, with a cursor at its time.

    Args:
        gui: Where, in the container that is open.
        others: Results with their names; the first is compared with what is shown.

    Attributes:
        cursor: The style sheet that says where it stands.
    """

    def __init__(self, gui: viser.GuiApi, others: Others = ()) -> None:
        gui.add_html(PLOT_STYLE)
        self.cursor, self._plots = gui.add_html(""), gui.add_html("")
        self._other = None
        for name, result in others[:1]:
            if (done := result.trajectory) is not None:
                self._other = PlottedMotion(name, done.time, done.c2, result.range, limit_shares(done))
        self._wanted: PlayerState | None = None
        self._longest, self._since, self._at = 1.0, RENEWAL, 0.0

    def show_answer(self, answer: Answer) -> None:
        """Plot an answer as soon as the last plots have been seen."""
        self._wanted = answer.state
        if answer.state is None:
            self._plots.content = ""

    def show_moment(self, state: PlayerState) -> None:
        """Take the chosen sample; the cursor moves with the next step, apart from what the scene sends together."""
        self._at = state.time / max(self._longest, state.trajectory.duration)

    def step(self, elapsed: float) -> None:
        """Plot what waits.

        Args:
            elapsed: Since the last call [s].
        """
        self._since += elapsed
        self._plot()
        if (style := cursor_html(self._at)) != self.cursor.content:
            self.cursor.content = style

    def _plot(self) -> None:
        if self._wanted is None or self._since < RENEWAL:
            return
        state, done = self._wanted, self._wanted.trajectory
        shown = PlottedMotion("shown", done.time, done.c2, state.result.range, limit_shares(done))
        self._longest = max(shown.duration, self._other.duration if self._other else 0.0)
        self._plots.content = plots_html(shown, self._other)
        self._wanted, self._since = None, 0.0
        self.show_moment(state)
