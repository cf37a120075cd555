# SPDX-License-Identifier: MIT
"""What a player of a motion shows: the chosen configuration, speed and time, and all that follows from them."""

import re
from dataclasses import dataclass
from math import ceil, floor, isfinite, log10, sqrt

import numpy as np

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.coordination.grasp_closure import ClosureBound
from mrts.limits import all_rows, limit_rows
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.samples.load_sharing import LoadSharing
from mrts.samples.reserve import TORQUES
from mrts.samples.torque_distribution import torque_weights
from mrts.scaling.range import ScalingRange
from mrts.scaling.result import LIMIT_TOLERANCE, ScalingResult
from mrts.scaling.scale import SelectionError, scale
from mrts.scaling.scaled_trajectory import ScaledTrajectory
from mrts.solvers import DEFAULT_SOLVER
from mrts.studies.configurations import ConfigurationStudy, rank_configurations
from mrts.viewer.widened_limits import widened_torques

BEYOND = 1.2
"""Speeds are offered up to this factor beyond an end of the range, so that one sees what forbids them."""

FASTEST_INFEASIBLE, FASTEST_UNBOUNDED = 2.0, 3.0
"""Largest offered c where no end gives one."""

SLOWEST = 0.02
"""Least offered c, as a share of the largest, where the cell may stand still."""

DIRECTION = re.compile(r" ([+-][ab]?|[ab]|\d+)$")
"""The end of a contact's row that tells it from others of its kind: `+a` of "pad friction +a"."""

OWN_BARS = ("torque", "wrench", "velocity")
"""Kinds of limits that have bars of their own; others stand below them."""

STEPS = 400
"""Least number of speeds on offer."""


@dataclass(frozen=True)
class Speeds:
    """The speeds that are offered.

    Attributes:
        ends: c² of "c⁻" and "c⁺", and of the ends of slower intervals, as far as they are finite and > 0.
        lower: Least c on offer.
        upper: Largest.
        step: Between neighbours, a power of ten; `lower` and `upper` are multiples of it.
        start: First choice.
    """

    ends: dict[str, float]
    lower: float
    upper: float
    step: float
    start: float

    @property
    def digits(self) -> int:
        """Decimal places that tell neighbours apart."""
        return max(0, -round(log10(self.step)))

    def c2(self, c: float) -> float:
        """The c² that a c on offer stands for: the exact end where the end lies within half a step."""
        near = [c2 for c2 in self.ends.values() if abs(sqrt(c2) - c) <= self.step / 2]
        return near[-1] if near else c * c


@dataclass(frozen=True)
class Bar:
    """A quantity against its limits.

    Attributes:
        name: Joint or wrench component.
        value: In `unit`.
        lower: Minus infinity where unbounded.
        upper: Infinity where unbounded.
        unit: Of value and limits.
    """

    name: str
    value: float
    lower: float
    upper: float
    unit: str

    @property
    def limit(self) -> float | None:
        """The limit on the value's side of zero; None if there is none."""
        limit = self.upper if self.value >= 0 else self.lower
        return limit if isfinite(limit) else None

    @property
    def share(self) -> float | None:
        """The value as a signed share of its limit; None without one, infinity for a limit of zero that is passed."""
        if self.limit is None:
            return None
        if self.limit == 0:
            return 0.0 if self.value == 0 else float(np.copysign(np.inf, self.value))
        return float(np.copysign(self.value / self.limit, self.value))

    @property
    def over(self) -> bool:
        """Whether it is beyond a limit by more than rounding."""
        size = max((abs(limit) for limit in (self.lower, self.upper) if isfinite(limit)), default=1.0) or 1.0
        return max(self.lower - self.value, self.value - self.upper) > LIMIT_TOLERANCE * size


class PlayerState:
    """A motion at a chosen speed, at a chosen time: at first the fastest admissible one, or c = 1 if there is none.

    Args:
        cell: The cell.
        motion: As given.
        sharing: A fixed distribution of the load; None leaves it to the quadratic program.
        solver: Name in the registry.
        closure: As in `mrts.scale`.
        progress: Told how far the work on an uncertain load is.

    Attributes:
        result: The range, of the chosen configuration.
        speeds: On offer.
        trajectory: The motion at the chosen speed.
        excess: Share by which a limit is overstepped at most at each sample, 0 for rounding, Shape (N,).
        sample: Index of the chosen time.
        study: The configurations, once they are ranked.
        configuration: Index of the chosen one in the ranking; None is the one that the cell file gives.

    Raises:
        MrtsError: As `mrts.scale`; an infeasible motion is no error.
    """

    result: ScalingResult
    speeds: Speeds
    trajectory: ScaledTrajectory
    excess: Array

    def __init__(
        self,
        cell: Cell,
        motion: ObjectMotion | JointTable,
        *,
        sharing: LoadSharing | None = None,
        closure: ClosureBound | None = None,
        solver: str = DEFAULT_SOLVER,
        progress: Progress = lambda _done, _total: None,
    ) -> None:
        self.sample = 0
        self.study: ConfigurationStudy | None = None
        self.configuration: int | None = None
        self._cell, self._motion, self._sharing, self._solver = cell, motion, sharing, solver
        self._progress, self._closure = progress, closure
        self._play(cell)

    @property
    def fixed_configuration(self) -> str:
        """Why there are no other configurations to choose; empty if there are."""
        if isinstance(self._motion, JointTable):
            return "A table of joint motion fixes the configuration; only an object's motion leaves a choice."
        return ""

    @property
    def time(self) -> float:
        """Of the chosen sample, at the chosen speed [s]."""
        return float(self.trajectory.time[self.sample])

    @property
    def keeps_velocities(self) -> bool:
        """Whether velocity limits bound the speed, or are reported only."""
        return self.result.cell.enforces_velocity_limits

    @property
    def admissible(self) -> bool:
        """Whether the chosen speed is in the range."""
        return _admits(self.result.range, self.trajectory.c2)

    def choose_time(self, time: float) -> None:
        """Go to the sample nearest to a time at the chosen speed [s]."""
        self.sample = int(np.argmin(np.abs(self.trajectory.time - time)))

    def choose_speed(self, c: float) -> None:
        """Play at another speed: torques are distributed anew.

        Args:
            c: Factor of speed; one within half a step of an end of the range is that end.

        Raises:
            InputError: Unless it is finite, > 0, and at least a thousandth of the least on offer.
            SolverError: If no solver answers.
        """
        least = 1e-3 * self.speeds.lower  # far below, c² and what is divided by it leave the range of numbers
        if not (isfinite(c) and c >= least):
            raise InputError("c", f"must be finite and >= {least:.3g}.", value=c)
        self.trajectory, self.excess = self._distribute(self.result, self.speeds.c2(c))

    def rank(self) -> None:
        """Compare all configurations; takes seconds.

        Raises:
            MrtsError: As `rank_configurations`.
        """
        if isinstance(self._motion, ObjectMotion):
            self.study = rank_configurations(self._cell, self._motion, sharing=self._sharing, solver=self._solver)

    def configuration_labels(self) -> list[str]:
        """One a ranked configuration, such as "1: left 1, right 1, c²⁺ = 26.35"."""
        labels = []
        for rank, configuration in enumerate(self.study.ranked if self.study else (), start=1):
            branches = ", ".join(f"{branch.robot} {branch.number}" for branch in configuration.branches)
            c2, status = configuration.c2_upper, configuration.range.status.value
            labels.append(f"{rank}: {branches}, " + (f"c²⁺ = {c2:.4g}" if isfinite(c2) else status))
        return labels

    def choose_configuration(self, index: int | None) -> None:
        """Play the motion in another configuration, from its start, at its own first choice of speed.

        Args:
            index: In the ranking; None takes the configuration of the cell file.

        Raises:
            MrtsError: As `mrts.scale`; nothing changes then.
        """
        if index is None or self.study is None:
            self._play(self._cell)
        else:
            self._play(self._cell.with_postures(self.study.ranked[index].postures()))
        self.configuration = index

    def torque_bars(self) -> dict[str, list[Bar]]:
        """Joint torques at the chosen time, by robot."""
        return self._bars("torque")

    def wrench_bars(self) -> dict[str, list[Bar]]:
        """Contact wrenches at the chosen time, by robot."""
        return self._bars("wrench")

    def velocity_bars(self) -> dict[str, list[Bar]]:
        """Joint velocities at the chosen time, by robot."""
        return {robot: bars for robot, bars in self._bars("velocity").items() if robot != "object"}

    def further_bars(self) -> dict[str, dict[str, list[Bar]]]:
        """What limits beside those of a cell file bound at the chosen time, by kind and robot."""
        kinds = dict.fromkeys(name.kind for name in self._rows.names if name.kind not in OWN_BARS)
        return {kind: self._contact_bars() if kind == "contact" else self._bars(kind) for kind in kinds}

    def joints_beyond_velocity(self) -> int:
        """How many joints pass their velocity limit at some time."""
        done, names = self.trajectory, self._rows.names
        rows = self._rows.only(np.array([name.kind == "velocity" and name.robot != "object" for name in names]))
        excess = rows.excess(rows.value(done.torque, done.wrench, 0.0, done.c))
        return int(np.count_nonzero(np.any(excess > LIMIT_TOLERANCE, axis=0)))

    def _bars(self, kind: str) -> dict[str, list[Bar]]:
        """What rows of one kind limit at the chosen time, by robot."""
        here, done = slice(self.sample, self.sample + 1), self.trajectory
        rows = self._rows.at(here)
        moving = rows.moving(done.c)[0]
        value = rows.value(done.torque[here], done.wrench[here], 0.0, done.c)[0] - moving
        lower, upper = rows.lower - moving, rows.upper - moving
        bars: dict[str, list[Bar]] = {}
        for row, name in enumerate(rows.names):
            if name.kind == kind:
                bar = Bar(name.element, float(value[row]), float(lower[row]), float(upper[row]), name.unit)
                bars.setdefault(name.robot, []).append(bar)
        return bars

    def _contact_bars(self) -> dict[str, list[Bar]]:
        """How much of what each hand can hold is in use at the chosen time, of friction in its worst direction."""
        here, done = slice(self.sample, self.sample + 1), self.trajectory
        rows = self._rows.at(here)
        share = rows.share(rows.value(done.torque[here], done.wrench[here], 0.0, done.c))[0]
        most: dict[tuple[str, str], float] = {}
        for row, name in enumerate(rows.names):
            if name.kind == "contact":
                of = name.robot, DIRECTION.sub("", name.element)
                most[of] = max(float(share[row]), most.get(of, 0.0))
        bars: dict[str, list[Bar]] = {}
        for (robot, what), used in most.items():
            bars.setdefault(robot, []).append(Bar(what, 100 * used, -np.inf, 100.0, "%"))
        return bars

    def _play(self, cell: Cell) -> None:
        try:
            result = scale(
                cell,
                self._motion,
                sharing=self._sharing,
                solver=self._solver,
                closure=self._closure,
                progress=self._progress,
            )
        except SelectionError as error:  # the cell can only hold still, or c = 1 is too slow where nothing is too fast
            if error.result is None:
                raise
            result = error.result
        speeds = offered_speeds(result.range)
        trajectory, excess = self._distribute(result, speeds.c2(speeds.start))
        self.result, self.speeds, self.sample = result, speeds, 0
        self.trajectory, self.excess = trajectory, excess
        self._rows = all_rows(result.cell, result.motion)

    def _distribute(self, result: ScalingResult, c2: float) -> tuple[ScaledTrajectory, Array]:
        cell, motion, rule = result.cell, result.motion, result.rule
        if _admits(result.range, c2):
            W = torque_weights(rule.weights, motion.q.shape[1])
            distribute = TORQUES[rule.distribute]
            torque, wrench, _ = distribute(cell, motion, rule.formulation, rule.sharing, self._solver, c2, W)
        else:
            torque, wrench = widened_torques(cell, motion, rule, c2, self._solver)
        rows = limit_rows(cell, motion)
        excess = np.max(rows.excess(rows.value(torque, wrench, 0.0, sqrt(c2))), axis=1, initial=0.0)
        excess[excess <= LIMIT_TOLERANCE] = 0.0
        return ScaledTrajectory(cell, motion, c2, torque, wrench), excess


def offered_speeds(found: ScalingRange) -> Speeds:
    """Speeds around a range of c²: slightly beyond both ends.

    Args:
        found: The range; without an admissible speed, the motion as given is the first choice.
    """
    both = [end.c2 for end in (found.lower, found.upper) if end is not None]
    slowest = found.intervals[0][0].c2 if found.intervals else both[0] if both else 0.0
    named = list(zip(("c⁻", "c⁺"), both, strict=False))
    for number, interval in enumerate(found.intervals[:-1], start=1):
        named += [(f"c{side} of interval {number}", end.c2) for side, end in zip("⁻⁺", interval, strict=True)]
    ends = {name: c2 for name, c2 in named if isfinite(c2) and c2 > 0}
    of_ends = [sqrt(c2) for c2 in ends.values()]
    least = sqrt(slowest)
    moves = found.status.admits_motion and both[1] > 0
    if moves and isfinite(both[1]):
        start = upper = sqrt(both[1])
        upper *= BEYOND
    else:
        start = max(1.0, sqrt(both[0])) if moves else 1.0
        upper = FASTEST_UNBOUNDED if moves else FASTEST_INFEASIBLE
        upper = max([upper, *(BEYOND * c for c in of_ends)])
    lower = min([start, *of_ends]) / BEYOND if least > 0 else SLOWEST * upper
    power = floor(log10((upper - lower) / STEPS))
    step = 10.0**power
    lower, upper = (round(count * step, -power) for count in (max(floor(lower / step), 1), ceil(upper / step)))
    return Speeds(ends, lower, upper, step, start)


def _admits(found: ScalingRange, c2: float) -> bool:
    return found.admitted(c2, 0.0) is not None
