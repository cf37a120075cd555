# SPDX-License-Identifier: MIT
"""What a trajectory makes of the quantities that are limited, and how much of each limit it uses."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.limits import all_rows
from mrts.limits.rows import TORQUE_SPEED, RowName
from mrts.program.motor_terms import motor_terms
from mrts.program.rate_limits import RateLimits, given_rate_limits, rate_names

if TYPE_CHECKING:
    from mrts.scaling.result import ScalingResult
    from mrts.scaling.scaled_trajectory import ScaledTrajectory

NOTHING = 1e-8
"""Share of its limit below which a value is 0: programs meet limits to 1e-9, and a limit of 0 is passed by as much."""


@dataclass(frozen=True)
class LimitUse:
    """How much of its limits one row uses along a trajectory.

    Of a torque-speed line, values are torques, limits what the motor gives at the speed of that moment, unbounded where
    it would brake, and the share is that of what the line gives at standstill.

    Attributes:
        name: What the row limits.
        lower: Its lower limit, minus infinity where unbounded; where it moves, that at `time`.
        upper: Its upper limit, infinity where unbounded; likewise.
        least: Its least value.
        largest: Its largest value.
        share: The largest share of a limit that is used; 1 is at the limit. Of a limit of zero, what 100 % is says
            `LimitRows.units`; without a limit it is 0.
        time: When that is [s].
        step: The largest change from one sample to the next.
        step_share: The same as a share of the limit, of its larger side.
        limited: Whether there is a limit on some side.
    """

    name: RowName
    lower: float
    upper: float
    least: float
    largest: float
    share: float
    time: float
    step: float
    step_share: float
    limited: bool

    def step_json(self) -> dict[str, str | float]:
        """Entry of "largest_step" in the JSON result."""
        name = self.name
        place = {"robot": name.robot, "element": name.element, "unit": name.unit}
        return place | {"step": self.step, "share": self.step_share}


@dataclass(frozen=True)
class RateUse:
    """How fast a torque, a wrench component or an acceleration changes, of which that is limited.

    Attributes:
        name: What the rate is of.
        limit: Of it.
        largest: Its largest size, by differences of neighbouring samples.
        share: The same as a share of the limit.
        time: When that is: at the first of the two samples [s].
    """

    name: RowName
    limit: float
    largest: float
    share: float
    time: float

    def to_json(self) -> dict[str, str | float]:
        """Entry of "rates" in the JSON result."""
        name = self.name
        place: dict[str, str | float] = {"kind": name.kind, "robot": name.robot, "element": name.element}
        numbers = {"limit": self.limit, "largest": self.largest, "share": self.share, "time": self.time}
        return place | {"unit": name.unit} | numbers


@dataclass(frozen=True)
class LimitedQuantities:
    """Quantities of one kind and one robot along a trajectory, limited or not; k of them at N samples.

    Attributes:
        names: Joint, wrench component, or what else the rows call their elements.
        units: One a quantity.
        values: Shape (N, k).
        lower: Minus infinity where unbounded, at the speed of each sample, Shape (N, k).
        upper: Infinity where unbounded, likewise.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    lower: Array
    upper: Array

    def only(self, chosen: Sequence[bool]) -> Self:
        """Some of the quantities.

        Args:
            chosen: Which, Shape (k,).
        """
        own = [place for place, taken in enumerate(chosen) if taken]
        names, units = (tuple(of[place] for place in own) for of in (self.names, self.units))
        return replace(
            self,
            names=names,
            units=units,
            values=self.values[:, own],
            lower=self.lower[:, own],
            upper=self.upper[:, own],
        )


def limit_uses(result: "ScalingResult", kind: str | None = None) -> list[LimitUse]:
    """All limits of a cell by falling share, velocities enforced or not; empty if there is no trajectory.

    Args:
        result: The result.
        kind: Only rows of one kind, as in `RowName`, in their own order and with those that have no limit.
    """
    if kind is not None:
        return [use for use in result.limit_uses if use.name.kind == kind]
    return sorted((use for use in result.limit_uses if use.limited), key=lambda use: -use.share)


def found_limit_uses(cell: Cell, done: "ScaledTrajectory") -> tuple[LimitUse, ...]:
    """What a trajectory makes of all rows in their order, with those that have no limit.

    Args:
        cell: The cell, with the limits that count.
        done: The trajectory.
    """
    rows = all_rows(cell, done.motion)
    value = rows.value(done.torque, done.wrench, 0.0, done.c)
    share = rows.share(value)
    at = np.argmax(share, axis=0)
    moving = np.broadcast_to(rows.moving(done.c), value.shape)
    value, units = value - moving, rows.units()
    steps = np.max(np.abs(np.diff(value, axis=0)), axis=0, initial=0.0)
    value = np.where(np.abs(value) < NOTHING * units, 0.0, value)
    at_use = moving[at, range(len(at))]
    lower = np.where(at_use > 0, -np.inf, rows.lower - at_use)
    upper = np.where(at_use < 0, np.inf, rows.upper - at_use)
    limited = np.isfinite(rows.lower) | np.isfinite(rows.upper)
    return tuple(
        LimitUse(
            name=name,
            lower=float(lower[row]),
            upper=float(upper[row]),
            least=float(np.min(value[:, row])),
            largest=float(np.max(value[:, row])),
            share=max(0.0, float(share[at[row], row])),
            time=float(done.time[at[row]]),
            step=float(steps[row]),
            step_share=float(steps[row] / units[row]),
            limited=bool(limited[row]),
        )
        for row, name in enumerate(rows.names)
    )


def limit_courses(result: "ScalingResult") -> tuple[tuple[RowName, ...], Array]:
    """How much of each limit is used all along the trajectory, velocities enforced or not.

    Args:
        result: A result with a trajectory.

    Returns:
        The rows that have a limit, r of them, and the share of it that each uses at each sample, Shape (N, r).

    Raises:
        ValueError: If there is no trajectory.
    """
    done = result.trajectory
    if done is None:
        raise ValueError("there is no trajectory to draw")
    rows = all_rows(result.cell, result.motion).bounded()
    return rows.names, np.maximum(rows.share(rows.value(done.torque, done.wrench, 0.0, done.c)), 0.0)


def rate_uses(done: "ScaledTrajectory", kept: RateLimits | None) -> list[RateUse]:
    """All rates that are limited by falling share, kept or not.

    Args:
        done: The trajectory.
        kept: The limits that it keeps; None where it keeps none, and then those that the cell gives tell.
    """
    if kept is None and not given_rate_limits(done.cell).limits_something:
        return []
    found = []
    for names, values, limits in _rate_quantities(done, kept):
        if not np.any(np.isfinite(limits)):
            continue
        rates = np.abs(_steps(done, values))
        at = np.argmax(rates, axis=0)
        for place in np.flatnonzero(np.isfinite(limits)).tolist():
            largest, limit = float(rates[at[place], place]), float(limits[place])
            found.append(RateUse(names[place], limit, largest, largest / limit, float(done.time[at[place]])))
    return sorted(found, key=lambda use: -use.share)


def _steps(done: "ScaledTrajectory", values: Array) -> Array:
    """How fast values change between the samples, Shape (N - 1, k)."""
    return np.asarray(np.diff(values, axis=0) / np.diff(done.time)[:, None])


def _rate_quantities(
    done: "ScaledTrajectory", kept: RateLimits | None
) -> Iterator[tuple[tuple[RowName, ...], Array, Array]]:
    """What torque rates, wrench rates and jerks are rates of: names, values, Shape (N, k), and limits, Shape (k,)."""
    limits = given_rate_limits(done.cell) if kept is None else kept
    motors = motor_terms(done.cell, done.motion)
    torque = done.torque if motors is None else done.torque - motors.dry  # dry friction steps: no timing changes that
    quantities = (torque, limits.torque), (done.wrench, limits.wrench), (done.ddq, limits.jerk)
    for names, (values, of_kind) in zip(rate_names(done.cell), quantities, strict=True):
        yield names, values, of_kind


def limited_rates(result: "ScalingResult", kind: str, robot: str) -> LimitedQuantities:
    """How fast torques or wrenches of a robot change, or its jerks: differences of neighbouring samples, with limits.

    Limits are those that the result keeps; where it keeps none, those that the cell gives.

    Args:
        result: A result with a trajectory.
        kind: "torque rate", "wrench rate" or "jerk".
        robot: Its name.

    Returns:
        The quantities; each sample has the value of the step that begins there, the last that of the step before it.

    Raises:
        ValueError: If there is no trajectory.
    """
    if result.trajectory is None:
        raise ValueError("there is no trajectory to draw")
    found = {
        names[0].kind: (names, values, limits)
        for names, values, limits in _rate_quantities(result.trajectory, result.options.rates)
    }
    names, values, limits = found[kind]
    rates = _steps(result.trajectory, values)
    own = [place for place, name in enumerate(names) if name.robot == robot]
    values = np.concatenate([rates, rates[-1:]])[:, own]
    upper = np.broadcast_to(limits[own], values.shape)
    return LimitedQuantities(
        tuple(names[place].element for place in own), tuple(names[place].unit for place in own), values, -upper, upper
    )


def limited_rate_kinds(result: "ScalingResult") -> list[str]:
    """Kinds of rates of which some is limited, kept or not: what `limited_rates` takes; none without a trajectory.

    Args:
        result: The result.
    """
    if result.trajectory is None:
        return []
    quantities = _rate_quantities(result.trajectory, result.options.rates)
    return list(dict.fromkeys(names[0].kind for names, _, limits in quantities if np.any(np.isfinite(limits))))


def largest_step(result: "ScalingResult", kind: str) -> LimitUse | None:
    """The row of one kind that changes most from one sample to the next, as a share of its limit; None without one.

    Args:
        result: The result.
        kind: As in `RowName`; rows without a limit do not count.
    """
    bounded = [use for use in limit_uses(result) if use.name.kind == kind]
    return max(bounded, key=lambda use: use.step_share, default=None)


def limited_quantities(result: "ScalingResult", kind: str, robot: str) -> LimitedQuantities:
    """Quantities of one kind along the trajectory of a result, such as the torques of a robot, with their limits.

    Args:
        result: A result with a trajectory.
        kind: As in `RowName`.
        robot: Likewise.

    Raises:
        ValueError: If there is no trajectory.
    """
    done = result.trajectory
    if done is None:
        raise ValueError("there is no trajectory to draw")
    rows = all_rows(result.cell, result.motion)
    kinds, robots = (np.array([getattr(name, part) for name in rows.names]) for part in ("kind", "robot"))
    chosen = rows.only((kinds == kind) & (robots == robot))
    value = chosen.value(done.torque, done.wrench, 0.0, done.c)
    lower, upper = (np.broadcast_to(limit, value.shape).copy() for limit in (chosen.lower, chosen.upper))
    elements = tuple(name.element for name in chosen.names)
    if kind == "torque":
        lines = rows.only((kinds == TORQUE_SPEED) & (robots == robot))
        for row, (name, moving) in enumerate(zip(lines.names, lines.moving(done.c).T, strict=True)):
            joint = elements.index(name.element)
            lower[:, joint] = np.maximum(lower[:, joint], lines.lower[row] - moving)
            upper[:, joint] = np.minimum(upper[:, joint], lines.upper[row] - moving)
    return LimitedQuantities(elements, tuple(name.unit for name in chosen.names), value, lower, upper)
