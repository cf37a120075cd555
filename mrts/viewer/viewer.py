# SPDX-License-Identifier: MIT
"""The viewer in the browser: the panel and the scene of a workbench; needs the extra 'view' (viser).

One thread, the caller's, reads the controls thirty times a second, takes answers that are ready and draws what has
changed, so that a fast hand on a slider never queues up work. Answers are found in the workbench's own thread.
"""

import contextlib
import time
from collections.abc import Callable, Sequence
from functools import partial
from math import floor, log10, sqrt
from queue import Empty, SimpleQueue
from typing import Any

import viser

from mrts.base.errors import MrtsError
from mrts.base.rigid_transform import RigidTransform
from mrts.viewer.controls.bound_control import assign
from mrts.viewer.controls.change_controls import ChangeControls
from mrts.viewer.controls.save_controls import SaveControls
from mrts.viewer.controls.view_controls import ViewControls
from mrts.viewer.offered_speeds import Speeds
from mrts.viewer.panel import STYLE, error_html, moment_html, outcome_html, speed_html, unreached_html
from mrts.viewer.player_state import PlayerState
from mrts.viewer.plots.film_controls import FilmControls
from mrts.viewer.plots.other_result import Others, other_results
from mrts.viewer.plots.plot_panel import PlotPanel
from mrts.viewer.readings import Readings
from mrts.viewer.scene import ViewerScene
from mrts.viewer.scene_arms import Urdfs
from mrts.viewer.viewer_part import ViewerPart
from mrts.viewer.workbench.workbench import Answer, Workbench

FRAME = 1 / 30
"""Time between looks at the controls [s]."""

READING = 0.1
"""Time between numbers while the motion plays: faster, nobody reads them [s]."""

PACES = {"real time": 1.0, "1/2": 0.5, "1/5": 0.2, "1/10": 0.1, "1/50": 0.02}
"""Playback: seconds of the motion in a second."""

PATIENCE = 60.0
"""How long a script waits for answers [s]."""

SHORT = 2.0
"""A motion below this is played slower at first, so that it takes about as long [s]."""

PANEL = 400
"""Width of the panel [pixels]; the scene has the rest of the window."""


class Viewer:
    """The controls and the scene of a workbench.

    Args:
        server: Where.
        bench: What.
        urdfs: URDF and base link by robot, for their meshes; empty draws simple shapes.
        warn: Told which arm is drawn without its meshes, and why.
        others: Results to show beside it, each with its name; the plots compare with the first.

    Attributes:
        server: As given.
        bench: Likewise.
        parts: What follows the scene and the panel; more may be added before `run`.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        bench: Workbench,
        urdfs: Urdfs,
        warn: Callable[[str], None],
        others: Others = (),
    ) -> None:
        self.server, self.bench = server, bench
        self.parts: list[ViewerPart] = []
        self._scene = ViewerScene(server, bench.answer, urdfs, warn)
        self._todo: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._playing, self._share, self._unread = False, 0.0, 0.0
        self._shown_speed = self._shown_time = 0.0
        self._answer, self._sample = bench.answer, 0
        server.gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(PANEL)
        self._add_player()
        self._add_tabs(urdfs, others)
        self._show_answer(bench.answer)

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

    def settle(self, patience: float = PATIENCE) -> None:
        """Step until every question is answered and shown, as scripts want it.

        Args:
            patience: How long at most [s].
        """
        end = time.monotonic() + patience
        self.step(FRAME)
        while (self.bench.waits or self._changes.unsettled) and time.monotonic() < end:
            time.sleep(FRAME / 3)
            self.step(FRAME)
        self.step(0.0)

    def step(self, elapsed: float) -> None:
        """Do what the controls ask for, show what is answered, and play on.

        Args:
            elapsed: Since the last call [s].
        """
        try:
            with contextlib.suppress(Empty):
                while True:
                    self._todo.get_nowait()()
            self._take_answers()
            self._changes.follow(elapsed, self._speed_wish(), self._held())
            self._follow_player(elapsed)
            if self._view.follow():
                self._show_moment(read=False)
            self._scene.follow_windows()
            for part in self.parts:
                part.step(elapsed)
        except MrtsError as error:
            self._say(error)

    def _take_answers(self) -> None:
        news = self.bench.take()
        answers = [one for one in news if isinstance(one, Answer)]
        errors = [one for one in news if not isinstance(one, Answer)]
        if answers:
            self._show_answer(answers[-1])
        self._changes.show_study()
        for error in errors:
            self._say(error)

    def _say(self, error: MrtsError) -> None:
        self._message.content = error_html(str(error))

    def _speed_wish(self) -> float | None:
        """The speed that other choices are played at: the fastest while it is the fastest that is shown."""
        state = self.state
        return None if state is None or state.trajectory.c == state.speeds.start else state.trajectory.c

    def _held(self) -> RigidTransform:
        """The object's pose at the moment that is shown."""
        return self._scene.held_pose(self._sample)

    def _duration(self) -> float:
        answer = self._answer
        if answer.state is not None:
            return answer.state.trajectory.duration
        assert answer.unreached is not None  # noqa: S101 (one of the two is shown)
        return float(answer.unreached.time[-1])

    def _follow_player(self, elapsed: float) -> None:
        if self._speed.value != self._shown_speed:
            self._shown_speed = self._speed.value
            self.bench.ask(self._shown_speed)
        moved = self._time.value != self._shown_time
        if moved:
            self._shown_time = self._time.value
            self._share = min(self._shown_time / self._duration(), 1.0)  # which was rounded
        if self._playing:
            self._advance(elapsed)
            self._unread += elapsed
        if moved or self._playing:
            self._show_moment(read=moved or self._unread >= READING)

    def _advance(self, elapsed: float) -> None:
        self._share += elapsed * PACES[self._pace.value] / self._duration()
        if self._share > 1 and self._loop.value:
            self._share %= 1
        elif self._share > 1:
            self._share = 1.0
            self._toggle()

    def _toggle(self) -> None:
        self._playing = not self._playing
        self._play.label = "Pause" if self._playing else "Play"
        if self._playing and self._share >= 1:
            self._share = 0.0
        self._show_moment()

    def _add_player(self) -> None:
        gui = self.server.gui
        gui.add_html(STYLE)
        self._outcome, self._message = gui.add_html(""), gui.add_html("")
        self._speed = gui.add_slider("speed c", 0.0, 1.0, 1.0, 0.0, marks=((0.0, ""),), hint="× as fast as given")
        self._time = gui.add_slider("time [s]", 0.0, 1.0, 1.0, 0.0)
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY)
        self._play.on_click(lambda _: self._todo.put(self._toggle))
        steps = gui.add_button_group("change", ("Undo", "Redo", "Reset"))
        steps.on_click(lambda event: self._todo.put(partial(self._step_back, event.target.value)))
        self._speed_text, self._moment_text = gui.add_html(""), gui.add_html("")

    def _step_back(self, which: str) -> None:
        {"Undo": self.bench.undo, "Redo": self.bench.redo, "Reset": self.bench.reset}[which]()
        self._changes.show()

    def _add_tabs(self, urdfs: Urdfs, others: Others) -> None:
        gui = self.server.gui
        tabs = gui.add_tab_group()
        with tabs.add_tab("Readings"):
            self._readings = Readings(gui, self._scene)
        with tabs.add_tab("Plots"):
            self.parts.append(PlotPanel(gui, others))
        with tabs.add_tab("Change"):
            self._changes = ChangeControls(self.server, self.bench, self._scene.size, self._todo.put)
        with tabs.add_tab("View"):
            with gui.add_folder("Playback"):
                slow_enough = (name for name, pace in PACES.items() if self._duration() >= SHORT * pace)
                self._pace = gui.add_dropdown("pace", tuple(PACES), initial_value=next(slow_enough, [*PACES][-1]))
                self._loop = gui.add_checkbox("loop", initial_value=True)
            self._view = ViewControls(self.server, self._scene)
            self.parts += other_results(self.server, others)
        with tabs.add_tab("Save"):
            SaveControls(gui, self.bench, self._todo.put)
            self.parts.append(FilmControls(gui, urdfs, others))

    def _show_answer(self, answer: Answer) -> None:
        """Show all that depends on choices and speed, and the moment."""
        others = answer.choices is not self._answer.choices or answer is self._answer
        self._message.content = "" if answer.error is None else error_html(str(answer.error))
        if answer.error is not None:
            return  # what was shown before stays
        self._answer = answer
        with self.server.atomic():
            if others:
                self._scene.show_answer(answer)
            if answer.state is not None:
                if others:
                    self._scene.rescale(answer.state)
                self._renew_speed_slider(answer.state)
                self._outcome.content = outcome_html(answer.state)
                self._speed_text.content = speed_html(answer.state)
            elif answer.unreached is not None:
                self._outcome.content = unreached_html(answer.unreached)
                self._speed_text.content = ""
            self._readings.show_answer(answer)
            for part in self.parts:
                part.show_answer(answer)
            self._show_moment()

    def _show_moment(self, *, read: bool = True) -> None:
        """Show all that depends on the time.

        Args:
            read: Whether numbers are renewed too.
        """
        answer, at = self._answer, self._share * self._duration()
        with self.server.atomic():
            if answer.state is not None:
                answer.state.choose_time(at)
                self._sample = answer.state.sample
                self._scene.show_moment(answer.state)
                for part in self.parts:
                    part.show_moment(answer.state)
            elif answer.unreached is not None:
                self._sample = answer.unreached.nearest(at)
                self._scene.show_gap(answer.unreached, self._sample)
            self._changes.follow_gizmo(self._held())
        if not read:
            return
        self._unread = 0.0
        self._move_time_slider()
        self._moment_text.content = "" if answer.state is None else moment_html(answer.state)
        self._readings.show_moment(answer.state)

    def _renew_speed_slider(self, state: PlayerState) -> None:
        speeds, c = state.speeds, state.trajectory.c
        self._shown_speed = min(max(round(c, speeds.digits), speeds.lower), speeds.upper)
        marks = [(sqrt(c2), name) for name, c2 in speeds.ends.items()]
        set_slider(self._speed, (speeds.lower, speeds.upper), speeds.digits, self._shown_speed)
        set_marks(self._speed, marks, speeds)

    def _move_time_slider(self) -> None:
        duration = self._duration()
        digits = time_digits(duration)
        self._shown_time = round(self._share * duration, digits)
        set_slider(self._time, (0.0, round(duration, digits)), digits, self._shown_time)


def time_digits(duration: float) -> int:
    """Decimal places of times along a motion, four digits of which tell them apart."""
    return max(0, 3 - floor(log10(duration)))


def set_slider(slider: viser.GuiSliderHandle[float], ends: tuple[float, float], digits: int, value: float) -> None:
    """Give a slider other ends, steps and another value; what is as it was is not sent again."""
    step = 10.0**-digits
    if (slider.min, slider.max, slider.step) != (*ends, step):
        slider.min, slider.max = ends
        slider.step, slider.precision = step, digits
    assign(slider, value)


def set_marks(slider: viser.GuiSliderHandle[float], marks: Sequence[tuple[float, str]], speeds: Speeds) -> None:
    """Name the ends of the admissible range below a slider."""
    inside = [(value, name) for value, name in marks if speeds.lower <= value <= speeds.upper]
    built: Any = viser._messages  # noqa: SLF001 (viser renews marks no other way)
    slider._marks = tuple(built.GuiSliderMark(value=value, label=name) for value, name in inside)  # noqa: SLF001
