# SPDX-License-Identifier: MIT
"""What a trajectory makes of the quantities that are limited, and how much of each limit it uses."""

from collections.abc import Callable, Container, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, Self

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.notebook import NotebookTable
from mrts.base.words import interval_text
from mrts.cell.robot import Robot
from mrts.limits import all_rows
from mrts.limits.rows import TORQUE_SPEED, RowName, polygons, side_size
from mrts.program.motion_rows import motor_terms
from mrts.program.rate_limits import given_rate_limits, rate_names

if TYPE_CHECKING:
    from mrts.scaling.result import ScalingResult
    from mrts.scaling.scaled_trajectory import ScaledTrajectory

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
    def limited(self) -> Self:
        """Those that have a limit on some side."""
        return self.only(np.any(np.isfinite(self.lower) | np.isfinite(self.upper), axis=0))

    def only(self, chosen: Sequence[bool] | NDArray[np.bool_]) -> Self:
        """Some of the quantities, chosen by Shape (k,)."""
        own = np.flatnonzero(chosen)
        arrays = (of[..., own] for of in (self.values, self.lower, self.upper, self.share, self.unit))
        return type(self)(tuple(self.rows[place] for place in own.tolist()), *arrays)

    def of(self, kind: str, robot: str) -> Self:
        """Those of one kind and one robot, as in `RowName`."""
        return self.only([(name.kind, name.robot) == (kind, robot) for name in self.rows])

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


def limit_uses(done: "ScaledTrajectory") -> tuple[LimitUse, ...]:
    """How much of each limit a trajectory uses, those of velocities enforced or not, in their order."""
    return all_quantities(done).limited.uses(done.time)


def _told_apart(share: Array | float) -> Array:
    """Shares of limits, all that are reached alike: which of them is larger is rounding."""
    return np.where(np.asarray(share) > 1 + AT_LIMIT, share, np.minimum(share, REACHED))


def by_share(uses: Iterable[LimitUse]) -> list[LimitUse]:
    """The same by falling share of the limit."""
    return sorted(uses, key=lambda use: -float(_told_apart(use.share)))


def rate_uses(result: "ScalingResult") -> list[LimitUse]:
    """All rates that are limited by falling share: those that the result keeps, or else those that the cell gives."""
    rates = limited_rates(result)
    return [] if result.trajectory is None or rates is None else by_share(rates.uses(result.trajectory.time))


def limited_quantities(result: "ScalingResult", kind: str, robot: str) -> LimitedQuantities:
    """Quantities of one kind along the trajectory of a result, such as the torques of a robot, with their limits."""
    found = all_quantities(result.done)
    chosen = found.of(kind, robot)
    if kind == "torque":
        lines = found.of(TORQUE_SPEED, robot)
        for row, name in enumerate(lines.names):
            joint = chosen.names.index(name)
            chosen.lower[:, joint] = np.maximum(chosen.lower[:, joint], lines.lower[:, row])
            chosen.upper[:, joint] = np.minimum(chosen.upper[:, joint], lines.upper[:, row])
    return chosen


def all_quantities(done: "ScaledTrajectory") -> LimitedQuantities:
    """What rows limit, with what the limits of torque-speed lines are at the speed of each sample.

    Velocities have theirs also where these are reported only.
    Such a line is no limit on the side on which the motor brakes.
    """
    rows = all_rows(done.cell, done.motion)
    values = rows.value(done.torque, done.wrench, 0.0, done.c)
    lines = np.array([name.kind == TORQUE_SPEED for name in rows.names], dtype=bool)
    moving = np.zeros_like(values) if rows.speed is None else np.where(lines, rows.speed * done.c, 0.0)
    lower = np.where(moving > 0, -np.inf, rows.lower - moving)
    upper = np.where(moving < 0, np.inf, rows.upper - moving)
    found = LimitedQuantities(rows.names, values - moving, lower, upper, rows.share(values), rows.units)
    return _without_sides(found)


def _without_sides(found: LimitedQuantities) -> LimitedQuantities:
    """Of the sides of each polygon the first, with what its circle limits: the size of a norm."""
    polygon = list(polygons(found.rows).values())
    if not polygon:
        return found
    first, others = [own[0] for own in polygon], np.concatenate([own[1:] for own in polygon])
    values, lower, upper = found.values.copy(), found.lower.copy(), found.upper[:, first]
    values[:, first] = upper + (found.share[:, first] - 1) * side_size(upper, found.unit[first])
    lower[:, first] = -np.inf
    return replace(found, values=values, lower=lower).only(~np.isin(np.arange(len(found.rows)), others))


def power_uses(done: "ScaledTrajectory") -> tuple[LimitUse, ...]:
    """Powers that are limited, of joints and of all motors together: products of torque and speed, so no rows."""
    cell, power = done.cell, np.column_stack([done.power, np.sum(done.power, axis=1)])
    names = [RowName("power", robot.name, joint, "W") for robot in cell.robots for joint in robot.joints]
    rows = (*names, RowName("power", "", "all motors together", "W"))
    unit = np.append(cell.stacked("motors.power"), cell.power_limit or np.inf)
    limit = np.broadcast_to(unit, power.shape)
    found = LimitedQuantities(rows, power, -limit, limit, np.abs(power) / limit, unit)
    return found.limited.uses(done.time)


def limited_rates(result: "ScalingResult") -> LimitedQuantities | None:
    """Torque rates, wrench rates and jerks that are limited, kept or not: differences of neighbouring samples.

    Limits are those that the result keeps, or else those that the cell gives; None without any, or a trajectory. Each
    sample has the value of the step that begins there, the last that of the step before it.
    """
    done, limits = result.trajectory, result.options.rates or given_rate_limits(result.cell)
    if done is None or not limits.limits_something:
        return None
    motors = motor_terms(result.cell, result.motion)
    torque = done.torque if motors is None else done.torque - motors.dry  # dry friction steps: no timing changes that
    rates = np.diff(np.hstack([torque, done.wrench, done.ddq]), axis=0) / np.diff(done.time)[:, None]
    rates = np.concatenate([rates, rates[-1:]])
    unit = np.concatenate([limits.torque, limits.wrench, limits.jerk])
    limit = np.broadcast_to(unit, rates.shape)
    names = sum(rate_names(result.cell), ())
    return LimitedQuantities(names, rates, -limit, limit, np.abs(rates) / limit, unit).limited


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
        used = f"{percent(use)}{', binds' if use.name in binding else ''}"
        rows.setdefault(use.label, (use.label, used, *told, place(use)))
    return NotebookTable(("limit", "used", "values", "limits", "at"), [*rows.values()])


def percent(use: LimitUse) -> str:
    """The share of a limit that is used."""
    return f"{round(100 * use.share, 1):g} %"
