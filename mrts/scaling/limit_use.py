# SPDX-License-Identifier: MIT
"""What a trajectory makes of the quantities that are limited, and how much of each limit it uses."""

from collections.abc import Callable, Container, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.notebook import NotebookTable
from mrts.base.words import interval_text
from mrts.cell.robot import Robot
from mrts.limits.rows import TORQUE_SPEED, RowName, polygons, side_size

NOTHING = 1e-8
"""Share of its limit below which a value is 0: programs meet limits to 1e-9, and a limit of 0 is passed by as much."""

LIMIT_DIGITS = 6
"""Significant digits of a limit: as many as it is given with."""

REACHED = 0.9995
"""Share of a limit from which it reads 100 %."""

AT_LIMIT = 1e-4
"""Share of a limit by which one that is reached may miss it: interior points come near limits, not to them."""

NEAR = 0.9
"""Share of a limit from which it is near."""

Nearness = Literal["free", "near", "reached"]


@dataclass(frozen=True)
class LimitUse:
    """How much of its limits one row, or how fast it changes, uses along a trajectory.

    Of a torque-speed line, values are torques, limits what the motor gives at the speed of that moment, unbounded where
    it would brake, and the share is that of what the line gives at standstill. Rates are differences of neighbouring
    samples.

    Attributes:
        name: What the row limits.
        lower: Its lower limit, minus infinity where unbounded; where it moves, that at `time`.
        upper: Its upper limit, infinity where unbounded; likewise.
        least: Its least value.
        largest: Its largest value.
        share: The largest share of a limit that is used; 1 is at the limit. Of a limit of zero, what 100 % is says
            `LimitRows.units`; without a limit it is 0.
        time: When it is used so far first, of a rate at the first of the two samples [s].
        sample: Where.
    """

    name: RowName
    lower: float
    upper: float
    least: float
    largest: float
    share: float
    time: float
    sample: int

    @property
    def label(self) -> str:
        """What it limits, for people: `left/elbow torque`, `left/pad slips`."""
        return self.name.failure or str(self.name)

    @property
    def size(self) -> float:
        """The largest value without its sign."""
        return max(-self.least, self.largest)

    @property
    def percent(self) -> str:
        """The share that is used, in words."""
        return f"{round(100 * self.share, 1):g} %"

    @property
    def nearness(self) -> Nearness:
        """How near the limit is."""
        return "reached" if self.share >= REACHED else "near" if self.share >= NEAR else "free"

    def body(self, robot: Robot) -> int | None:
        """The body of an arm that it is about: that of the joint, else the hand; None of another arm."""
        if self.name.robot != robot.name:
            return None
        joint = self.name.element
        return robot.joints.index(joint) + 1 if joint in robot.joints else len(robot.joints)


@dataclass(frozen=True)
class LimitedQuantities:
    """Quantities along a trajectory, limited or not; k of them at N samples.

    Attributes:
        rows: What they are.
        values: Shape (N, k).
        lower: Minus infinity where unbounded, at the speed of each sample, Shape (N, k).
        upper: Infinity where unbounded, likewise.
        share: How much of its limit each uses, Shape (N, k).
        unit: What 100 % is, Shape (k,).
    """

    rows: tuple[RowName, ...]
    values: Array
    lower: Array
    upper: Array
    share: Array
    unit: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Joint, wrench component, or what else the rows call their elements."""
        return tuple(name.element for name in self.rows)

    @property
    def units(self) -> tuple[str, ...]:
        """One a quantity."""
        return tuple(name.unit for name in self.rows)

    @property
    def of_circles(self) -> Self:
        """Of the sides of each polygon the first, with what its circle limits: the size of a norm."""
        polygon = list(polygons(self.rows).values())
        if not polygon:
            return self
        first, others = [own[0] for own in polygon], np.concatenate([own[1:] for own in polygon])
        values, lower, upper = self.values.copy(), self.lower.copy(), self.upper[:, first]
        values[:, first] = upper + (self.share[:, first] - 1) * side_size(upper, self.unit[first])
        lower[:, first] = -np.inf
        return replace(self, values=values, lower=lower).only(~np.isin(np.arange(len(self.rows)), others))

    @property
    def limited(self) -> Self:
        """Those that have a limit on some side."""
        return self.only(np.any(np.isfinite(self.lower) | np.isfinite(self.upper), axis=0))

    def only(self, chosen: Sequence[bool] | NDArray[np.bool_]) -> Self:
        """Some of the quantities, chosen by Shape (k,)."""
        own = np.flatnonzero(chosen)
        arrays = (of[..., own] for of in (self.values, self.lower, self.upper, self.share, self.unit))
        return type(self)(tuple(self.rows[place] for place in own.tolist()), *arrays)

    def of(self, kind: str, robot: str) -> Self:
        """Those of one kind and one robot, as in `RowName`; torques within what their motors' lines leave."""
        chosen = self.only([(name.kind, name.robot) == (kind, robot) for name in self.rows])
        if kind == "torque":
            lines = self.of(TORQUE_SPEED, robot)
            for row, name in enumerate(lines.names):
                joint = chosen.names.index(name)
                chosen.lower[:, joint] = np.maximum(chosen.lower[:, joint], lines.lower[:, row])
                chosen.upper[:, joint] = np.minimum(chosen.upper[:, joint], lines.upper[:, row])
        return chosen

    def uses(self, time: Array) -> tuple[LimitUse, ...]:
        """What is made of each, all limited, at the sample that uses most; `time` of the samples, Shape (N,) [s]."""
        most = np.max(self.share, axis=0)
        at = np.argmax(self.share >= _told_apart(most), axis=0)
        values = np.where(np.abs(self.values) < NOTHING * self.unit, 0.0, self.values)
        return tuple(
            LimitUse(
                name=self.rows[row],
                lower=float(self.lower[at[row], row]),
                upper=float(self.upper[at[row], row]),
                least=float(np.min(values[:, row])),
                largest=float(np.max(values[:, row])),
                share=max(0.0, float(most[row])),
                time=float(time[at[row]]),
                sample=int(at[row]),
            )
            for row in range(len(self.rows))
        )


def _told_apart(share: Array | float) -> Array:
    """Shares of limits, all that are reached alike: which of them is larger is rounding."""
    return np.where(np.asarray(share) > 1 + AT_LIMIT, share, np.minimum(share, REACHED))


def by_share(uses: Iterable[LimitUse]) -> list[LimitUse]:
    """The same by falling share of the limit."""
    return sorted(uses, key=lambda use: -float(_told_apart(use.share)))


def limits_table(
    uses: Iterable[LimitUse],
    binding: Container[RowName] = (),
    place: Callable[[LimitUse], str] = lambda use: f"{use.time:.4g} s",
) -> NotebookTable:
    """All limits by falling share that is used; each failure of a hand once, without the numbers of its rows.

    Args:
        uses: How much of the limits is used.
        binding: Rows that set the speed: no distribution of torques gets past them. They stand first; another limit at
            100 % is where this distribution puts it.
        place: Says where most is used.
    """
    rows: dict[str, tuple[str, ...]] = {}
    for use in sorted(by_share(uses), key=lambda use: use.name not in binding):
        limits = interval_text(use.lower, use.upper, use.name.unit, LIMIT_DIGITS)
        told = ("", "") if use.name.failure else (f"{use.least:.4g} to {use.largest:.4g}", limits)
        used = f"{use.percent}{', binds' if use.name in binding else ''}"
        rows.setdefault(use.label, (use.label, used, *told, place(use)))
    return NotebookTable(("limit", "used", "values", "limits", "at"), [*rows.values()])
