# SPDX-License-Identifier: MIT
"""The viewer in the browser: scene, panel and player of a workbench or of a saved result; needs the extra 'view'.

One thread, the caller's, reads the controls forty times a second and draws what has changed, so that a fast hand on a
slider never queues up work. Answers are found in the workbench's own thread.
"""

import contextlib
import time
from collections.abc import Callable
from functools import partial
from math import sqrt
from queue import Empty, SimpleQueue
from typing import Any

import numpy as np
import viser

from mrts.base.errors import MrtsError
from mrts.scene.arm_meshes import Urdfs
from mrts.viewer.controls.change_controls import ChangeControls
from mrts.viewer.controls.save_controls import add_save_controls
from mrts.viewer.controls.view_controls import ViewControls
from mrts.viewer.offered_speeds import Speeds
from mrts.viewer.panel import (
    PANEL,
    STYLE,
    error_html,
    held_html,
    limits_html,
    moment_html,
    note_html,
    outcome_html,
    speed_html,
    verdict_html,
)
from mrts.viewer.playback import Playback, set_slider
from mrts.viewer.player_state import PlayerState
from mrts.viewer.plots.film_controls import FilmControls
from mrts.viewer.plots.other_result import OtherResult, Others
from mrts.viewer.plots.time_plots import PlotPanel
from mrts.viewer.readings import Readings
from mrts.viewer.scene import ViewerScene
from mrts.viewer.workbench.answer import Answer
from mrts.viewer.workbench.choices import Choices
from mrts.viewer.workbench.workbench import Workbench

FRAME = 1 / 40
"""Time between looks at the controls [s]: with room for late ones a motion plays at thirty frames a second."""

PATIENCE = 60.0
"""How long a script waits for answers [s]."""

FIXED = "A saved result is played at the speed it was saved with. To change something, view its cell and motion."
"""Of a panel with nothing to change."""


class Viewer:
    """The scene and the panel: the outcome, speed and time, readings, plots, changes and files.

    Args:
        server: Where.
        bench: Whose answers are shown; or the state of a saved result, of which nothing can be changed.
        urdfs: URDF and base link by robot, for their meshes; empty draws simple shapes.
        warn: Told which arm is drawn without its meshes, and why.
        others: Results to show beside it, each with its name; the plots compare with the first.

    Attributes:
        server: As given.
        bench: As given; None of a saved result.
        parts: What follows the scene and the panel, by the thread that follows the controls: nothing of it may wait.
        playback: Its time.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        bench: Workbench | PlayerState,
        urdfs: Urdfs,
        warn: Callable[[str], None],
        others: Others = (),
    ) -> None:
        self.server, self._sample = server, 0
        self.bench = bench if isinstance(bench, Workbench) else None
        answer = self._answer = bench.answer if isinstance(bench, Workbench) else Answer(Choices(), bench)
        self._stands = answer.state is None and not answer.message
        self._urdfs, self._others = urdfs, others
        self.parts: list[PlotPanel | OtherResult | FilmControls] = []
        self._readings: Readings | None = None
        self._todo: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._scene = ViewerScene(server, answer, urdfs, warn)
        gui = server.gui
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL)
        gui.add_html(STYLE)
        self._verdict, self._outcome, self._error = gui.add_html(""), "", ""
        self._changes: ChangeControls | None = None
        if self.bench is None:
            gui.add_html(note_html(FIXED))
        else:
            self._speed = gui.add_slider(
                "speed c", 0.0, 1.0, 1.0, 0.0, marks=((0.0, ""),), hint="× as fast as given", visible=not self._stands
            )
            self._shown_speed = self._speed.value
        self._add_player()
        if self.bench is not None:
            steps = gui.add_button_group("change", ("Undo", "Redo", "Reset"))
            steps.on_click(lambda event: self._todo.put(partial(self._step_back, event.target.value)))
        visible = not self._stands
        self._speed_text, self._moment_text = gui.add_html("", visible=visible), gui.add_html("", visible=visible)
        self._add_tabs()
        self._show_answer(answer)

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
            with contextlib.suppress(Empty):
                while True:
                    asked = self._todo.get_nowait()
                    try:
                        self._follow_changes(0.0)  # controls that were changed before it was asked
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

    def settle(self, patience: float = PATIENCE) -> None:
        """Step until every question is answered and shown, as scripts want it."""
        end = time.monotonic() + patience
        self.step(FRAME)
        while self._unsettled() and time.monotonic() < end:
            time.sleep(FRAME / 3)
            self.step(FRAME)
        self.step(0.0)

    def _unsettled(self) -> bool:
        return self.bench is not None and (self.bench.waits or (self._changes is not None and self._changes.unsettled))

    def close(self) -> None:
        """Let the workbench answer nothing more; the server stays."""
        if self.bench is not None:
            self.bench.close()

    def _follow_choices(self, elapsed: float) -> None:
        if (bench := self.bench) is None:
            return
        news = bench.take()
        answers = [one for one in news if isinstance(one, Answer)]
        if answers:
            self._show_answer(answers[-1])
        if self._changes is not None:
            self._changes.show_study()
        for one in news:
            if not isinstance(one, Answer):
                self._say(one)
        self._follow_changes(elapsed)
        if self._speed.value != self._shown_speed:
            self._shown_speed = self._speed.value
            bench.ask(self._shown_speed)

    def _follow_changes(self, elapsed: float) -> None:
        if self._changes is not None:
            self._changes.follow(elapsed, self._speed_at, self._scene.held_pose(self._sample))

    def _speed_at(self, choices: Choices) -> float | None:
        """The speed that other choices are played at: the first one while that is shown, and of another profile."""
        state = self.state
        if state is None or state.profile != choices.profile or state.trajectory.c == state.speeds.start:
            return None
        return state.trajectory.c

    def _step_back(self, which: str) -> None:
        if self.bench is not None and self._changes is not None:
            {"Undo": self.bench.undo, "Redo": self.bench.redo, "Reset": self.bench.reset}[which]()
            self._changes.show()

    def _renew_speed_slider(self, state: PlayerState) -> None:
        """Show the speed, unless a user has moved on to another."""
        if self.bench is None:
            return
        speeds = state.speeds
        c = self._shown_speed if self.bench.is_asked else state.trajectory.c
        self._shown_speed = set_slider(self._speed, (speeds.lower, speeds.upper), speeds.digits, c, self._shown_speed)
        set_marks(self._speed, speeds)

    def _add_player(self) -> None:
        start, state = 0.0, self.state
        if state is not None and (found := state.deciding) is not None:
            start = float(state.trajectory.time[found.sample]) / self._duration()
        self.playback = Playback(self.server.gui, self._duration, self._todo.put, start=start, visible=not self._stands)

    def _add_tabs(self) -> None:
        gui = self.server.gui
        tabs = gui.add_tab_group()
        if self._stands:
            with tabs.add_tab("Limits"):
                self._limits = gui.add_html("")
        else:
            with tabs.add_tab("Readings"):
                self._readings = Readings(gui, self._scene)
            with tabs.add_tab("Plots") as tab:
                self.parts.append(PlotPanel(gui, tab, self._others))
        if self.bench is not None:
            with tabs.add_tab("Change"):
                self._changes = ChangeControls(self.server, self.bench, self._scene.size, self._todo.put)
        with tabs.add_tab("View"):
            if not self._stands:
                self.playback.add_pace(gui)
            self._view = ViewControls(self.server, self._scene, self._todo.put)
            self.parts += [OtherResult(self.server, self._scene, *other) for other in self._others[:1]]  # more: no room
        with tabs.add_tab("Save"):
            if self.bench is not None:
                add_save_controls(gui, self.bench, self._todo.put)
            if not self._stands:
                self.parts.append(FilmControls(self.server, self._urdfs, self._others))

    def _say(self, error: MrtsError) -> None:
        self._error = error_html(str(error))

    def _show_verdict(self) -> None:
        computing = outdated = False
        if (bench := self.bench) is not None:
            computing, shown = bench.is_asked, self._answer
            outdated = computing or shown is not bench.answer or shown.choices is not bench.choices
        self._verdict.content = verdict_html(self._outcome, self._error, computing=computing, outdated=outdated)

    def _duration(self) -> float:
        answer = self._answer
        if answer.state is not None:
            return answer.state.trajectory.duration
        assert answer.held is not None  # noqa: S101 (one of the two is shown)
        return float(answer.held.time[-1])

    def _show_answer(self, answer: Answer) -> None:
        before, state = self._answer.state, answer.state
        others = answer is self._answer or state is None or before is None or state.result is not before.result
        self._error = "" if answer.error is None else error_html(str(answer.error))
        if answer.error is not None:
            return  # what was shown before stays
        self._answer = answer
        with self.server.atomic():
            if others:
                self._scene.show_answer(answer)
            self._scene.mark(None if state is None else state.deciding)
            if state is not None:
                if others:
                    self._scene.rescale(state)
                self._outcome = outcome_html(state, coarse=answer.coarse)
            elif answer.held is not None:
                self._outcome = held_html(answer.held)
                if self._stands:
                    self._limits.content = limits_html(answer.held.cell, self._scene.colours)
            self._show_verdict()
            self._speed_text.content = speed_html(state)
            if self._readings is not None:
                self._readings.show_answer(answer)
            for part in self.parts:
                part.show_answer(answer)
            self._show_moment(read=True)
        if state is not None:
            self._renew_speed_slider(state)

    def _place(self, state: PlayerState, time: float) -> float:
        """Where along the samples the picture is: at one of them, or between two while the motion plays."""
        if not self.playback.plays:
            return state.sample
        return float(np.interp(time, state.trajectory.time, np.arange(len(state.trajectory.time))))

    def _show_moment(self, *, read: bool) -> None:
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
        if self._changes is not None:
            self._changes.follow_gizmo(self._scene.held_pose(self._sample))
        if not read:
            return
        self.playback.show()
        self._moment_text.content = moment_html(answer.state)
        if self._readings is not None:
            self._readings.show_moment(answer.state)


def set_marks(slider: viser.GuiSliderHandle[float], speeds: Speeds) -> None:
    """Name the ends of the admissible range below a slider."""
    marks = [(sqrt(c2), name) for name, c2 in speeds.ends.items()]
    inside = [(value, name) for value, name in marks if speeds.lower <= value <= speeds.upper]
    built: Any = viser._messages  # noqa: SLF001 (viser renews marks no other way)
    slider._marks = tuple(built.GuiSliderMark(value=value, label=name) for value, name in inside)  # noqa: SLF001
