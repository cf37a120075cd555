# SPDX-License-Identifier: MIT
"""The time plots in the viewer's panel; needs the extra 'view'."""

import numpy as np
import viser

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
                self._other = PlottedMotion.of(name, done, result.range)
        self._wanted: PlayerState | None = None
        self._shown: PlottedMotion | None = None
        self._since, self._at = RENEWAL, (0.0, 0.0)

    def show_answer(self, answer: Answer) -> None:
        """Plot an answer as soon as the last plots have been seen."""
        self._wanted = answer.state
        if answer.state is None:
            self._plots.content = ""

    def show_moment(self, state: PlayerState) -> None:
        """Take the chosen sample; the cursor moves with the next step, apart from what the scene sends together."""
        if (shown := self._shown) is None:
            return
        both = (shown, self._other) if self._other else (shown,)
        longest = max(state.trajectory.duration, *(one.duration for one in both))
        farthest = max(float(one.way[-1]) for one in both)
        way = float(np.interp(state.time, shown.time, shown.way))
        self._at = state.time / longest, way / farthest if farthest > 0 else 0.0

    def step(self, elapsed: float) -> None:
        """Plot what waits.

        Args:
            elapsed: Since the last call [s].
        """
        self._since += elapsed
        self._plot()
        if (style := cursor_html(*self._at)) != self.cursor.content:
            self.cursor.content = style

    def _plot(self) -> None:
        if self._wanted is None or self._since < RENEWAL:
            return
        state, done = self._wanted, self._wanted.trajectory
        self._shown = PlottedMotion.of("shown", done, state.result.range)
        self._plots.content = plots_html(self._shown, self._other)
        self._wanted, self._since = None, 0.0
        self.show_moment(state)
