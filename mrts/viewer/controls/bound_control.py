# SPDX-License-Identifier: MIT
"""One control of the panel and the choice that it stands for; needs the extra 'view'."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import viser

from mrts.viewer.workbench.choices import Choices

DECIMALS = 2
"""Least decimal places of a number field: with those of a step of 1, none, a page drops the point from a typed 1.5."""


@dataclass(eq=False)
class BoundControl:
    """A control whose value is part of the choices.

    Attributes:
        name: What is changed, one step to undo however long it is dragged.
        handle: The control.
        read: Its value for some choices.
        apply: Choices with another value.
        shown: Value that was taken over last.
    """

    name: str
    handle: viser.GuiInputHandle[Any]
    read: Callable[[Choices], Any]
    apply: Callable[[Choices, Any], Choices]
    shown: Any = None

    def __post_init__(self) -> None:
        if isinstance(self.handle, viser.GuiSliderHandle):
            self.handle.precision = max(self.handle.precision, DECIMALS)

    def changed(self, choices: Choices) -> Choices | None:
        """Choices with the control's value, if a user changed it since the last look; else None.

        Raises:
            InputError: If the value breaks a rule.
        """
        value = self.handle.value
        if value == self.shown:
            return None
        self.shown = value
        return self.apply(choices, value)

    def show(self, choices: Choices) -> None:
        """Show the value for some choices; what a user is dragging already has it."""
        value = self.read(choices)
        if value != self.shown:
            assign(self.handle, value)
            self.shown = self.handle.value


def assign(handle: viser.GuiInputHandle[Any], value: object) -> None:
    """Set a control's value."""
    handle.value = value  # type: ignore[misc]  # viser defines the setter where mypy does not look
