# SPDX-License-Identifier: MIT
"""How the time of what is shown goes on: its slider, Play, the pace, and a speed override; needs the extra 'view'."""

from concurrent.futures import Future, ThreadPoolExecutor
from math import ceil, floor, log10

import viser

from mrts.base.errors import MrtsError
from mrts.control.override_tables import TICK
from mrts.control.speed_override import OverrideState, SpeedOverride
from mrts.scene.scene import PACES, suited_pace
from mrts.viewer.controls import DECIMALS, Later, assign, set_slider
from mrts.viewer.panel import text_html
from mrts.viewer.player_state import PlayerState

PACE_NAMED = {name: pace for pace, name in PACES.items()}

PLANNED = 100
"""Of the knob [%]: until less is wanted nothing is computed."""


class Playback:
    """The time of what is shown and how it goes on: a slider, Play, and how fast that is.

    Attributes:
        duration: Of what is shown [s].
        plays: Whether time goes on.
    """

    def __init__(self, gui: viser.GuiApi, duration: float, later: Later, *, start: float, visible: bool) -> None:
        self.duration, self.plays = duration, False
        self._share, self._shown = start, 0.0
        self._time = gui.add_slider("time [s]", 0.0, 1.0, 1.0, 0.0, visible=visible)
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY, visible=visible)
        self._play.on_click(lambda _: later(self.toggle))
        self.knob = SpeedKnob(gui, later, visible=visible)
        suited = PACES[suited_pace(duration)]
        self._pace = gui.add_dropdown("pace", tuple(PACES.values()), initial_value=suited, visible=visible)

    @property
    def time(self) -> float:
        """That is to be shown [s]."""
        return self._share * self.duration

    def toggle(self) -> None:
        """Play, or stop playing."""
        self.plays = not self.plays
        self._play.label = "Pause" if self.plays else "Play"
        self._play.icon = viser.Icon.PLAYER_PAUSE if self.plays else viser.Icon.PLAYER_PLAY

    def follow(self, elapsed: float) -> bool:
        """Take over what was changed since the last call, some time ago [s], and play on; whether that is shown."""
        changed = self._time.value != self._shown
        if changed:
            self._shown = self._time.value
            self._share = min(self._shown / self.duration, 1.0)  # which was rounded
        if self.plays:
            self._share = self.knob.after(self.time, elapsed * PACE_NAMED[self._pace.value]) / self.duration
            if self._share > 1:
                self._share %= 1
        return changed or self.plays

    def show(self) -> None:
        """Show the time on the slider, unless a user has just moved it."""
        digits = max(0, 3 - floor(log10(self.duration)))  # four tell times along the motion apart
        self._shown = set_slider(self._time, (0.0, round(self.duration, digits)), digits, self.time, self._shown)


class SpeedKnob:
    """A slider of the wanted speed and a stop, for a motion that plays by a speed override.

    That is made in a thread of its own; until it is done the motion plays as planned.
    """

    _shown: PlayerState | None = None
    _made: Future[SpeedOverride] | None = None
    _state: OverrideState | None = None

    def __init__(self, gui: viser.GuiApi, later: Later, *, visible: bool) -> None:
        self._wanted = gui.add_slider("override [%]", 0, PLANNED, 1, PLANNED, visible=visible)
        self._wanted.precision = DECIMALS
        self._stop = gui.add_button("Stop", icon=viser.Icon.PLAYER_STOP, visible=visible)
        self._stop.on_click(lambda _: later(lambda: assign(self._wanted, 0)))
        self._text = gui.add_html(text_html("override", ""), visible=visible)
        self._worker = ThreadPoolExecutor(1, "mrts override")

    def take(self, shown: PlayerState | None) -> None:
        """Turn to another motion, or another speed of it; None, and a speed that is not admissible, plays none."""
        if shown is self._shown:
            return
        self._shown, self._made, self._state = shown, None, None
        self._wanted.disabled = self._stop.disabled = shown is None or not shown.admissible
        self._text.content = text_html("override", "")

    def after(self, time: float, elapsed: float) -> float:
        """The time of the plan [s] when some more has gone by since a time of it [s]."""
        if self._made is None and self._shown is not None and self._shown.admissible and self._wanted.value < PLANNED:
            self._made = self._worker.submit(SpeedOverride, self._shown.plan)
        if self._made is None or not self._made.done():
            return time + elapsed
        try:
            override = self._made.result()
        except MrtsError as error:
            self._text.content = text_html("error", str(error))
            return time + elapsed
        state, ticks = self._state, ceil(elapsed / TICK)
        if state is None or abs(state.time - time) > TICK * override.duration:  # another time was chosen
            state = override.start(min(time, override.duration), 1.0 if state is None else state.speed)
        for _ in range(ticks):
            state = override.step(state, self._wanted.value / PLANNED, elapsed / ticks)
        held = f", held by {state.active}" if state.active else ""
        self._text.content = text_html("override", f"{PLANNED * state.speed:.0f} % of the planned speed{held}")
        self._state = state
        return time + elapsed if state.finished and self._wanted.value > 0 else state.time
