# SPDX-License-Identifier: MIT
"""The viewer of a workbench, in the browser; needs the extra 'view' (viser).

Answers are found in the workbench's own thread, and taken by the one that follows the controls.
"""

import time
from collections.abc import Callable
from functools import partial
from math import sqrt
from typing import Any

import viser

from mrts.base.rigid_transform import RigidTransform
from mrts.scene.arm_meshes import Urdfs
from mrts.viewer.controls.change_controls import ChangeControls
from mrts.viewer.controls.save_controls import SaveControls
from mrts.viewer.motion_viewer import FRAME, MotionViewer
from mrts.viewer.offered_speeds import Speeds
from mrts.viewer.playback import set_slider
from mrts.viewer.player_state import PlayerState
from mrts.viewer.plots.other_result import Others
from mrts.viewer.workbench.answer import Answer
from mrts.viewer.workbench.choices import Choices
from mrts.viewer.workbench.workbench import Workbench

PATIENCE = 60.0
"""How long a script waits for answers [s]."""


class Viewer(MotionViewer):
    """The controls and the scene of a workbench.

    Args:
        server: Where.
        bench: What.
        urdfs: As in `MotionViewer`.
        warn: As there.
        others: As there.

    Attributes:
        bench: As given.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        bench: Workbench,
        urdfs: Urdfs,
        warn: Callable[[str], None],
        others: Others = (),
    ) -> None:
        super().__init__(server, bench.answer, urdfs, warn, others)
        self.bench, gui = bench, server.gui
        self._speed = gui.add_slider(
            "speed c", 0.0, 1.0, 1.0, 0.0, marks=((0.0, ""),), hint="× as fast as given", visible=not self._stands
        )
        self._shown_speed = self._speed.value
        self._add_player()
        steps = gui.add_button_group("change", ("Undo", "Redo", "Reset"))
        steps.on_click(lambda event: self._todo.put(partial(self._step_back, event.target.value)))
        self._add_texts()
        self._add_tabs()
        self._show_answer(bench.answer)

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

    def close(self) -> None:
        """Let the workbench answer nothing more."""
        self.bench.close()

    def _follow_choices(self, elapsed: float) -> None:
        news = self.bench.take()
        answers = [one for one in news if isinstance(one, Answer)]
        if answers:
            self._show_answer(answers[-1])
        self._changes.show_study()
        for one in news:
            if not isinstance(one, Answer):
                self._say(one)
        self._changes.follow(elapsed, self._speed_at, self._held())
        if self._speed.value != self._shown_speed:
            self._shown_speed = self._speed.value
            self.bench.ask(self._shown_speed)

    def _take_over(self) -> None:
        self._changes.follow(0.0, self._speed_at, self._held())

    def _computes(self) -> bool:
        return self.bench.is_asked

    def _is_outdated(self) -> bool:
        bench, shown = self.bench, self._answer
        return bench.is_asked or shown is not bench.answer or shown.choices is not bench.choices

    def _speed_at(self, choices: Choices) -> float | None:
        """The speed that other choices are played at: the first one while that is shown, and of another profile."""
        state = self.state
        if state is None or state.profile != choices.profile or state.trajectory.c == state.speeds.start:
            return None
        return state.trajectory.c

    def _held(self) -> RigidTransform:
        """The object's pose at the moment that is shown."""
        return self._scene.held_pose(self._sample)

    def _step_back(self, which: str) -> None:
        {"Undo": self.bench.undo, "Redo": self.bench.redo, "Reset": self.bench.reset}[which]()
        self._changes.show()

    def _add_changes(self, tabs: viser.GuiTabGroupHandle) -> None:
        with tabs.add_tab("Change"):
            self._changes = ChangeControls(self.server, self.bench, self._scene.size, self._todo.put)

    def _add_saving(self) -> None:
        SaveControls(self.server.gui, self.bench, self._todo.put)

    def _show_answer(self, answer: Answer) -> None:
        super()._show_answer(answer)
        if answer.state is not None:
            self._renew_speed_slider(answer.state)

    def _show_moment(self, *, read: bool) -> None:
        super()._show_moment(read=read)
        self._changes.follow_gizmo(self._held())

    def _renew_speed_slider(self, state: PlayerState) -> None:
        """Show the speed, unless a user has moved on to another."""
        speeds = state.speeds
        c = self._shown_speed if self.bench.is_asked else state.trajectory.c
        self._shown_speed = set_slider(self._speed, (speeds.lower, speeds.upper), speeds.digits, c, self._shown_speed)
        set_marks(self._speed, speeds)


def set_marks(slider: viser.GuiSliderHandle[float], speeds: Speeds) -> None:
    """Name the ends of the admissible range below a slider."""
    marks = [(sqrt(c2), name) for name, c2 in speeds.ends.items()]
    inside = [(value, name) for value, name in marks if speeds.lower <= value <= speeds.upper]
    built: Any = viser._messages  # noqa: SLF001 (viser renews marks no other way)
    slider._marks = tuple(built.GuiSliderMark(value=value, label=name) for value, name in inside)  # noqa: SLF001
