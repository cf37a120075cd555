# SPDX-License-Identifier: MIT
"""Controls of the panel that change choices, save them, or change how the scene looks; needs the extra 'view'."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import degrees, radians
from typing import Any

import numpy as np
import viser

from mrts.base.arrays import Array
from mrts.base.errors import MrtsError
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.cell_change import Changed, limit_names
from mrts.viewer.choices import Choices, Place, free_axes, moved_by, offset_of, places, save_choices
from mrts.viewer.panel import text_html
from mrts.viewer.scene import ViewerScene
from mrts.viewer.workbench import Workbench

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

NOWHERE, NO_LIMIT = "nothing", "–"
NO_FILE = "Only a cell file is written anew: this cell is from generated files, or a variant of a study."

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
        with self._gui.add_folder("Timing", visible=not bench.given.stands):
            self._add_timing()
        with self._gui.add_folder("Load"):
            self._add_load()
        with self._gui.add_folder("Limits"):
            self._add_limits()
        with self._gui.add_folder("Places"):
            self._add_places()
        self.show()

    def follow(self, speed_at: Callable[[Choices], float | None]) -> None:
        """Take over what was changed since the last call, and ask for its answer at a speed; None is the first one.

        Raises:
            InputError: If a value breaks a rule.
        """
        bench, choices = self._bench, self._bench.choices
        changed = [control for control in self._bound if control.handle.value != control.shown]
        for control in changed:
            control.shown = control.handle.value
            choices = control.apply(choices, control.shown)
        if choices is not bench.choices:
            bench.edit(choices, speed_at(choices))
        if changed:
            self.show()

    def show(self) -> None:
        """Show choices that came from elsewhere: those that were given, or of another place."""
        choices = self._bench.choices
        for control in self._bound:
            control.show(choices)
        self._rate.visible = choices.profile == "smooth"

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
        self._bind_field(profile, "profile")
        self._rate = gui.add_slider(
            "torque rate [1/s]", 1.0, FASTEST_RATE, 0.5, Choices().torque_rate, visible=False,
            hint="a multiple of the torque limit per second, for joints whose rate the cell file does not give",
        )  # fmt: skip
        self._bind_field(self._rate, "torque_rate")
        simulated = gui.add_checkbox(
            "in closed loop", initial_value=False,
            hint="the motion played by the controller of mrts simulate, on a cell that is not quite as planned",
        )  # fmt: skip
        self._bind_field(simulated, "simulated")

    def _add_load(self) -> None:
        gui, cell = self._gui, self._given.cell
        step = float(10.0 ** (np.floor(np.log10(cell.mass)) - 2))
        heaviest = float(np.ceil(HEAVIEST * cell.mass / step) * step)
        mass = gui.add_slider("mass [kg]", step, heaviest, step, cell.mass, hint="the inertia stays as it is")
        self._bind(mass, lambda now: cell.mass if now.mass is None else now.mass,
                   lambda now, value: replace(now, mass=None if value == cell.mass else value))  # fmt: skip

    def _add_limits(self) -> None:
        gui = self._gui
        groups: dict[tuple[str, str], list[Changed]] = {}
        for name in limit_names(self._given.cell):
            groups.setdefault((name[0], name[1]), []).append(name)
        for (kind, robot), names in groups.items():
            words = {"torque": "torques", "wrench": "wrenches", "contact": "contacts"}.get(kind)
            if words is not None:
                slider = gui.add_slider(f"{robot} {words} [%]", *SHARES, hint="of all these limits as they were given")
                self._bind_limits(slider, names)
        single = {f"{name[1]}/{name[2]} {name[0]}": name for group in groups.values() for name in group}
        state = self._bench.answer.state
        found = None if state is None else state.card.deciding
        first = "" if found is None else f"{found.name.robot}/{found.name.element} {found.name.kind}"
        first = first if first in single else NO_LIMIT
        menu = gui.add_dropdown("one limit", (NO_LIMIT, *single), initial_value=first, hint="at first what decides")
        chosen = [single[first]] if first in single else []
        of_single = gui.add_slider("of that limit [%]", *SHARES, disabled=not chosen)

        def choose(now: Choices, value: str) -> Choices:
            chosen[:] = [single[value]] if value in single else []
            of_single.disabled = not chosen
            return now

        self._bind(menu, lambda _: menu.value, choose)
        self._bind_limits(of_single, chosen)

    def _bind_limits(self, slider: viser.GuiSliderHandle[float], names: list[Changed]) -> None:

        def apply(now: Choices, value: float) -> Choices:
            for name in names:
                now = now.with_limit(name, value / 100)
            return now

        self._bind(slider, lambda now: round(100 * now.limits.get(names[0], 1.0), DECIMALS) if names else 100.0, apply)

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
            self._bind_offset(slider, "xyz".index(axis), is_turn=False)
        for axis in about:
            slider = self._gui.add_slider(f"about {axis} [°]", -TURNED, TURNED, 0.5, 0.0, visible=False)
            self._bind_offset(slider, "xyz".index(axis), is_turn=True)
        offsets += self._bound[first:]

    def _bind_offset(self, slider: viser.GuiSliderHandle[float], axis: int, *, is_turn: bool) -> None:
        def offset(now: Choices, place: Place) -> tuple[RigidTransform, Array, Array]:
            """Where a place was given, and how far it is from there."""
            start = place.given(self._given)
            return start, *offset_of(now.poses.get(place, start), start)

        def read(now: Choices) -> float:
            if self._place is None:
                return 0.0
            _, shift, turn = offset(now, self._place)
            value = degrees(turn[axis]) if is_turn else 1000 * shift[axis]
            return round(float(np.clip(value, slider.min, slider.max)), DECIMALS)

        def apply(now: Choices, value: float) -> Choices:
            if self._place is None:
                return now
            start, shift, turn = offset(now, self._place)
            (turn if is_turn else shift)[axis] = radians(value) if is_turn else value / 1000
            return now.with_pose(self._place, moved_by(start, shift, turn))

        self._bind(slider, read, apply)


def add_save_controls(gui: viser.GuiApi, bench: Workbench, later: Later) -> None:
    """Add names of the files, and the button that writes them, to the container that is open."""
    with gui.add_folder("Save as"):
        if bench.given.cell_path is None:
            gui.add_html(text_html("note", NO_FILE))
            return
        gui.add_html(text_html("note", f"Into {bench.given.cell_path.resolve().parent}"))
        cell = gui.add_text("cell file", "changed_cell.yaml")
        described = bench.given.description is not None
        motion = gui.add_text("motion file", "changed_motion.yaml" if described else "", visible=described)
        overwrite = gui.add_checkbox("replace files", initial_value=False)
        button = gui.add_button("Save")
        said = gui.add_html("")

    def save() -> None:
        choices = bench.choices
        try:
            paths, remark = save_choices(bench.given, choices, cell.value, motion.value, overwrite=overwrite.value)
        except MrtsError as error:
            said.content = text_html("error", str(error))
            return
        assign(overwrite, value=False)
        names = " and ".join(path.name for path in paths)
        changed = ", ".join(choices.edited()) or "nothing was changed"
        said.content = text_html("saved", f"Saved {names} ({changed}). {remark}")

    button.on_click(lambda _: later(save))


def add_view_controls(gui: viser.GuiApi, scene: ViewerScene, later: Later) -> None:
    """Add the colours of the page, and where the scene is seen from, to the container that is open."""

    def darken(*, on: bool) -> None:
        configure_theme(gui, dark=on)
        scene.darken(on=on)

    def fit(event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
        if event.client is not None:
            later(partial(scene.fit, event.client))

    dark = gui.add_checkbox("dark", initial_value=False)
    dark.on_update(lambda event: later(partial(darken, on=event.target.value)))
    gui.add_button("Show the whole cell").on_click(fit)


def configure_theme(gui: viser.GuiApi, *, dark: bool = False) -> None:
    """The panel's width and colours, without viser's own buttons."""
    gui.configure_theme(control_width="large", dark_mode=dark, show_logo=False, show_share_button=False)
