# SPDX-License-Identifier: MIT
"""The scene, the panel, and the player of a motion, whether it can be changed or not; needs the extra 'view' (viser).

One thread, the caller's, reads the controls forty times a second and draws what has changed, so that a fast hand on a
slider never queues up work.
"""

import contextlib
import time
from collections.abc import Callable
from queue import Empty, SimpleQueue

import numpy as np
import viser

from mrts.base.errors import MrtsError
from mrts.scene.arm_meshes import Urdfs
from mrts.scene.scene import deciding_limit
from mrts.viewer.controls.view_controls import ViewControls
from mrts.viewer.panel import (
    PANEL,
    STYLE,
    error_html,
    held_html,
    moment_html,
    outcome_html,
    speed_html,
    verdict_html,
)
from mrts.viewer.playback import Playback
from mrts.viewer.player_state import PlayerState
from mrts.viewer.plots.film_controls import FilmControls
from mrts.viewer.plots.limit_table import LimitTable
from mrts.viewer.plots.other_result import Others, other_results
from mrts.viewer.plots.plot_panel import PlotPanel
from mrts.viewer.readings import Readings
from mrts.viewer.scene import ViewerScene
from mrts.viewer.viewer_part import ViewerPart
from mrts.viewer.workbench.answer import Answer
from mrts.viewer.workbench.held_poses import Unreached

FRAME = 1 / 40
"""Time between looks at the controls [s]: with room for late ones a motion plays at thirty frames a second."""

Later = Callable[[Callable[[], None]], None]
"""Takes work for the thread that follows the controls."""


class MotionViewer:
    """The scene, and what every panel has: the outcome, the time, readings, plots, and files.

    A viewer puts its own controls between these, then shows its first answer.

    Args:
        server: Where.
        answer: The first, with a motion, or where the arms are without one.
        urdfs: URDF and base link by robot, for their meshes; empty draws simple shapes.
        warn: Told which arm is drawn without its meshes, and why.
        others: Results to show beside it, each with its name; the plots compare with the first.

    Attributes:
        server: As given.
        parts: What follows the scene and the panel.
        playback: Its time.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        answer: Answer,
        urdfs: Urdfs,
        warn: Callable[[str], None],
        others: Others = (),
    ) -> None:
        self.server, self._answer, self._sample = server, answer, 0
        self._stands = answer.state is None and not isinstance(answer.held, Unreached)
        self._urdfs, self._others = urdfs, others
        self.parts: list[ViewerPart] = []
        self._readings: Readings | None = None
        self._todo: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._scene = ViewerScene(server, answer, urdfs, warn)
        gui = server.gui
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL)
        gui.add_html(STYLE)
        self._verdict, self._outcome, self._error = gui.add_html(""), "", ""

    @property
    def state(self) -> PlayerState | None:
        """What is shown; None where arms do not reach."""
        return self._answer.state

    def run(self) -> None:
        """Follow the controls until Ctrl-C."""
        last = due = time.monotonic()
        with contextlib.suppress(KeyboardInterrupt):
            while True:
                due = max(due + FRAME, time.monotonic())
                time.sleep(max(0.0, due - time.monotonic()))
                now = time.monotonic()
                self.step(now - last)
                last = now

    def step(self, elapsed: float) -> None:
        """Do what the controls ask for, show what is new, and play on.

        Args:
            elapsed: Since the last call [s].
        """
        try:
            with contextlib.suppress(Empty):
                while True:
                    asked = self._todo.get_nowait()
                    try:
                        self._take_over()  # controls that were changed before it was asked
                    finally:
                        asked()
            self._follow_choices(elapsed)
            another, read = self.playback.follow(elapsed)
            another = self._view.follow() or another
            if another:
                self._show_moment(read=read)
            self._scene.follow_windows()
            for part in self.parts:
                part.step(elapsed)
            if another:
                self.server.flush()  # viser waits up to twice a sixtieth of a second for more to send
        except MrtsError as error:
            self._say(error)
        self._show_verdict()

    def close(self) -> None:
        """Leave nothing at work; the server stays."""

    def _take_over(self) -> None:
        """Take over what a viewer's own controls were changed to."""

    def _follow_choices(self, elapsed: float) -> None:
        """Do what a viewer's own controls ask for."""

    def _add_player(self) -> None:
        found, start = None if self.state is None else deciding_limit(self.state.trajectory), 0.0
        if self.state is not None and found is not None:
            start = float(self.state.trajectory.time[found.sample]) / self._duration()
        self.playback = Playback(self.server.gui, self._duration, self._todo.put, start=start, visible=not self._stands)

    def _add_texts(self) -> None:
        gui, visible = self.server.gui, not self._stands
        self._speed_text, self._moment_text = gui.add_html("", visible=visible), gui.add_html("", visible=visible)

    def _add_tabs(self) -> None:
        gui = self.server.gui
        tabs = gui.add_tab_group()
        if self._stands:
            with tabs.add_tab("Limits"):
                self.parts.append(LimitTable(gui, self._scene.colours))
        else:
            with tabs.add_tab("Readings"):
                self._readings = Readings(gui, self._scene)
            with tabs.add_tab("Plots"):
                self.parts.append(PlotPanel(gui, self._others))
        self._add_changes(tabs)
        with tabs.add_tab("View"):
            if not self._stands:
                self.playback.add_pace(gui)
            self._view = ViewControls(self.server, self._scene, self._todo.put)
            self.parts += other_results(self.server, self._scene, self._others)
        with tabs.add_tab("Save"):
            self._add_saving()
            if not self._stands:
                self.parts.append(FilmControls(self.server, self._urdfs, self._others))

    def _add_changes(self, tabs: viser.GuiTabGroupHandle) -> None:
        """Add a tab of what can be changed."""

    def _add_saving(self) -> None:
        """Add what saves changes, in the container that is open."""

    def _say(self, error: MrtsError) -> None:
        self._error = error_html(str(error))

    def _computes(self) -> bool:
        """Whether a newer answer is on its way than what is shown."""
        return False

    def _is_outdated(self) -> bool:
        """Whether a viewer's own controls have other values than what is shown."""
        return False

    def _show_verdict(self) -> None:
        computing, outdated = self._computes(), self._is_outdated()
        self._verdict.content = verdict_html(self._outcome, self._error, computing=computing, outdated=outdated)

    def _duration(self) -> float:
        answer = self._answer
        if answer.state is not None:
            return answer.state.trajectory.duration
        assert answer.held is not None  # noqa: S101 (one of the two is shown)
        return float(answer.held.time[-1])

    def _show_answer(self, answer: Answer) -> None:
        """Show all that depends on choices and speed, and the moment."""
        others = answer is self._answer or not _is_same_outcome(answer.state, self._answer.state)
        self._error = "" if answer.error is None else error_html(str(answer.error))
        if answer.error is not None:
            return  # what was shown before stays
        self._answer = answer
        with self.server.atomic():
            if others:
                self._scene.show_answer(answer)
            if answer.state is not None:
                self._scene.mark(deciding_limit(answer.state.trajectory))
                if others:
                    self._scene.rescale(answer.state)
                self._outcome = outcome_html(answer.state, coarse=answer.coarse)
            elif answer.held is not None:
                self._outcome = held_html(answer.held)
            self._show_verdict()
            self._speed_text.content = speed_html(answer.state)
            if self._readings is not None:
                self._readings.show_answer(answer)
            for part in self.parts:
                part.show_answer(answer)
            self._show_moment(read=True)

    def _place(self, state: PlayerState, time: float) -> float:
        """Where along the samples the picture is: at one of them, or between two while the motion plays."""
        if not self.playback.plays:
            return state.sample
        return float(np.interp(time, state.trajectory.time, np.arange(len(state.trajectory.time))))

    def _show_moment(self, *, read: bool) -> None:
        """Show all that depends on the time.

        Args:
            read: Whether numbers are renewed too.
        """
        answer, at = self._answer, self.playback.time
        with self.server.atomic():
            if answer.state is not None:
                answer.state.choose_time(at)
                self._sample = answer.state.sample
                self._scene.show_moment(answer.state, self._place(answer.state, at))
                for part in self.parts:
                    part.show_moment(answer.state)
            elif answer.held is not None:
                self._sample = answer.held.nearest(at)
                self._scene.show_gap(answer.held, self._sample)
        if not read:
            return
        self.playback.show()
        self._moment_text.content = moment_html(answer.state)
        if self._readings is not None:
            self._readings.show_moment(answer.state)


def _is_same_outcome(state: PlayerState | None, other: PlayerState | None) -> bool:
    """Whether two states differ in speed and time alone."""
    return state is not None and other is not None and state.result is other.result
