# SPDX-License-Identifier: MIT
"""Controls of the panel that change choices; needs the extra 'view'."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import radians
from typing import Any

import numpy as np
import viser

from mrts.cell.cell_change import Changed, free_axes, limit_places
from mrts.viewer.panel import keys_html
from mrts.viewer.workbench import Choices, Place, Workbench, changed_keys, places

DECIMALS = 2
"""Least decimal places of a number field: with those of a step of 1, none, a page drops the point from a typed 1.5."""

HEAVIEST = 4.0
"""Largest mass on offer, as a multiple of the given one."""

SHARES = (5.0, 300.0, 1.0, 100.0)
"""Of a limit on offer [% of the given one]: least, largest, step, first."""

FARTHEST, TURNED = 500.0, 180.0
"""Largest shift [mm] and turn [°] of a place."""

FASTEST_RATE = 50.0
"""Largest torque rate on offer, a multiple of the torque limit per second [1/s]."""

NOWHERE = "nothing"

Later = Callable[[Callable[[], None]], None]
"""Takes work for the thread that follows the controls."""


@dataclass(eq=False)
class BoundControl:
    """A control whose value is part of the choices; `shown` is the value that was taken over last."""

    handle: viser.GuiInputHandle[Any]
    read: Callable[[Choices], Any]
    apply: Callable[[Choices, Any], Choices]
    shown: Any

    def show(self, choices: Choices) -> None:
        """Show the value for some choices; what a user is dragging already has it."""
        value = self.read(choices)
        if value != self.shown:
            assign(self.handle, value)
            self.shown = self.handle.value


def assign(handle: viser.GuiInputHandle[Any], value: object) -> None:
    """Set a control's value."""
    handle.value = value  # type: ignore[misc]  # viser defines the setter where mypy does not look


class ChangeControls:
    """All that changes a workbench's choices, in the container that is open."""

    def __init__(self, gui: viser.GuiApi, bench: Workbench, later: Later) -> None:
        self._bench, self._given, self._gui = bench, bench.given, gui
        self._place: Place | None = None
        self._bound: list[BoundControl] = []
        self._gui.add_button("Reset all changes").on_click(lambda _: later(self._reset))
        with self._gui.add_folder("Timing", visible=bench.given.motion is not None):
            self._add_timing()
        with self._gui.add_folder("Load"):
            self._add_load()
        with self._gui.add_folder("Limits"):
            self._add_limits()
        with self._gui.add_folder("Places"):
            self._add_places()
        self._keys = self._gui.add_html("")
        self.show()

    def follow(self) -> None:
        """Take over what was changed since the last call, and ask for its answer.

        Raises:
            InputError: If a value breaks a rule.
        """
        bench, choices = self._bench, self._bench.choices
        changed = [control for control in self._bound if control.handle.value != control.shown]
        for control in changed:
            control.shown = control.handle.value
            choices = control.apply(choices, control.shown)
        if choices is not bench.choices:
            bench.edit(choices)
        if changed:
            self.show()

    def show(self) -> None:
        """Show choices that came from elsewhere: those that were given, or of another place."""
        choices = self._bench.choices
        for control in self._bound:
            control.show(choices)
        self._rate.visible = choices.profile == "smooth"

    def tell(self, choices: Choices) -> None:
        """Say what was changed, as files have it."""
        self._keys.content = keys_html(changed_keys(self._given, choices))

    def _reset(self) -> None:
        self._bench.edit(Choices())
        self.show()

    def _bind(
        self,
        handle: viser.GuiInputHandle[Any],
        read: Callable[[Choices], Any],
        apply: Callable[[Choices, Any], Choices],
    ) -> None:
        if isinstance(handle, viser.GuiSliderHandle):
            handle.precision = max(handle.precision, DECIMALS)
        self._bound.append(BoundControl(handle, read, apply, handle.value))

    def _bind_field(self, handle: viser.GuiInputHandle[Any], name: str) -> None:
        self._bind(handle, lambda now: getattr(now, name), lambda now, value: replace(now, **{name: value}))

    def _add_timing(self) -> None:
        gui = self._gui
        profile = gui.add_dropdown(
            "profile", ("constant", "optimal", "smooth"),
            hint="one factor of speed, the fastest timing r(t), or the fastest whose torques change at limited rates",
        )  # fmt: skip
        self._bind(profile, lambda now: now.profile, lambda now, value: replace(now, profile=value, speed=None))
        self._rate = gui.add_slider(
            "torque rate [1/s]", 1.0, FASTEST_RATE, 0.5, Choices().torque_rate, visible=False,
            hint="a multiple of the torque limit per second, for joints whose rate the cell file does not give",
        )  # fmt: skip
        self._bind_field(self._rate, "torque_rate")
        hint = "the motion played by the controller of mrts simulate, on a cell that is not quite as planned"
        self._bind_field(gui.add_checkbox("in closed loop", initial_value=False, hint=hint), "simulated")

    def _add_load(self) -> None:
        gui, cell = self._gui, self._given.cell
        step = float(10.0 ** (np.floor(np.log10(cell.mass)) - 2))
        heaviest = float(np.ceil(HEAVIEST * cell.mass / step) * step)
        mass = gui.add_slider("mass [kg]", step, heaviest, step, cell.mass, hint="the inertia stays as it is")
        self._bind(mass, lambda now: cell.mass if now.mass is None else now.mass,
                   lambda now, value: replace(now, mass=None if value == cell.mass else value))  # fmt: skip

    def _add_limits(self) -> None:
        gui = self._gui
        groups: dict[str, list[Changed]] = {}
        single: dict[str, list[Changed]] = {}
        for name in limit_places(self._given.cell):
            kind, robot, element = name
            if words := {"torque": "torques", "wrench": "wrenches", "contact": "contacts"}.get(kind):
                groups.setdefault(f"{robot}: all {words}", []).append(name)
            single[f"{robot}/{element} {kind}"] = [name]
        on_offer = groups | single
        state = self._bench.answer.state
        found = None if state is None else state.card.deciding
        first = "" if found is None else f"{found.name.robot}/{found.name.element} {found.name.kind}"
        first = first if first in on_offer else next(iter(on_offer), NOWHERE)
        menu = gui.add_dropdown("limit", (*on_offer, NOWHERE), initial_value=first, hint="at first what decides")
        chosen = list(on_offer.get(first, []))
        slider = gui.add_slider("of that limit [%]", *SHARES, hint="of what it was given as")

        def choose(now: Choices, value: str) -> Choices:
            chosen[:] = on_offer.get(value, [])
            return now

        def read(now: Choices) -> float:
            return round(100 * now.limits.get(chosen[0], 1.0), DECIMALS) if chosen else 100.0

        def apply(now: Choices, value: float) -> Choices:
            for name in chosen:
                now = now.with_limit(name, value / 100)
            return now

        self._bind(menu, lambda _: menu.value, choose)
        self._bind(slider, read, apply)

    def _add_places(self) -> None:
        found = {str(place): place for place in places(self._given)}
        menu = self._gui.add_dropdown("move", (NOWHERE, *found), hint="from where it was given")
        offsets: list[BoundControl] = []

        def choose(now: Choices, value: str) -> Choices:
            self._place = found.get(value)
            for control in offsets:
                control.handle.visible = value in found
            return now

        self._bind(menu, lambda _: menu.value, choose)
        first = len(self._bound)
        along, about = free_axes(self._given.cell)
        for axis in along:
            slider = self._gui.add_slider(f"along {axis} [mm]", -FARTHEST, FARTHEST, 1.0, 0.0, visible=False)
            self._bind_offset(slider, "xyz".index(axis), 1e-3)
        for axis in about:
            slider = self._gui.add_slider(f"about {axis} [°]", -TURNED, TURNED, 0.5, 0.0, visible=False)
            self._bind_offset(slider, 3 + "xyz".index(axis), radians(1))
        offsets += self._bound[first:]

    def _bind_offset(self, slider: viser.GuiSliderHandle[float], number: int, unit: float) -> None:

        def read(now: Choices) -> float:
            return 0.0 if self._place is None else round(now.offset(self._place)[number] / unit, DECIMALS)

        def apply(now: Choices, value: float) -> Choices:
            if self._place is None:
                return now
            offset = now.offset(self._place).copy()
            offset[number] = value * unit
            return now.with_offset(self._place, offset)

        self._bind(slider, read, apply)


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
