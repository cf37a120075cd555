# SPDX-License-Identifier: MIT
"""The knob of the speed at which a motion plays, within all limits; needs the extra 'view'."""

from concurrent.futures import Future, ThreadPoolExecutor
from math import ceil

import viser

from mrts.base.errors import MrtsError
from mrts.override.speed_override import OverrideState, SpeedOverride
from mrts.override.tables import TICK
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory
from mrts.timing.result import RetimingResult
from mrts.viewer.controls import DECIMALS, Later, assign
from mrts.viewer.panel import override_html, text_html
from mrts.viewer.player_state import PlayerState


class SpeedKnob:
    """A slider and a stop.

    The override of a plan is made, in a thread of its own, when another speed than the planned one is asked for; until
    then the motion plays as planned.
    """

    _trajectory: ScaledTrajectory | None = None
    _plan: ScalingResult | RetimingResult | None = None
    _made: Future[SpeedOverride] | None = None
    _state: OverrideState | None = None

    def __init__(self, gui: viser.GuiApi, later: Later, *, visible: bool) -> None:
        self._wanted = gui.add_slider("override [%]", 0, 100, 1, 100, visible=visible)
        self._wanted.precision = DECIMALS
        self._stop = gui.add_button("Stop", icon=viser.Icon.PLAYER_STOP, visible=visible)
        self._stop.on_click(lambda _: later(lambda: assign(self._wanted, 0)))
        self._text, self._worker = gui.add_html("", visible=visible), ThreadPoolExecutor(1, "mrts override")

    def take(self, shown: PlayerState | None) -> None:
        """Turn to another motion, or another speed of it; None where arms do not reach."""
        trajectory = None if shown is None else shown.trajectory
        if trajectory is self._trajectory:
            return
        self._trajectory, self._made, self._state = trajectory, None, None
        self._plan = None if shown is None else shown.plan
        self._wanted.disabled = self._stop.disabled = self._plan is None
        self._text.content = ""

    def after(self, time: float, elapsed: float) -> float:
        """The time of the plan [s] when some more has gone by since a time of it [s]."""
        if self._made is None and self._plan is not None and self._wanted.value < 100:  # noqa: PLR2004 (as planned)
            self._made = self._worker.submit(SpeedOverride, self._plan)
        if self._made is None or not self._made.done():
            return time + elapsed
        try:
            override = self._made.result()
        except MrtsError as error:
            self._text.content = text_html("error", str(error))
            return time + elapsed
        return self._played(override, time, elapsed)

    def _played(self, override: SpeedOverride, time: float, elapsed: float) -> float:
        state, ticks = self._state, ceil(elapsed / TICK)
        if state is None or abs(state.time - time) > TICK * override.duration:  # another time was chosen
            state = override.start(min(time, override.duration), 1.0 if state is None else state.speed)
        for _ in range(ticks):
            state = override.step(state, self._wanted.value / 100, elapsed / ticks)
        self._state, self._text.content = state, override_html(state)
        return time + elapsed if state.finished else state.time
