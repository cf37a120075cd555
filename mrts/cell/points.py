# SPDX-License-Identifier: MIT
"""What of the motion alone a cell file limits: the object, points of arms and object, things on the object."""

from typing import Annotated, Any, Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.base.formats.record import Name, Positive, Record, Rule, Vector3
from mrts.base.manifest import WRENCH_COMPONENTS
from mrts.cell.hands import Direction, contact_axes, numbered

RATES = ("linear", "angular")

ObjectRates = dict[Literal["linear", "angular"], Positive | None]
"""Limits of the velocity or acceleration of the object's frame [m/s, rad/s or m/s², rad/s²]; absent is unbounded."""


def rate_limits(rates: ObjectRates) -> Array:
    """Linear and angular, infinity where there is none, Shape (2,)."""
    return np.array([rates.get("linear") or np.inf, rates.get("angular") or np.inf])


class PointLimit(Record):
    """How fast a point may move in the world.

    Attributes:
        name: Of its own; None in a cell file takes one.
        point: In its link's frame, or the object's, Shape (3,) [m].
        speed: Most of its velocity [m/s].
        acceleration: Most of its acceleration [m/s²].
    """

    name: Name | None = None
    point: Vector3 = [0.0, 0.0, 0.0]  # noqa: RUF012 (each record has its own copies)
    speed: Positive | None = None
    acceleration: Positive | None = None

    def problem(self) -> str:
        """The rule that its limits break; empty if none."""
        return "" if self.speed or self.acceleration else "it limits nothing: give 'speed', 'acceleration' or both"


class LinkPointLimit(PointLimit):
    """A point of a link of an arm."""

    link: str


class ArmPointLimit(LinkPointLimit):
    """A point of an arm as its chain moves it.

    Attributes:
        joints: How many of the arm's joints move it, from the base on.
        at_zero: Where it is with every joint at zero, base frame, Shape (3,) [m].
    """

    name: str
    joints: Annotated[int, Rule(ge=1)]
    at_zero: Vector3


class CarriedThing(Record):
    """A thing that stands loose on the held object, such as a cup on a tray; its mass does not matter.

    Attributes:
        name: Of its own; None in a cell file takes one.
        at: Middle of the surface on which it stands, object frame, Shape (3,) [m].
        normal: Of that surface, from the object into the thing, object frame, of any length, Shape (3,).
        friction: Coefficient between the two; None where it cannot slide.
        half_width: Of its foot along a and b, axes in the surface as a pad's, Shape (2,) [m]; None where it cannot tip.
        height: Of its centre of mass above the surface [m]; it goes with `half_width`.
    """

    name: Name | None = None
    at: Vector3 = [0.0, 0.0, 0.0]  # noqa: RUF012
    normal: Direction = [0.0, 0.0, 1.0]  # noqa: RUF012
    friction: Positive | None = None
    half_width: Annotated[list[Positive], Rule(min_length=2, max_length=2)] | None = None
    height: Positive | None = None

    def problem(self) -> str:
        """The rule that its keys break; empty if none."""
        if self.friction is None and self.half_width is None:
            return "nothing limits it: give 'friction', 'half_width' or both"
        together = (self.height is None) == (self.half_width is None)
        return "" if together else "'half_width' and 'height', of its centre of mass, go together: give both or none"

    @property
    def axes(self) -> Array:
        """a, b and the normal as rows in the object frame, Shape (3, 3)."""
        return contact_axes("normal", self.normal, WRENCH_COMPONENTS)

    @property
    def centre(self) -> Array:
        """Its centre of mass in the object frame; of one that cannot tip `at`, Shape (3,) [m]."""
        return np.asarray(np.array(self.at) + (self.height or 0.0) * self.axes[2], dtype=np.float64)


def point_names(given: list[Any], default: str = "") -> list[str]:
    """Names of limited points or carried things: their own, or else `default` or their links', numbered."""
    return [one.name or name for one, name in zip(given, numbered([default or one.link for one in given]), strict=True)]
