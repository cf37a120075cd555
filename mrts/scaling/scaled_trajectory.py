# SPDX-License-Identifier: MIT
"""The motion played at the chosen speed: what a controller gets, and how much of each limit it uses."""

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, without_infinity
from mrts.base.formats.record import dumped
from mrts.base.notebook import NotebookTable
from mrts.base.words import interval_text
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits import all_rows
from mrts.limits.cell_limits import torque_limits
from mrts.limits.rows import TORQUE_SPEED, RowName, polygons, side_size
from mrts.program.motion_rows import motor_terms
from mrts.program.rate_limits import RateLimits, given_rate_limits, rate_names

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
    def percent(self) -> str:
        """The share that is used, in words."""
        return f"{round(100 * self.share, 1):g} %"

    def to_json(self) -> dict[str, Any]:
        """An entry of limits in JSON; null stands for a side without one."""
        lower, upper = without_infinity(np.array([self.lower, self.upper]))
        most = {"share": self.share, "time": self.time, "least": self.least, "largest": self.largest}
        return self.name.to_json() | most | {"lower": lower, "upper": upper}

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
            lines, joints = self.of(TORQUE_SPEED, robot), [name.element for name in chosen.rows]
            for row, name in enumerate(lines.rows):
                joint = joints.index(name.element)
                chosen.lower[:, joint] = np.maximum(chosen.lower[:, joint], lines.lower[:, row])
                chosen.upper[:, joint] = np.minimum(chosen.upper[:, joint], lines.upper[:, row])
        return chosen

    def uses(self, time: Array) -> tuple[LimitUse, ...]:
        """What is made of each, all limited, at the sample that uses most; `time` of the samples, Shape (N,) [s]."""
        most, every = np.max(self.share, axis=0), np.arange(len(self.rows))
        at = np.argmax(self.share >= _told_apart(most), axis=0)
        values = np.where(np.abs(self.values) < NOTHING * self.unit, 0.0, self.values)
        limits = self.lower[at, every], self.upper[at, every]
        numbers = (*limits, values.min(axis=0), values.max(axis=0), np.maximum(most, 0.0), time[at], at)
        return tuple(map(LimitUse, self.rows, *(of.tolist() for of in numbers)))


def _told_apart(share: Array | float) -> Array:
    """Shares of limits, all that are reached alike: which of them is larger is rounding."""
    return np.where(np.asarray(share) > 1 + AT_LIMIT, share, np.minimum(share, REACHED))


def by_share(uses: Iterable[LimitUse]) -> list[LimitUse]:
    """The same by falling share of the limit."""
    return sorted(uses, key=lambda use: -float(_told_apart(use.share)))


@dataclass(frozen=True)
class Holding:
    """What a controller needs before the first and after the last sample, at both ends of a motion.

    Attributes:
        ends: Whether there are such torques at the start, and at the end: only where the motion is at rest there but
            accelerates, and the limits let the cell hold still.
        torque: Shape (2, m) [N m or N]; zero where there are none.
        wrench: Robot after robot in base axes, Shape (2, n w) [N, N m]; zero where there are none.
        rate: Of the samples, where they lie at equal steps, as the rows that hold then do [Hz]; else None.
    """

    ends: tuple[bool, bool]
    torque: Array
    wrench: Array
    rate: float | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class JointDuty:
    """Duty of n joints over a motion, each Shape (n,); of a prismatic joint read N, m/s, N/s, m/s³.

    Torques are those that the motors give, taken as straight lines between samples. A share is that of what the joint
    bears, 1 being all of it, and 0 where no limit is known. Torque rate and jerk bound nothing unless rates are
    kept (`mrts.scale(rates=…)`). They are differences of neighbouring samples, so a jump, as of dry friction where a
    joint turns back, counts as steep as the samples are close.

    Attributes:
        rms_torque: Root mean square over the motion, pauses before and after it left out [N m].
        rated_share: Of `JointMotors.rated`.
        peak_torque: Largest |τ| [N m].
        torque_share: Largest share of a torque limit, on the side that is nearer.
        drive_power: Largest power q̇ τ that the motor gives [W].
        brake_power: Largest power that it takes up [W].
        power_share: The larger of the two, of `JointMotors.power`.
        peak_speed: Largest |q̇| [rad/s].
        speed_share: Of the velocity limit, or of the end of the torque-speed curve where that is less.
        torque_rate: Largest |τ̇| [N m/s].
        torque_rate_share: Of `JointMotors.torque_rate`.
        jerk: Largest |change of q̈| per second [rad/s³].
        jerk_share: Of `JointMotors.jerk`.
    """

    rms_torque: Array
    rated_share: Array
    peak_torque: Array
    torque_share: Array
    drive_power: Array
    brake_power: Array
    power_share: Array
    peak_speed: Array
    speed_share: Array
    torque_rate: Array
    torque_rate_share: Array
    jerk: Array
    jerk_share: Array


@dataclass(frozen=True, repr=False)
class ScaledTrajectory:
    """Eqs. (9), (10), (19): q̃(t) = q(c t), with joint torques and contact wrenches, at N samples.

    Attributes:
        cell: The cell, with the load that is carried.
        motion: The given motion.
        c2: c² > 0.
        torque: τ that the motors give, on the joint side of their gears, Shape (N, m) [N m or N].
        wrench: F, robot after robot in base axes, Shape (N, n w) [N, N m].
        holding: What holds the object still before and after; None where it is not known.
    """

    cell: Cell
    motion: CoordinatedMotion
    c2: float
    torque: Array
    wrench: Array
    holding: Holding | None = None

    def __repr__(self) -> str:
        return f"<ScaledTrajectory: {self.motion.samples} samples in {self.duration:.4g} s, c² = {self.c2:.4g}>"

    @property
    def c(self) -> float:
        """The factor of speed."""
        return float(np.sqrt(self.c2))

    @property
    def time(self) -> Array:
        """T / c, Shape (N,) [s]."""
        return self.motion.object.time / self.c

    @property
    def q(self) -> Array:
        """Joint positions, Shape (N, m) [rad or m]."""
        return self.motion.q

    @property
    def dq(self) -> Array:
        """q̇ = c q', Shape (N, m) [rad/s or m/s]."""
        return self.c * self.motion.dq

    @property
    def ddq(self) -> Array:
        """q̈ = c² q'', Shape (N, m) [rad/s² or m/s²]."""
        return self.c2 * self.motion.ddq

    @property
    def played(self) -> CoordinatedMotion:
        """The motion by its new time."""
        return self.motion.played(self.time, self.c)

    @property
    def duration(self) -> float:
        """New traversal time t_1 = t_f / c [s]."""
        return float(self.motion.object.time[-1] / self.c)

    def course(self) -> Any:
        """The joints by time, a cubic spline through positions and velocities, as a controller interpolates them."""
        from scipy.interpolate import CubicHermiteSpline  # noqa: PLC0415 (slow to import)

        return CubicHermiteSpline(self.time, self.q, self.dq)

    @property
    def friction(self) -> Array:
        """The part of `torque` that overcomes friction, Shape (N, m) [N m or N]; controllers add it or not."""
        motors = motor_terms(self.cell, self.motion)
        return np.zeros_like(self.torque) if motors is None else motors.friction(self.c)

    @property
    def has_friction(self) -> bool:
        """Whether some motor has friction."""
        return any(robot.motors.has_friction for robot in self.cell.robots)

    @cached_property
    def duty(self) -> dict[str, JointDuty]:
        """What the motion asks of the motors, by robot."""
        cell, torque, power, steps = self.cell, self.torque, self.power, np.diff(self.time)[:, None]
        squares = np.sum(steps * (torque[:-1] ** 2 + torque[:-1] * torque[1:] + torque[1:] ** 2) / 3, axis=0)
        curves = [curve for robot in cell.robots for curve in robot.motors.torque_speed]
        fastest = np.array([np.inf if curve is None else curve[-1, 0] for curve in curves])
        rms, speed = np.sqrt(squares / self.duration), np.max(np.abs(self.dq), axis=0)
        rate, jerk = (np.max(np.abs(np.diff(of, axis=0) / steps), axis=0) for of in (torque, self.ddq))
        of_all = {
            "rms_torque": rms,
            "rated_share": rms / cell.stacked("motors.rated"),
            "peak_torque": np.max(np.abs(torque), axis=0),
            "torque_share": np.max(torque_limits(cell).share(torque), axis=0, initial=0.0),
            "drive_power": np.max(power, axis=0, initial=0.0),
            "brake_power": np.max(-power, axis=0, initial=0.0),
            "power_share": np.max(np.abs(power), axis=0) / cell.stacked("motors.power"),
            "peak_speed": speed,
            "speed_share": speed / np.minimum(cell.stacked("velocity_limit"), fastest),
            "torque_rate": rate,
            "torque_rate_share": rate / cell.stacked("motors.torque_rate"),
            "jerk": jerk,
            "jerk_share": jerk / cell.stacked("motors.jerk"),
        }
        parts = cell.joint_slices.items()
        return {name: JointDuty(**{key: of[part] for key, of in of_all.items()}) for name, part in parts}

    @property
    def power(self) -> Array:
        """q̇ · τ of every joint, Shape (N, m) [W]."""
        return self.dq * self.torque

    @cached_property
    def energy(self) -> float:
        """Energy that the motors give, Σ ∫ q̇ᵀ τ dt (remark after (34)), by the trapezoidal rule [J]."""
        return integral(self.time, np.sum(self.power, axis=1))

    @property
    def terms(self) -> dict[str, Array]:
        """Coefficients of (11) to (22) at the samples, with the load that is carried."""
        return self.cell.functions("terms", self.motion.samples, self.motion.inputs(self.cell.load))

    @property
    def inverse_dynamics(self) -> Array:
        """τ by (13) that the motion takes with the contact wrenches, Shape (N, m) [N m or N]."""
        terms, motors = self.terms, motor_terms(self.cell, self.motion)
        torque: Array = terms["E"] * self.c2 + terms["G"] + (0.0 if motors is None else motors.torque(self.c))
        for name, joints in self.cell.joint_slices.items():
            J, F = terms["J"][:, :, joints], self.wrench[:, self.cell.wrench_slices[name]]
            torque[:, joints] += np.einsum("nwj,nw->nj", J, F)
        return torque

    @property
    def unbalanced(self) -> Array:
        """P c² + Q - B F of (20): what the contact wrenches lack of what moves the object, Shape (N, w) [N, N m]."""
        terms = self.terms
        lacking: Array = terms["P"] * self.c2 + terms["Q"] - np.einsum("nij,nj->ni", terms["B"], self.wrench)
        return lacking

    @cached_property
    def internal_wrench(self) -> Array:
        """F - B⁺ B F with B = [B_1 … B_n], the part of F that does not move the object, Shape (N, n w) [N, N m]."""
        return self.wrench - self.least_wrenches(np.einsum("nij,nj->ni", self.terms["B"], self.wrench))

    def least_wrenches(self, total: Array) -> Array:
        """B⁺ of a wrench on the object, Shape (N, w): the least contact wrenches that give it, Shape (N, n w)."""
        least: Array = np.linalg.pinv(self.terms["B"]) @ total[:, :, None]
        return least[:, :, 0]

    @property
    def quantities(self) -> LimitedQuantities:
        """What rows limit, with what the limits of torque-speed lines are at the speed of each sample.

        Velocities have theirs also where these are reported only. Such a line is no limit on the side on which the
        motor brakes.
        """
        rows = all_rows(self.cell, self.motion)
        limits = rows.limits
        values = rows.value(self.torque, self.wrench, 0.0, self.c)
        lines = np.array([name.kind == TORQUE_SPEED for name in rows.names], dtype=bool)
        moving = np.zeros_like(values) if rows.speed is None else np.where(lines, rows.speed * self.c, 0.0)
        lower = np.where(moving > 0, -np.inf, limits.lower - moving)
        upper = np.where(moving < 0, np.inf, limits.upper - moving)
        return LimitedQuantities(rows.names, values - moving, lower, upper, rows.share(values), limits.units).of_circles

    @cached_property
    def limit_uses(self) -> tuple[LimitUse, ...]:
        """How much of each limit is used, those of velocities enforced or not, in their order; rates apart."""
        return self.quantities.limited.uses(self.time)

    @property
    def power_uses(self) -> tuple[LimitUse, ...]:
        """Powers that are limited, of joints and of all motors together: products of torque and speed, so no rows."""
        cell, power = self.cell, np.column_stack([self.power, np.sum(self.power, axis=1)])
        names = [RowName("power", robot.name, joint, "W") for robot in cell.robots for joint in robot.joints]
        rows = (*names, RowName("power", "", "all motors together", "W"))
        unit = np.append(cell.stacked("motors.power"), cell.power_limit or np.inf)
        limit = np.broadcast_to(unit, power.shape)
        return LimitedQuantities(rows, power, -limit, limit, np.abs(power) / limit, unit).limited.uses(self.time)

    def limited_rates(self, kept: RateLimits | None = None) -> LimitedQuantities:
        """Torque rates, wrench rates and jerks that are limited: differences of neighbouring samples.

        Limits are those that are kept, or else those that the cell gives. Each sample has the value of the step that
        begins there, the last that of the step before it.
        """
        limits, motors = kept or given_rate_limits(self.cell), motor_terms(self.cell, self.motion)
        torque = self.torque if motors is None else self.torque - motors.dry  # it steps: no timing changes that
        rates = np.diff(np.hstack([torque, self.wrench, self.ddq]), axis=0) / np.diff(self.time)[:, None]
        rates, names = np.concatenate([rates, rates[-1:]]), sum(rate_names(self.cell), ())
        unit = np.concatenate([limits.torque, limits.wrench, limits.jerk])
        limit = np.broadcast_to(unit, rates.shape)
        return LimitedQuantities(names, rates, -limit, limit, np.abs(rates) / limit, unit).limited

    def to_json(self) -> dict[str, Any]:
        """Entries of the JSON result."""
        cell, time = self.cell, self.time.tolist()

        def by_robot(parts: Mapping[str, slice], values: Array) -> dict[str, Any]:
            return {"time": time} | {name: values[:, part].tolist() for name, part in parts.items()}

        joints, wrenches = cell.joint_slices, cell.wrench_slices
        motion = {
            robot.name: {"names": list(robot.joints)}
            | {name: getattr(self, name)[:, joints[robot.name]].tolist() for name in ("q", "dq", "ddq")}
            for robot in cell.robots
        }
        output = {
            "joints": {"time": time} | motion,
            "torque": by_robot(joints, self.torque),
            "wrench": {"time": time, "components": list(cell.wrench_components)} | by_robot(wrenches, self.wrench),
            "internal_wrench": by_robot(wrenches, self.internal_wrench),
            "power": by_robot(joints, self.power),
            "energy": self.energy,
            "joint_duty": dumped(self.duty),
        }
        return output | ({"torque_friction": by_robot(joints, self.friction)} if self.has_friction else {})


def integral(time: Array, values: Array) -> float:
    """Of values by time, by the trapezoidal rule, both Shape (N,)."""
    return float(np.diff(time) @ (values[1:] + values[:-1])) / 2


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
