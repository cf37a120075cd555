# SPDX-License-Identifier: MIT
"""The time of a motion that is played, and the override of its speed, within all limits; needs the extra 'view'."""

from concurrent.futures import Future, ThreadPoolExecutor
from math import ceil, floor, log10

import viser

from mrts.base.errors import MrtsError
from mrts.override.speed_override import OverrideState, SpeedOverride
from mrts.override.tables import TICK
from mrts.scaling.result import ScalingResult
from mrts.scene.scene import PACES, suited_pace
from mrts.timing.result import RetimingResult
from mrts.viewer.controls import DECIMALS, Later, assign
from mrts.viewer.panel import override_html, text_html
from mrts.viewer.player_state import HeldPoses, PlayerState

READING = 0.1
"""Time between numbers while the motion plays: faster, nobody reads them [s]."""

PACE_NAMED = {name: pace for pace, name in PACES.items()}


class Playback:
    """The time of what is shown and how it goes on: a slider, Play, and an override of the planned speed with a stop.

    The override of a plan is made, in a thread of its own, when another speed than the planned one is asked for; until
    then the motion plays as planned. `add_pace` adds how fast that is.
    """

    _taken: PlayerState | HeldPoses | None = None
    _plan: ScalingResult | RetimingResult | None = None
    _made: Future[SpeedOverride] | None = None
    _state: OverrideState | None = None

    def __init__(self, gui: viser.GuiApi, duration: float, later: Later, *, start: float, visible: bool) -> None:
        self.duration, self.plays, self._toggled = duration, False, False
        self._share, self._unread, self._shown = start, 0.0, 0.0
        self._time = gui.add_slider("time [s]", 0.0, 1.0, 1.0, 0.0, visible=visible)
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY, visible=visible)
        self._play.on_click(lambda _: later(self.toggle))
        self._wanted = gui.add_slider("override [%]", 0, 100, 1, 100, visible=visible)
        self._wanted.precision = DECIMALS
        self._stop = gui.add_button("Stop", icon=viser.Icon.PLAYER_STOP, visible=visible)
        self._stop.on_click(lambda _: later(lambda: assign(self._wanted, 0)))
        self._text, self._worker = gui.add_html("", visible=visible), ThreadPoolExecutor(1, "mrts override")

    def add_pace(self, gui: viser.GuiApi) -> None:
        """Add how fast it plays to the container that is open."""
        suited = PACES[suited_pace(self.duration)]
        self._pace = gui.add_dropdown("pace", tuple(PACES.values()), initial_value=suited)

    @property
    def time(self) -> float:
        """That is to be shown [s]."""
        return self._share * self.duration

    def toggle(self) -> None:
        """Play, or stop playing."""
        self.plays, self._toggled = not self.plays, True
        self._play.label = "Pause" if self.plays else "Play"
        self._play.icon = viser.Icon.PLAYER_PAUSE if self.plays else viser.Icon.PLAYER_PLAY

    def follow(self, elapsed: float) -> tuple[bool, bool]:
        """Take over what was changed since the last call, some time ago [s], and play on.

        Returns:
            Whether another moment is to be shown, and whether its numbers are to be read too.
        """
        changed, self._toggled = self._toggled, False
        if self._time.value != self._shown:
            self._shown, changed = self._time.value, True
            self._share = min(self._shown / self.duration, 1.0)  # which was rounded
        if self.plays:
            self._unread += elapsed
            self._share = self._after(elapsed * PACE_NAMED[self._pace.value]) / self.duration
            if self._share > 1:
                self._share %= 1
        return changed or self.plays or self._toggled, changed or self._unread >= READING

    def show(self) -> None:
        """Show the time on the slider, unless a user has just moved it."""
        self._unread = 0.0
        digits = max(0, 3 - floor(log10(self.duration)))  # four tell times along the motion apart
        self._shown = set_slider(self._time, (0.0, round(self.duration, digits)), digits, self.time, self._shown)

    def take(self, shown: PlayerState | HeldPoses) -> None:
        """Turn to another motion, or to another speed of it."""
        if shown is self._taken:
            return
        self.duration = float(shown.scene.time[-1])
        self._taken, self._made, self._state = shown, None, None
        self._plan = shown.plan if isinstance(shown, PlayerState) else None
        self._wanted.disabled = self._stop.disabled = self._plan is None
        self._text.content = ""

    def _after(self, elapsed: float) -> float:
        """The time of the plan [s] when some more has gone by."""
        if self._made is None and self._plan is not None and self._wanted.value < 100:  # noqa: PLR2004 (as planned)
            self._made = self._worker.submit(SpeedOverride, self._plan)
        if self._made is None or not self._made.done():
            return self.time + elapsed
        try:
            override = self._made.result()
        except MrtsError as error:
            self._text.content = text_html("error", str(error))
            return self.time + elapsed
        state, ticks = self._state, ceil(elapsed / TICK)
        if state is None or abs(state.time - self.time) > TICK * override.duration:  # another time was chosen
            state = override.start(min(self.time, override.duration), 1.0 if state is None else state.speed)
        for _ in range(ticks):
            state = override.step(state, self._wanted.value / 100, elapsed / ticks)
        self._state, self._text.content = state, override_html(state)
        return self.time + elapsed if state.finished else state.time


def set_slider(
    slider: viser.GuiSliderHandle[float], ends: tuple[float, float], digits: int, value: float, shown: float
) -> float:
    """Give a slider other ends, decimals and another value; what is as it was is not sent again.

    A user who has moved it since `shown` was set or taken over keeps what is under the hand. What is shown now is given
    back, for the next call.
    """
    digits = max(digits, DECIMALS)
    step = 10.0**-digits
    if (slider.min, slider.max, slider.step) != (*ends, step):
        slider.min, slider.max = ends
        slider.step, slider.precision = step, digits
    if slider.value != shown:
        return shown
    value = min(max(round(value, digits), ends[0]), ends[1])
    assign(slider, value)
    return value
