# SPDX-License-Identifier: MIT
"""The viewer in the browser: scene, panel and player of a workbench or of a saved result; needs the extra 'view'.

One thread, the caller's, reads the controls forty times a second and draws what has changed, so that a fast hand on a
slider never queues up work. Answers are found in the workbench's own thread.
"""

import contextlib
import time
from dataclasses import replace
from queue import SimpleQueue
from typing import Any

import numpy as np
import viser

from mrts.base.errors import MrtsError
from mrts.scene.arm_meshes import Warn
from mrts.viewer import panel
from mrts.viewer.controls import ChangeControls, Later, set_slider
from mrts.viewer.playback import Playback
from mrts.viewer.player_state import HeldPoses, PlayerState
from mrts.viewer.scene import ViewerScene
from mrts.viewer.time_plots import PlotPanel
from mrts.viewer.workbench import Answer, Choices, Workbench

FRAME = 1 / 40
"""Time between looks at the controls [s]: with room for late ones a motion plays at thirty frames a second."""

FIXED = "A saved result is played at the speed it was saved with. To change something, view its cell and motion."
"""Of a panel with nothing to change."""


class Viewer:
    """The scene and the panel: the outcome, speed and time, limits and changes.

    It shows the answers of a workbench, or the state of a saved result, of which nothing can be changed: `bench` is
    None then, and `plots` are where a cell is looked at without a motion. `shown` is what is drawn.
    """

    def __init__(self, server: viser.ViserServer, bench: Workbench | PlayerState, warn: Warn) -> None:
        self.server = server
        self.bench = bench if isinstance(bench, Workbench) else None
        answer = self._answer = bench.answer if isinstance(bench, Workbench) else Answer(Choices(), bench)
        assert not isinstance(answer.shown, MrtsError)  # noqa: S101 (a workbench begins with something to show)
        self.shown, self.sample = answer.shown, 0
        stands = isinstance(answer.shown, HeldPoses) and not answer.shown.message
        self._todo: SimpleQueue[Any] = SimpleQueue()
        later, gui = self._todo.put, server.gui
        self._scene = ViewerScene(server, answer.shown.scene, warn)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(panel.PANEL)
        gui.add_html(panel.STYLE)
        self._verdict, self._outcome, self._error = gui.add_html(""), "", ""
        if self.bench is None:
            gui.add_html(panel.text_html("note", FIXED))
        else:
            self._speed = gui.add_slider("speed c", 0.0, 1.0, 1.0, 0.0, hint="× as fast as given", visible=not stands)
            self._shown_speed = self._speed.value
        duration = float(answer.shown.scene.time[-1])
        found = None if answer.state is None else answer.state.card.deciding
        start = 0.0 if found is None else float(answer.shown.scene.time[found.sample]) / duration
        self.playback = Playback(gui, duration, later, start=start, visible=not stands)
        self._speed_text = gui.add_html("", visible=not stands)
        self._add_tabs(later, stands=stands)
        self._show_answer(answer)

    def _add_tabs(self, later: Later, *, stands: bool) -> None:
        gui = self.server.gui
        tabs = gui.add_tab_group()
        self.plots = self._changes = None
        if not stands:
            with tabs.add_tab("Limits") as tab:
                self._nearest, self._arrows = gui.add_html(""), gui.add_html("")
                self.plots = PlotPanel(gui, tab)
        if self.bench is not None:
            with tabs.add_tab("Change"):
                self._changes = ChangeControls(gui, self.bench, later)
        self._dark = gui.add_checkbox("dark", initial_value=False)
        self._dark.on_update(lambda _: later(self._show_theme))
        self._show_theme()

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
        """Do what the controls ask for, show what is new, and play on."""
        try:
            another = not self._todo.empty()
            while not self._todo.empty():
                self._follow_changes()  # controls that were changed before it was asked
                self._todo.get()()
            self._follow_choices()
            another = self.playback.follow(elapsed) or another
            if another:
                self._show_moment()
            if self.plots is not None:
                self.plots.step(elapsed)
            if another:
                self.server.flush()  # viser waits up to twice a sixtieth of a second for more to send
        except MrtsError as error:
            self._error = panel.text_html("error", str(error))
        self._show_verdict()

    def close(self) -> None:
        """Let the workbench answer nothing more; the server stays."""
        if self.bench is not None:
            self.bench.close()

    def _follow_choices(self) -> None:
        if (bench := self.bench) is None:
            return
        for answer in bench.take():
            self._show_answer(answer)
        self._follow_changes()
        if self._speed.value != self._shown_speed:
            self._shown_speed = c = self._speed.value
            state = self.state
            first = state is not None and state.speeds.c2(c) == state.speeds.c2(state.speeds.start)
            bench.edit(replace(bench.choices, speed=None if first else c))

    def _follow_changes(self) -> None:
        if self._changes is not None:
            self._changes.follow()

    def _show_theme(self) -> None:
        """A dark page or a light one, without viser's own buttons."""
        dark = self._dark.value
        self.server.gui.configure_theme(control_width="large", dark_mode=dark, show_logo=False, show_share_button=False)
        self._scene.darken(on=dark)

    def _show_verdict(self) -> None:
        computing = outdated = False
        if (bench := self.bench) is not None:
            computing, outdated = bench.is_asked, self._answer.choices is not bench.choices
        self._verdict.content = panel.verdict_html(self._outcome, self._error, computing=computing, outdated=outdated)

    def _show_answer(self, answer: Answer) -> None:
        before, state, shown = self._answer.state, answer.state, answer.shown
        if isinstance(shown, MrtsError):
            self._error = panel.text_html("error", str(shown))
            return  # what was shown before stays
        others = answer is self._answer or state is None or before is None or state.result is not before.result
        self._answer, self.shown, self._error = answer, shown, ""
        self.playback.duration = float(shown.scene.time[-1])
        self.playback.knob.take(state)
        with self.server.atomic():
            self._scene.show(shown.scene, anew=others)
            self._scene.mark(None if state is None else state.card.deciding)
            near, said = answer.clearance()
            if state is not None:
                told = panel.outcome_html(state), panel.simulation_html(answer.simulation)
                self._outcome = "".join([*told, panel.collisions_html(near, said)])
            elif isinstance(shown, HeldPoses):
                self._outcome = panel.held_html(shown)
            self._show_verdict()
            self._speed_text.content = panel.speed_html(state)
            if self.plots is not None:
                scene = self._scene
                self._nearest.content = "" if state is None else panel.nearest_html(state.card)
                self._arrows.content = panel.arrows_html(scene.metres_per_newton, scene.metres_per_newton_metre)
                self.plots.show(answer)
            self._show_moment()
        if self._changes is not None:
            self._changes.tell(answer.choices)
        if state is not None and self.bench is not None:  # unless a user has moved on to another speed
            speeds, chosen = state.speeds, self._shown_speed
            c = chosen if self.bench.is_asked else state.trajectory.c
            self._shown_speed = set_slider(self._speed, (speeds.lower, speeds.upper), speeds.digits, c, chosen)

    def _show_moment(self) -> None:
        shown, scene, at = self.shown, self.shown.scene, self.playback.time
        self.sample = int(np.argmin(np.abs(scene.time - at)))
        with self.server.atomic():
            if isinstance(shown, HeldPoses):
                self._scene.show_moment(self.sample, shown)
            else:
                self._scene.show_moment(scene.place(at) if self.playback.plays else self.sample)
        if self.plots is not None:
            self.plots.at = float(scene.time[self.sample] / scene.time[-1])
        self.playback.show()
