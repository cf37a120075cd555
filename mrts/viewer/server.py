# SPDX-License-Identifier: MIT
"""The viewer in the browser: a viser server whose controls steer a `PlayerState`; needs the extra 'view'.

One thread, the caller's, reads the controls thirty times a second and draws what has changed, so that a fast hand on a
slider never queues up work.
"""

import contextlib
import io
import socket
import time
from collections.abc import Callable, Mapping
from errno import EADDRNOTAVAIL
from math import floor, log10, sqrt
from os import strerror
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

import viser

from mrts.base.errors import InputError, MrtsError
from mrts.viewer.guard import GuardedServer
from mrts.viewer.panel import arrows_html, bars_html, error_html, moment_html, note_html, outcome_html, speed_html
from mrts.viewer.player_state import PlayerState
from mrts.viewer.scene import FORCE, MOMENT, ViewerScene

FRAME = 1 / 30
"""Time between looks at the controls [s]."""

PACES = {"real time": 1.0, "1/2": 0.5, "1/5": 0.2, "1/10": 0.1, "1/50": 0.02}
"""Playback: seconds of the motion in a second."""

SHORT = 2.0
"""A motion below this is played slower at first, so that it takes about as long [s]."""

AS_GIVEN = "as in the cell file"
CONFIGURATIONS_SHOWN = 200
"""A longer menu is no help; the best come first."""


def open_server(host: str, port: int, label: str) -> GuardedServer:
    """Start the server, guarded against other pages and other users.

    Args:
        host: Name or address of this machine to listen at.
        port: 0 takes any free one.
        label: Title of the panel.

    Raises:
        InputError: If the address is not one of this machine, the port is taken, or this viser cannot be guarded.
    """
    if not 0 <= port <= 65535:  # noqa: PLR2004 (what a port is)
        raise InputError("--port", "must be from 0 (any free one) to 65535.", value=port)
    try:  # viser would silently take another port, and wait for ever on an address that is not there
        family, _, _, _, listening = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        socket.create_server(listening[:2], family=family).close()
    except (socket.gaierror, UnicodeError):
        raise InputError("--host", "is not a name or address of this machine.", value=host) from None
    except OSError as error:
        where, value = ("--host", host) if error.errno == EADDRNOTAVAIL else ("--port", port)
        reason = strerror(error.errno or 0)
        raise InputError(where, f"cannot be listened at: {reason}. Port 0 is any free one.", value=value) from None
    with contextlib.redirect_stdout(io.StringIO()):  # viser's banner
        server = GuardedServer(host, port, label)
    if port not in {0, server.get_port()}:
        close_server(server)
        raise InputError("--port", "has just been taken. Port 0 is any free one.", value=port)
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stop the server, without a word."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


class Viewer:
    """The controls and the scene of a state.

    Args:
        server: Where.
        state: What.
        urdfs: URDF and base link by robot, for their meshes; empty draws simple shapes.
        warn: Told which arm is drawn without its meshes, and why.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        state: PlayerState,
        urdfs: Mapping[str, tuple[Path, str | None]],
        warn: Callable[[str], None],
    ) -> None:
        self._server, self._state = server, state
        self._scene = ViewerScene(server, state, urdfs, warn)
        self._todo: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._playing, self._clock, self._choice = False, 0.0, AS_GIVEN
        self._shown_speed = self._shown_time = 0.0
        server.gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        self._add_controls()
        self._add_readings()
        self._renew_speed_slider()
        self._move_time_slider()
        self._show_trajectory()

    def run(self) -> None:
        """Follow the controls until Ctrl-C."""
        last = time.monotonic()
        with contextlib.suppress(KeyboardInterrupt):
            while True:
                time.sleep(FRAME)
                now = time.monotonic()
                self.step(now - last)
                last = now

    def step(self, elapsed: float) -> None:
        """Do what the controls ask for, and play on.

        Args:
            elapsed: Since the last call [s].
        """
        try:
            with contextlib.suppress(Empty):
                while True:
                    self._todo.get_nowait()()
            self._follow_controls(elapsed)
        except MrtsError as error:
            self._message.content = error_html(str(error))

    def _follow_controls(self, elapsed: float) -> None:
        if self._menu is not None and self._menu.value != self._choice:
            self._change_configuration(self._menu)
        state, speed = self._state, self._speed.value
        sample, duration = state.sample, state.trajectory.duration
        if self._time.value != self._shown_time:
            self._clock = self._shown_time = self._time.value
        if faster := speed != self._shown_speed:
            self._shown_speed = speed
            state.choose_speed(speed)
            self._clock *= state.trajectory.duration / duration
        if self._playing:
            self._advance(elapsed)
        state.choose_time(self._clock)
        if faster:
            self._show_trajectory()
        elif state.sample != sample:
            self._show_moment()
        if faster or self._playing:
            self._move_time_slider()

    def _advance(self, elapsed: float) -> None:
        duration = self._state.trajectory.duration
        self._clock += elapsed * PACES[self._pace.value]
        if self._clock > duration and self._loop.value:
            self._clock %= duration
        elif self._clock > duration:
            self._clock = duration
            self._toggle()

    def _toggle(self) -> None:
        self._playing = not self._playing
        self._play.label = "Pause" if self._playing else "Play"
        if self._playing and self._clock >= self._state.trajectory.duration:
            self._clock = 0.0

    def _add_controls(self) -> None:
        gui = self._server.gui
        self._outcome = gui.add_html("")
        self._add_configurations()
        self._message = gui.add_html("")
        self._speed = gui.add_slider("speed c", 0.0, 1.0, 1.0, 0.0)
        self._speed_text = gui.add_html("")
        self._time = gui.add_slider("time [s]", 0.0, 1.0, 1.0, 0.0)
        self._play = gui.add_button("Play")
        self._moment_text = gui.add_html("")
        self._play.on_click(lambda _: self._todo.put(self._toggle))

    def _add_configurations(self) -> None:
        gui, fixed = self._server.gui, self._state.fixed_configuration
        self._menu: viser.GuiDropdownHandle[str] | None = None
        if fixed:
            gui.add_html(note_html(fixed))
            return
        self._rank = gui.add_button("Rank all configurations", hint="takes seconds")
        self._menu = gui.add_dropdown("configuration", (AS_GIVEN,), visible=False)
        self._rank.on_click(lambda _: self._todo.put(self._rank_configurations))

    def _rank_configurations(self) -> None:
        assert self._menu is not None  # noqa: S101 (the button comes with the menu)
        self._rank.disabled, self._rank.label = True, "Ranking …"
        try:
            self._state.rank()
            self._menu.options = (AS_GIVEN, *self._state.configuration_labels()[:CONFIGURATIONS_SHOWN])
            self._menu.visible, self._rank.visible = True, False
        finally:
            self._rank.disabled, self._rank.label = False, "Rank all configurations"

    def _change_configuration(self, menu: viser.GuiDropdownHandle[str]) -> None:
        labels = self._state.configuration_labels()
        try:
            self._state.choose_configuration(labels.index(menu.value) if menu.value != AS_GIVEN else None)
        except MrtsError:
            _assign(menu, self._choice)
            raise
        self._choice = menu.value
        self._clock = 0.0
        self._scene.rescale()
        self._renew_speed_slider()
        self._move_time_slider()
        self._show_trajectory()

    def _add_readings(self) -> None:
        gui = self._server.gui
        with gui.add_folder("Joint torques"):
            self._torques = gui.add_html("")
        with gui.add_folder("Contact wrenches on the object, base axes"):
            self._wrenches, self._arrows = gui.add_html(""), gui.add_html("")
        with gui.add_folder("Joint velocities", expand_by_default=False):
            self._velocities = gui.add_html("")
        with gui.add_folder("Playback"):
            duration = self._state.trajectory.duration
            slow_enough = (name for name, pace in PACES.items() if duration >= SHORT * pace)
            self._pace = gui.add_dropdown("pace", tuple(PACES), initial_value=next(slow_enough, [*PACES][-1]))
            self._loop = gui.add_checkbox("loop", initial_value=True)

    def _renew_speed_slider(self) -> None:
        """Marks of a slider cannot be moved, so a configuration with other ends gets another slider."""
        speeds, c = self._state.speeds, self._state.trajectory.c
        self._shown_speed = min(max(round(c, speeds.digits), speeds.lower), speeds.upper)
        marks = [(sqrt(c2), name) for name, c2 in speeds.ends.items()]
        marks += [(end, f"{end:g}") for end in (speeds.lower, speeds.upper)]
        self._speed.remove()
        self._speed = self._server.gui.add_slider(
            "speed c",
            speeds.lower,
            speeds.upper,
            speeds.step,
            self._shown_speed,
            marks=tuple(marks),
            hint="red beyond the marked ends of the admissible range",
            order=self._speed.order,
        )

    def _move_time_slider(self) -> None:
        duration = self._state.trajectory.duration
        digits = max(0, 3 - floor(log10(duration)))
        self._shown_time = round(self._clock, digits)
        _set_slider(self._time, (0.0, round(duration, digits)), digits, self._shown_time)

    def _show_trajectory(self) -> None:
        """Show all that depends on configuration and speed, and the moment."""
        scene = self._scene
        self._message.content = ""
        self._outcome.content = outcome_html(self._state)
        self._speed_text.content = speed_html(self._state)
        self._arrows.content = arrows_html(
            FORCE, 1 / scene.metres_per_newton, MOMENT, 1 / scene.metres_per_newton_metre
        )
        self._show_moment()

    def _show_moment(self) -> None:
        """Show all that depends on the time."""
        state = self._state
        with self._server.atomic():
            self._scene.update()
        self._moment_text.content = moment_html(state)
        self._torques.content = bars_html("torque", state.torque_bars())
        self._wrenches.content = bars_html("wrench", state.wrench_bars())
        further = "".join(bars_html(kind, bars) for kind, bars in state.further_bars().items())
        velocities = bars_html("velocity", state.velocity_bars(), kept=state.keeps_velocities)
        self._velocities.content = velocities + further


def _set_slider(slider: viser.GuiSliderHandle[float], ends: tuple[float, float], digits: int, value: float) -> None:
    slider.min, slider.max = ends
    slider.step, slider.precision = 10.0**-digits, digits
    _assign(slider, value)


def _assign(handle: viser.GuiInputHandle[Any], value: float | str) -> None:
    handle.value = value  # type: ignore[misc]  # viser defines the setter where mypy does not look
