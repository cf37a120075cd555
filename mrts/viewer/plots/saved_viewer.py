# SPDX-License-Identifier: MIT
"""The viewer of a saved result: the scene, the plots and the player, with nothing to change; needs the extra 'view'."""

import contextlib
import time
from collections.abc import Callable
from queue import Empty, SimpleQueue

import viser

from mrts.viewer.controls.view_controls import ViewControls
from mrts.viewer.panel import STYLE, moment_html, note_html, outcome_html, speed_html
from mrts.viewer.plots.film_controls import FilmControls
from mrts.viewer.plots.other_result import Others, other_results
from mrts.viewer.plots.plot_panel import PlotPanel
from mrts.viewer.plots.saved_state import SavedState
from mrts.viewer.readings import Readings
from mrts.viewer.scene import ViewerScene
from mrts.viewer.viewer import FRAME, PACES, PANEL, READING, SHORT, set_slider, time_digits
from mrts.viewer.viewer_part import ViewerPart
from mrts.viewer.workbench.choices import Choices
from mrts.viewer.workbench.workbench import Answer

FIXED = "A saved result is played at the speed it was saved with. To change something, view its cell and motion."


class SavedViewer:
    """The controls and the scene of a saved result.

    Args:
        server: Where.
        state: What.
        warn: Told what cannot be drawn.
        others: As in `Viewer`.

    Attributes:
        parts: As in `Viewer`.
    """

    def __init__(
        self, server: viser.ViserServer, state: SavedState, warn: Callable[[str], None], others: Others = ()
    ) -> None:
        self._state, self._answer = state, Answer(Choices(), state)
        self._scene = ViewerScene(server, self._answer, {}, warn)
        self._todo: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._playing, self._clock, self._unread, self._shown_time = False, 0.0, 0.0, 0.0
        self._server, gui = server, server.gui
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL)
        gui.add_html(STYLE)
        gui.add_html(outcome_html(state))
        gui.add_html(note_html(FIXED))
        self._time = gui.add_slider("time [s]", 0.0, 1.0, 1.0, 0.0)
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY)
        self._play.on_click(lambda _: self._todo.put(self.toggle))
        gui.add_html(speed_html(state))
        self._moment_text = gui.add_html("")
        self.parts = self._tabs(server, others)
        self._scene.rescale(state)
        self._readings.show_answer(self._answer)
        for part in self.parts:
            part.show_answer(self._answer)
        self._show_moment(read=True)

    def _tabs(self, server: viser.ViserServer, others: Others) -> list[ViewerPart]:
        gui, duration = server.gui, self._state.trajectory.duration
        tabs = gui.add_tab_group()
        with tabs.add_tab("Readings"):
            self._readings = Readings(gui, self._scene)
        with tabs.add_tab("Plots"):
            plots = PlotPanel(gui, others)
        with tabs.add_tab("View"):
            with gui.add_folder("Playback"):
                slow_enough = (name for name, pace in PACES.items() if duration >= SHORT * pace)
                self._pace = gui.add_dropdown("pace", tuple(PACES), initial_value=next(slow_enough, [*PACES][-1]))
                self._loop = gui.add_checkbox("loop", initial_value=True)
            self._view = ViewControls(server, self._scene)
            beside = other_results(server, others)
        with tabs.add_tab("Save"):
            return [plots, *beside, FilmControls(gui, {}, others)]

    def run(self) -> None:
        """Follow the controls until Ctrl-C."""
        last = time.monotonic()
        with contextlib.suppress(KeyboardInterrupt):
            while True:
                time.sleep(FRAME)
                now = time.monotonic()
                self.step(now - last)
                last = now

    def step(self, elapsed: float) -> None:
        """Do what the controls ask for, and play on.

        Args:
            elapsed: Since the last call [s].
        """
        with contextlib.suppress(Empty):
            while True:
                self._todo.get_nowait()()
        moved = self._time.value != self._shown_time
        if moved:
            self._clock = self._shown_time = self._time.value
        if self._playing:
            self._advance(elapsed)
            self._unread += elapsed
        if moved or self._playing:
            self._show_moment(read=moved or self._unread >= READING)
        self._view.follow()
        self._scene.follow_windows()
        for part in self.parts:
            part.step(elapsed)

    def _advance(self, elapsed: float) -> None:
        duration = self._state.trajectory.duration
        self._clock += elapsed * PACES[self._pace.value]
        if self._clock > duration and self._loop.value:
            self._clock %= duration
        elif self._clock > duration:
            self._clock = duration
            self.toggle()

    def toggle(self) -> None:
        """Play, or stop playing."""
        self._playing = not self._playing
        self._play.label = "Pause" if self._playing else "Play"
        if self._playing and self._clock >= self._state.trajectory.duration:
            self._clock = 0.0

    def _show_moment(self, *, read: bool) -> None:
        state, duration = self._state, self._state.trajectory.duration
        state.choose_time(self._clock)
        with self._server.atomic():
            self._scene.show_moment(state)
            for part in self.parts:
                part.show_moment(state)
        if not read:
            return
        self._unread = 0.0
        digits = time_digits(duration)
        self._shown_time = round(self._clock, digits)
        set_slider(self._time, (0.0, round(duration, digits)), digits, self._shown_time)
        self._moment_text.content = moment_html(state)
        self._readings.show_moment(state)
