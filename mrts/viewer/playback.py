# SPDX-License-Identifier: MIT
"""The time of a motion that is played; needs the extra 'view'."""

from math import floor, log10

import viser

from mrts.scene.scene import PACES, suited_pace
from mrts.viewer.controls import DECIMALS, Later, assign

READING = 0.1
"""Time between numbers while the motion plays: faster, nobody reads them [s]."""

PACE_NAMED = {name: pace for pace, name in PACES.items()}


class Playback:
    """The time of what is shown and how it goes on: a slider, and Play; `add_pace` adds how fast that is.

    Attributes:
        duration: Of what is shown [s].
        plays: Whether time goes on.
    """

    def __init__(self, gui: viser.GuiApi, duration: float, later: Later, *, start: float, visible: bool) -> None:
        self.duration, self.plays, self._toggled = duration, False, False
        self._share, self._unread, self._shown = start, 0.0, 0.0
        self._time = gui.add_slider("time [s]", 0.0, 1.0, 1.0, 0.0, visible=visible)
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY, visible=visible)
        self._play.on_click(lambda _: later(self.toggle))

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
            self._share += elapsed * PACE_NAMED[self._pace.value] / self.duration
            if self._share > 1:
                self._share %= 1
        return changed or self.plays, changed or self._unread >= READING

    def show(self) -> None:
        """Show the time on the slider, unless a user has just moved it."""
        self._unread = 0.0
        digits = max(0, 3 - floor(log10(self.duration)))  # four tell times along the motion apart
        self._shown = set_slider(self._time, (0.0, round(self.duration, digits)), digits, self.time, self._shown)


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
