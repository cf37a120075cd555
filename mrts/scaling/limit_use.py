# SPDX-License-Identifier: MIT
"""What a trajectory makes of the quantities that are limited, and how much of each limit it uses."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from mrts.base.arrays import Array
from mrts.base.interval_text import interval_text
from mrts.base.notebook.in_notebooks import NotebookTable
from mrts.limits import all_rows
from mrts.limits.rows import TORQUE_SPEED, LimitRows, RowName
from mrts.program.motor_terms import motor_terms
from mrts.program.rate_limits import given_rate_limits, rate_names

if TYPE_CHECKING:
    from mrts.scaling.result import ScalingResult
    from mrts.scaling.scaled_trajectory import ScaledTrajectory

NOTHING = 1e-8
"""Share of its limit below which a value is 0: programs meet limits to 1e-9, and a limit of 0 is passed by as much."""

TITLES = {"torque": "torque", "wrench": "contact wrench", "velocity": "velocity", "": "other"}
"""Of tables by the kind of their limits; those of the last are of kinds that mrts does not know."""

ELSEWHERE = ("contact", TORQUE_SPEED, "motor speed")
"""Kinds that are summed up elsewhere."""

LIMIT_DIGITS = 6
"""Significant digits of a limit: as many as it is given with."""


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
        time: When that is, of a rate at the first of the two samples [s].
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

    @property
    def size(self) -> float:
        """The largest value without its sign."""
        return max(-self.least, self.largest)

    def step_json(self) -> dict[str, str | float]:
        """Entry of "largest_step" in the JSON result."""
        name = self.name
        place = {"robot": name.robot, "element": name.element, "unit": name.unit}
        return place | {"step": self.step, "share": self.step_share}

    def rate_json(self) -> dict[str, str | float]:
        """Entry of "rates" in the JSON result."""
        name = self.name
        place: dict[str, str | float] = {"kind": name.kind, "robot": name.robot, "element": name.element}
        numbers = {"limit": self.upper, "largest": self.size, "share": self.share, "time": self.time}
        return place | {"unit": name.unit} | numbers


@dataclass(frozen=True)
class LimitedQuantities:
    """Quantities along a trajectory, limited or not; k of them at N samples.

    Attributes:
        rows: What they are.
        values: Shape (N, k).
        lower: Minus infinity where unbounded, at the speed of each sample, Shape (N, k).
        upper: Infinity where unbounded, likewise.
    """

    rows: tuple[RowName, ...]
    values: Array
    lower: Array
    upper: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Joint, wrench component, or what else the rows call their elements."""
        return tuple(name.element for name in self.rows)

    @property
    def units(self) -> tuple[str, ...]:
        """One a quantity."""
        return tuple(name.unit for name in self.rows)

    def only(self, chosen: Sequence[bool]) -> Self:
        """Some of the quantities.

        Args:
            chosen: Which, Shape (k,).
        """
        own = [place for place, taken in enumerate(chosen) if taken]
        rows = tuple(self.rows[place] for place in own)
        return type(self)(rows, self.values[:, own], self.lower[:, own], self.upper[:, own])

    def of(self, kind: str, robot: str) -> Self:
        """Those of one kind and one robot, as in `RowName`."""
        return self.only([(name.kind, name.robot) == (kind, robot) for name in self.rows])


def limit_uses(result: "ScalingResult", kind: str | None = None) -> list[LimitUse]:
    """All limits of a cell by falling share, velocities enforced or not; empty if there is no trajectory.

    Args:
        result: The result.
        kind: Only rows of one kind, as in `RowName`, in their own order and with those that have no limit.
    """
    if kind is not None:
        return [use for use in result.limit_uses if use.name.kind == kind]
    return sorted((use for use in result.limit_uses if use.limited), key=lambda use: -use.share)


def found_limit_uses(result: "ScalingResult") -> tuple[LimitUse, ...]:
    """What the trajectory of a result makes of all rows in their order, with those that have no limit."""
    done = result.trajectory
    if done is None:
        return ()
    rows = all_rows(result.cell, result.motion)
    found, share = _quantities(rows, done), rows.share(_values(rows, done))
    moving = rows.moving(done.c)
    driven = LimitedQuantities(
        found.rows, found.values, np.where(moving > 0, -np.inf, found.lower), np.where(moving < 0, np.inf, found.upper)
    )
    return _uses(driven, share, rows.units(), done.time)


def rate_uses(result: "ScalingResult") -> list[LimitUse]:
    """All rates that are limited by falling share: those that the result keeps, or else those that the cell gives."""
    if result.trajectory is None or not _limits_rates(result):
        return []
    rates = _rates(result)
    rates = rates.only(np.isfinite(rates.upper[0]).tolist())
    limit = rates.upper[0]
    uses = _uses(rates, np.abs(rates.values) / limit, limit, result.trajectory.time)
    return sorted(uses, key=lambda use: -use.share)


def _uses(found: LimitedQuantities, share: Array, units: Array, time: Array) -> tuple[LimitUse, ...]:
    """The uses of quantities, each at the sample that uses the largest share, Shape (N, k); units are 100 %, (k,)."""
    at = np.argmax(share, axis=0)
    limited = np.any(np.isfinite(found.lower) | np.isfinite(found.upper), axis=0)
    steps = np.max(np.abs(np.diff(found.values, axis=0)), axis=0, initial=0.0)
    values = np.where(np.abs(found.values) < NOTHING * units, 0.0, found.values)
    return tuple(
        LimitUse(
            name=name,
            lower=float(found.lower[at[row], row]),
            upper=float(found.upper[at[row], row]),
            least=float(np.min(values[:, row])),
            largest=float(np.max(values[:, row])),
            share=max(0.0, float(share[at[row], row])),
            time=float(time[at[row]]),
            step=float(steps[row]),
            step_share=float(steps[row] / units[row]),
            limited=bool(limited[row]),
        )
        for row, name in enumerate(found.rows)
    )


def largest_step(result: "ScalingResult", kind: str) -> LimitUse | None:
    """The row of one kind that changes most from one sample to the next, as a share of its limit; None without one.

    Args:
        result: The result.
        kind: As in `RowName`; rows without a limit do not count.
    """
    bounded = [use for use in limit_uses(result) if use.name.kind == kind]
    return max(bounded, key=lambda use: use.step_share, default=None)


def used_shares(done: "ScaledTrajectory") -> tuple[tuple[RowName, ...], Array]:
    """How much of each limit is used all along a trajectory, velocities enforced or not.

    Args:
        done: The trajectory.

    Returns:
        The rows that have a limit, r of them, and the share of it that each uses at each sample, Shape (N, r).
    """
    rows = all_rows(done.cell, done.motion).bounded()
    return rows.names, np.maximum(rows.share(_values(rows, done)), 0.0)


def limited_quantities(result: "ScalingResult", kind: str, robot: str) -> LimitedQuantities:
    """Quantities of one kind along the trajectory of a result, such as the torques of a robot, with their limits.

    Args:
        result: A result with a trajectory.
        kind: As in `RowName`; limits of a torque are also those of torque-speed lines.
        robot: As there.

    Raises:
        ValueError: If there is no trajectory.
    """
    found = _quantities(all_rows(result.cell, result.motion), _trajectory(result))
    chosen = found.of(kind, robot)
    if kind == "torque":
        lines = found.of(TORQUE_SPEED, robot)
        for row, name in enumerate(lines.names):
            joint = chosen.names.index(name)
            chosen.lower[:, joint] = np.maximum(chosen.lower[:, joint], lines.lower[:, row])
            chosen.upper[:, joint] = np.minimum(chosen.upper[:, joint], lines.upper[:, row])
    return chosen


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
    found = _rates(result).of(kind, robot)
    values, lower, upper = (np.concatenate([of, of[-1:]]) for of in (found.values, found.lower, found.upper))
    return LimitedQuantities(found.rows, values, lower, upper)


def limited_rate_kinds(result: "ScalingResult") -> list[str]:
    """Kinds of rates of which some is limited, kept or not: what `limited_rates` takes; none without a trajectory.

    Args:
        result: The result.
    """
    if result.trajectory is None or not _limits_rates(result):
        return []
    rates = _rates(result)
    limited = np.isfinite(rates.upper[0]).tolist()
    return list(dict.fromkeys(name.kind for name, has in zip(rates.rows, limited, strict=True) if has))


def _trajectory(result: "ScalingResult") -> "ScaledTrajectory":
    if result.trajectory is None:
        raise ValueError("there is no trajectory to draw")
    return result.trajectory


def _values(rows: LimitRows, done: "ScaledTrajectory") -> Array:
    return rows.value(done.torque, done.wrench, 0.0, done.c)


def _quantities(rows: LimitRows, done: "ScaledTrajectory") -> LimitedQuantities:
    """What rows limit, with what the limits of torque-speed lines are at the speed of each sample."""
    values = _values(rows, done)
    moving = np.broadcast_to(rows.moving(done.c), values.shape)
    return LimitedQuantities(rows.names, values - moving, rows.lower - moving, rows.upper - moving)


def _limits_rates(result: "ScalingResult") -> bool:
    return result.options.rates is not None or given_rate_limits(result.cell).limits_something


def _rates(result: "ScalingResult") -> LimitedQuantities:
    """Torque rates, wrench rates and jerks between the samples, Shape (N - 1, k)."""
    done, kept = _trajectory(result), result.options.rates
    limits = given_rate_limits(result.cell) if kept is None else kept
    motors = motor_terms(result.cell, result.motion)
    torque = done.torque if motors is None else done.torque - motors.dry  # dry friction steps: no timing changes that
    values = np.hstack([torque, done.wrench, done.ddq])
    rates = np.diff(values, axis=0) / np.diff(done.time)[:, None]
    limit = np.broadcast_to(np.concatenate([limits.torque, limits.wrench, limits.jerk]), rates.shape)
    return LimitedQuantities(sum(rate_names(result.cell), ()), rates, -limit, limit)


def limit_tables(result: "ScalingResult") -> Iterator[NotebookTable]:
    """Least and largest value of each torque, contact wrench and velocity, its limits and how much of them is used.

    "binds" stands at the limits that end the range, where its end was chosen: no distribution of torques gets past
    them. Another one at 100 % is where this distribution puts it. What a limit of yours bounds comes last; motors and
    hands have tables of their own.

    Args:
        result: The result; without a trajectory there are none.
    """
    binding = (
        set() if result.c2 is None else {row.name for _, end in result.range.ends_at(result.c2) for row in end.rows}
    )
    for kind, title in TITLES.items():
        uses = [use for use in result.limit_uses if _is_listed(use, kind)]
        told = "" if kind != "velocity" or result.cell.enforces_velocity_limits else " (limits not enforced)"
        if uses:
            rows = [_limit_row(use, binds=use.name in binding) for use in uses]
            yield NotebookTable((f"{title}{told}", "least", "largest", "used", "limits"), rows)


def _is_listed(use: LimitUse, kind: str) -> bool:
    """Whether a use stands in the table of a kind, or, if it has none, in that of all others."""
    name = use.name
    if not kind:
        return use.limited and name.kind not in {*TITLES, *ELSEWHERE}
    return name.kind == kind and (use.limited or kind != "velocity" or name.robot != "object")


def _limit_row(use: LimitUse, *, binds: bool) -> tuple[str, ...]:
    name, unit = use.name, use.name.unit
    limits = interval_text(use.lower, use.upper, unit, LIMIT_DIGITS) if use.limited else f"none, {unit}".rstrip(", ")
    return (
        f"{name.robot}/{name.element}" if name.kind in TITLES else name.short,
        f"{use.least:.4g}",
        f"{use.largest:.4g}",
        f"{round(100 * use.share, 1):g} %" if use.limited else "",
        f"{limits}{', binds' if binds else ''}",
    )
