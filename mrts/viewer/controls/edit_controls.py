# SPDX-License-Identifier: MIT
"""Controls that change the cell, the motion and its timing, bound to the choices of a workbench; extra 'view'."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from math import degrees, radians
from types import MappingProxyType
from typing import Any

import numpy as np
import viser

from mrts.base.load_box import FACTORS, UNITS, LoadBox
from mrts.cell.cell_change import Changed, limit_names
from mrts.viewer.controls.bound_control import DECIMALS, BoundControl
from mrts.viewer.controls.places import Place, free_axes, moved_by, offset_of
from mrts.viewer.workbench.choices import Choices, Given

HEAVIEST = 4.0
"""Largest mass on offer, as a multiple of the given one."""

LARGEST_SHARE = 300.0
"""Largest limit on offer [% of the given one]."""

FARTHEST, TURNED = 500.0, 180.0
"""Largest shift [mm] and turn [°] of a place on the sliders; the gizmo goes farther."""

FASTEST_RATE = 50.0
"""Largest torque rate on offer, a multiple of the torque limit per second [1/s]."""

CORNERS_SHOWN = 64
ALL_LOADS = "every load of the box"
NO_LIMIT = "–"


class EditControls:
    """The controls, in folders where the panel is at the moment.

    Attributes:
        place: What the sliders of `add_offsets` move; None hides them.
    """

    def __init__(self, gui: viser.GuiApi, given: Given) -> None:
        self._gui, self._given = gui, given
        self._bound: list[BoundControl] = []
        self._offsets: list[BoundControl] = []
        self.place: Place | None = None
        with gui.add_folder("Timing", visible=not given.stands):
            self._add_timing()
        with gui.add_folder("Load"):
            self._add_load()
        with gui.add_folder("Limits"):
            self._add_limits()

    def changed(self, choices: Choices) -> tuple[Choices, str] | None:
        """Choices as a user changed them since the last call, and which control did it; None if none did.

        Raises:
            InputError: If a value breaks a rule.
        """
        name = ""
        for control in self._bound:
            other = control.changed(choices)
            if other is not None:
                choices, name = other, str(self.place) if control in self._offsets else control.name
        return (choices, name) if name else None

    def show(self, choices: Choices) -> None:
        """Show choices that came from elsewhere: undone, or by the gizmo."""
        for control in self._bound:
            control.show(choices)
        self._rate.visible = choices.profile == "smooth"
        for slider in self._shares:
            slider.visible = choices.shares is not None

    def add_offsets(self) -> None:
        """Add sliders that move the chosen place from where it was given, for numbers rather than a gizmo."""
        along, about = free_axes(self._given.cell)
        first = len(self._bound)
        for axis in along:
            handle = self._gui.add_slider(f"along {axis} [mm]", -FARTHEST, FARTHEST, 1.0, 0.0, visible=False)
            self._bind_offset(handle, "xyz".index(axis), is_turn=False)
        for axis in about:
            handle = self._gui.add_slider(f"about {axis} [°]", -TURNED, TURNED, 0.5, 0.0, visible=False)
            self._bind_offset(handle, "xyz".index(axis), is_turn=True)
        self._offsets = self._bound[first:]

    def choose(self, place: Place | None, choices: Choices) -> None:
        """Move another place, or none."""
        self.place = place
        for control in self._offsets:
            control.handle.visible = place is not None
        self.show(choices)

    def _bind_offset(self, handle: viser.GuiSliderHandle[float], axis: int, *, is_turn: bool) -> None:
        def read(now: Choices) -> float:
            if self.place is None:
                return 0.0
            shift, turn = offset_of(self.place.pose(now, self._given), self.place.given_pose(self._given))
            value = degrees(turn[axis]) if is_turn else 1000 * shift[axis]
            return round(float(np.clip(value, handle.min, handle.max)), DECIMALS)

        def apply(now: Choices, value: float) -> Choices:
            if self.place is None:
                return now
            given = self.place.given_pose(self._given)
            shift, turn = offset_of(self.place.pose(now, self._given), given)
            (turn if is_turn else shift)[axis] = radians(value) if is_turn else value / 1000
            return self.place.with_pose(now, moved_by(given, shift, turn))

        self._bind(handle.label, handle, read, apply)

    def _bind(
        self,
        name: str,
        handle: viser.GuiInputHandle[Any],
        read: Callable[[Choices], Any],
        apply: Callable[[Choices, Any], Choices],
    ) -> None:
        self._bound.append(BoundControl(name, handle, read, apply, handle.value))

    def _add_timing(self) -> None:
        gui, arms = self._gui, self._given.cell.robots
        profile = gui.add_dropdown(
            "profile", ("constant", "optimal", "smooth"),
            hint="one factor of speed, the fastest timing r(t), or the fastest whose torques change at limited rates",
        )  # fmt: skip
        self._bind("profile", profile, lambda now: now.profile, lambda now, value: replace(now, profile=value))
        self._rate = gui.add_slider(
            "torque rate [1/s]", 1.0, FASTEST_RATE, 0.5, Choices().torque_rate, visible=False,
            hint="a multiple of the torque limit per second, for joints whose rate the cell file does not give",
        )  # fmt: skip
        self._bind("torque rate", self._rate, lambda now: now.torque_rate,
                   lambda now, value: replace(now, torque_rate=value))  # fmt: skip
        self._shares: list[viser.GuiSliderHandle[float]] = []
        if len(arms) == 1:
            return
        equal = (1 / len(arms),) * len(arms)
        fixed = gui.add_checkbox(
            "fixed shares of the load", self._given.shares is not None,
            hint="each arm carries its share; otherwise redundant torques are chosen by the quadratic program",
        )  # fmt: skip
        self._bind("shares", fixed, lambda now: now.shares is not None,
                   lambda now, value: replace(now, shares=equal if value else None))  # fmt: skip
        for index, robot in enumerate(arms[:-1]):
            share = (self._given.shares or equal)[index]
            slider = gui.add_slider(f"share of {robot.name} [%]", 0.0, 100.0, 0.5, 100 * share,
                                    visible=self._given.shares is not None)  # fmt: skip
            self._shares.append(slider)
            self._bind(f"share of {robot.name}", slider, partial(_share, index, equal), partial(_with_share, index))

    def _add_load(self) -> None:
        gui, cell = self._gui, self._given.cell
        step = 10.0 ** (np.floor(np.log10(cell.mass)) - 2)
        mass = gui.add_slider(
            "mass [kg]", float(step), float(np.ceil(HEAVIEST * cell.mass / step) * step), float(step), cell.mass,
            hint="the inertia stays as it is",
        )  # fmt: skip
        self._bind("mass", mass, lambda now: cell.mass if now.mass is None else now.mass,
                   lambda now, value: replace(now, mass=None if value == cell.mass else value))  # fmt: skip
        if cell.load_box is None:
            return
        corners = _corners(cell.load_box)
        names = {text: point for text, point in corners.items() if point is not None}
        shown = {tuple(point.items()): text for text, point in names.items()}
        corner = gui.add_dropdown("load", tuple(corners), hint="one corner of the box of loads, or all of it")
        self._bind(
            "load",
            corner,
            lambda now: ALL_LOADS if now.corner is None else shown[tuple(now.corner.items())],
            lambda now, value: replace(now, corner=corners[value]),
        )

    def _add_limits(self) -> None:
        gui, cell = self._gui, self._given.cell
        groups: dict[tuple[str, str], list[Changed]] = {}
        for name in limit_names(cell):
            groups.setdefault((name[0], name[1]), []).append(name)
        for (kind, robot), names in groups.items():
            if kind not in {"torque", "wrench", "contact"}:
                continue
            words = {"torque": "torques", "wrench": "wrenches", "contact": "contacts"}[kind]
            slider = gui.add_slider(f"{robot} {words} [%]", 5.0, LARGEST_SHARE, 1.0, 100.0,
                                    hint="of all these limits as they were given")  # fmt: skip
            self._bind(f"{robot} {words}", slider, partial(_common_share, names), partial(_with_common, names))
        single = {_limit_text(name): name for group in groups.values() for name in group}
        self._single: Changed | None = None
        self._menu = gui.add_dropdown("one limit", (NO_LIMIT, *single))
        self._of_single = gui.add_slider("of that limit [%]", 5.0, LARGEST_SHARE, 1.0, 100.0, disabled=True)

        def chosen(now: Choices, value: str) -> Choices:
            self._single = single.get(value)
            self._of_single.disabled = self._single is None
            return now

        def shown(now: Choices) -> float:
            return 100.0 if self._single is None else 100 * now.limits.get(self._single, 1.0)

        def changed(now: Choices, value: float) -> Choices:
            return now if self._single is None else now.with_limit(self._single, value / 100)

        self._bind("one limit", self._menu, lambda _: self._menu.value, chosen)
        self._bind("of that limit", self._of_single, shown, changed)


def _limit_text(name: Changed) -> str:
    kind, robot, element = name
    return f"{robot}/{element} {kind}"


def _common_share(names: list[Changed], now: Choices) -> float:
    return round(100 * now.limits.get(names[0], 1.0), DECIMALS)


def _with_common(names: list[Changed], now: Choices, value: float) -> Choices:
    for name in names:
        now = now.with_limit(name, value / 100)
    return now


def _share(index: int, equal: tuple[float, ...], now: Choices) -> float:
    return round(100 * (now.shares or equal)[index], DECIMALS)


def _with_share(index: int, now: Choices, value: float) -> Choices:
    """With another share of one arm; the others keep their proportions to each other."""
    if now.shares is None:
        return now
    share = value / 100
    rest = [part for at, part in enumerate(now.shares) if at != index]
    total = sum(rest)
    parts = [part / total if total > 0 else 1 / len(rest) for part in rest]
    shares = [part * (1 - share) for part in parts]
    shares.insert(index, share)
    shares[-1] = max(0.0, 1 - sum(shares[:-1]))
    return replace(now, shares=tuple(shares))


def _corners(box: LoadBox) -> dict[str, Mapping[str, float] | None]:
    """Parameters of loads on offer by their text: all of the box, the nominal one, its corners."""
    points = [box.nominal_point(), *box.corners(box.varying)]
    found: dict[str, Mapping[str, float] | None] = {ALL_LOADS: None}
    for number, point in enumerate(points[:CORNERS_SHOWN]):
        values = ", ".join(
            f"{name} × {value:.4g}" if name in FACTORS else f"{name} {value:.4g} {UNITS[name]}"
            for name, value in point.parameters.items()
        )
        found[values if number else f"nominal: {values}"] = MappingProxyType(dict(point.parameters))
    return found
