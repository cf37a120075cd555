# SPDX-License-Identifier: MIT
"""The time of a motion that is played: its slider, Play, pace and loop; needs the extra 'view'."""

from collections.abc import Callable
from math import floor, log10

import viser

from mrts.scene.scene import PACES, suited_pace
from mrts.viewer.controls.bound_control import DECIMALS, assign

PACE_NAMED = {name: pace for pace, name in PACES.items()}

READING = 0.1
"""Time between numbers while the motion plays: faster, nobody reads them [s]."""


class Playback:
    """The controls of time; `add_pace` adds two more, where they are wanted.

    Args:
        gui: Where, in the container that is open.
        duration: Of the motion as it is shown [s].
        later: Takes work for the thread that follows the controls.
        start: Where along the duration it stands first, from 0 to 1.
        visible: Whether there is anything to play.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        duration: Callable[[], float],
        later: Callable[[Callable[[], None]], None],
        *,
        start: float = 0.0,
        visible: bool = True,
    ) -> None:
        self._duration = duration
        self._playing, self._share, self._unread, self._shown = False, start, 0.0, 0.0
        self._toggled = False
        self._time = gui.add_slider("time [s]", 0.0, 1.0, 1.0, 0.0, visible=visible)
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY, visible=visible)
        self._play.on_click(lambda _: later(self.toggle))

    def add_pace(self, gui: viser.GuiApi) -> None:
        """Add how fast it plays, and whether it begins again, to the container that is open."""
        with gui.add_folder("Playback"):
            suited = PACES[suited_pace(self._duration())]
            self._pace = gui.add_dropdown("pace", tuple(PACES.values()), initial_value=suited)
            self._loop = gui.add_checkbox("loop", initial_value=True)

    @property
    def time(self) -> float:
        """That is to be shown [s]."""
        return self._share * self._duration()

    @property
    def plays(self) -> bool:
        """Whether the time goes on by itself."""
        return self._playing

    def toggle(self) -> None:
        """Play, or stop playing."""
        self._playing, self._toggled = not self._playing, True
        self._play.label = "Pause" if self._playing else "Play"
        self._play.icon = viser.Icon.PLAYER_PAUSE if self._playing else viser.Icon.PLAYER_PLAY
        if self._playing and self._share >= 1:
            self._share = 0.0

    def follow(self, elapsed: float) -> tuple[bool, bool]:
        """Take over what was changed since the last call, and play on.

        Args:
            elapsed: Since then [s].

        Returns:
            Whether another moment is to be shown, and whether its numbers are to be read too.
        """
        moved = self._time.value != self._shown
        if moved:
            self._shown = self._time.value
            self._share = min(self._shown / self._duration(), 1.0)  # which was rounded
        if self._playing:
            self._advance(elapsed)
            self._unread += elapsed
        stopped, self._toggled = self._toggled, False
        return moved or stopped or self._playing, moved or stopped or self._unread >= READING

    def show(self) -> None:
        """Show the time on the slider, unless a user has just moved it."""
        self._unread = 0.0
        duration = self._duration()
        digits = max(0, 3 - floor(log10(duration)))  # four tell times along the motion apart
        self._shown = set_slider(self._time, (0.0, round(duration, digits)), digits, self.time, self._shown)

    def _advance(self, elapsed: float) -> None:
        self._share += elapsed * PACE_NAMED[self._pace.value] / self._duration()
        if self._share > 1 and self._loop.value:
            self._share %= 1
        elif self._share > 1:
            self._share = 1.0
            self.toggle()


def set_slider(
    slider: viser.GuiSliderHandle[float], ends: tuple[float, float], digits: int, value: float, shown: float
) -> float:
    """Give a slider other ends, steps and another value; what is as it was is not sent again.

    Args:
        slider: The slider.
        ends: Multiples of a step.
        digits: Decimal places of a step, if they are more than `DECIMALS`.
        value: Rounded to a step between the ends.
        shown: Value that was set or taken over last: a user who has moved it since keeps what is under the hand.

    Returns:
        What is shown now, for the next call.
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
