# SPDX-License-Identifier: MIT
"""What a player of a motion shows: the chosen speed and time, and all that follows from them."""

import re
from copy import copy
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any, Literal

import numpy as np

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.following.grasp_closure import ClosureBound
from mrts.limits import all_rows, limit_rows
from mrts.limits.rows import RowName
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.plots.card import Card, answer_card
from mrts.program.excess import BETWEEN
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import motion_rows
from mrts.program.rate_limits import Rates
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.scaling.result import LIMIT_TOLERANCE, ScalingResult
from mrts.scaling.scale import SelectionError, conflict_at, distributed_torques, scale
from mrts.scaling.scaled_trajectory import ScaledTrajectory
from mrts.scene.scene import DecidingLimit, Scene, deciding_limit
from mrts.timing.result import RetimingResult
from mrts.timing.retime import retime
from mrts.viewer.offered_speeds import OF_TIMINGS, Speeds, offered_speeds
from mrts.viewer.widened_limits import widened_torques

DIRECTION = re.compile(r" ([+-][ab]?|[ab]|\d+)$")
"""The end of a contact's row that tells it from others of its kind: `+a` of "pad friction +a"."""

Profile = Literal["constant", "optimal", "smooth"]


@dataclass(frozen=True)
class Bar:
    """A quantity against its limits."""

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


@dataclass(frozen=True)
class Violation:
    """A limit that is passed.

    Attributes:
        name: Of the limit.
        excess: Beyond it at most, as a share of it.
        time: When that is, at the chosen speed [s].
    """

    name: RowName
    excess: float
    time: float


class PlayerState:
    """A motion at a chosen speed, at a chosen time: at first the fastest admissible one, or c = 1 if there is none.

    Args:
        cell: The cell.
        motion: As given.
        sharing: A fixed distribution of the load; None leaves it to the quadratic program.
        solver: Name in the registry.
        closure: As in `mrts.scale`.
        profile: One factor of speed, the fastest timing, or a smooth one.
        rates: Of the smooth profile, as in `mrts.retime`.
        between: As in `mrts.scale`.
        progress: Told how far the work on an uncertain load is.

    Attributes:
        result: The range, or of a timing what is played, whose c² = 1 is the timing itself.
        timing: The timing that was found; None of the constant profile, and where there is none.
        refusal: Why there is no timing though one was asked for, in a sentence; empty if there is one.
        speeds: On offer.
        trajectory: The motion at the chosen speed.
        excess: Share by which a limit is overstepped at most at each sample, 0 for rounding, Shape (N,).
        sample: Index of the chosen time.
        is_saved: Whether it is that of a saved result.

    Raises:
        MrtsError: As `mrts.scale`; an infeasible motion is no error.
    """

    result: ScalingResult
    timing: RetimingResult | None
    refusal: str
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
        profile: Profile = "constant",
        rates: Rates = False,
        between: float | None = BETWEEN,
        progress: Progress = lambda _done, _total: None,
    ) -> None:
        self.sample, self.profile = 0, profile
        self.timing, self.refusal, self.is_saved = None, "", False
        asked: dict[str, Any] = {"sharing": sharing, "closure": closure, "between": between, "progress": progress}
        if profile == "constant":
            self.result = _scaled(cell, motion, solver, asked)
            self.speeds = offered_speeds(self.result.range)
        else:
            found = retime(cell, motion, rates=rates if profile == "smooth" else False, **asked)
            self._take_timing(found)
        self._play(self.speeds.c2(self.speeds.start))

    def _take_timing(self, found: RetimingResult) -> None:
        if found.retimed is None:
            self.refusal, self.result = found.sentence(), found.factor
            self.speeds = offered_speeds(self.result.range)
        else:
            self.timing, self.result, self.speeds = found, found.retimed, OF_TIMINGS
            found.factor, found.retimed.range.samples  # noqa: B018 (found here, not by whoever shows them)

    @classmethod
    def saved(cls, result: ScalingResult) -> "PlayerState":
        """A result that was read from a file, at its own speed: other torques take the functions of its cell."""
        done = result.trajectory
        assert done is not None  # noqa: S101 (what is shown has one)
        state = cls.__new__(cls)
        state.sample, state.profile, state.timing, state.refusal, state.is_saved = 0, "constant", None, "", True
        state.result, state.speeds = result, Speeds({}, done.c, done.c, 1.0, done.c)
        state._take(done)  # noqa: SLF001 (its own)
        return state

    @property
    def scene(self) -> Scene:
        """What is drawn of it."""
        return Scene.of(self.trajectory, self.excess > 0)

    @property
    def played(self) -> ScalingResult:
        """The result with the trajectory at the chosen speed, whether or not that is admissible."""
        done, result = self.trajectory, self.result
        return replace(result, found=result.range, c2=done.c2, trajectory=done)

    @property
    def card(self) -> Card:
        """The answer in one line, and the limits that are nearest; where no speed is admissible, why."""
        if self.timing is not None and self.trajectory.c2 == 1:
            return answer_card(self.timing)
        return answer_card(self.played if self.result.status.admits_motion else self.result)

    @property
    def deciding(self) -> DecidingLimit | None:
        """The limit that decides how fast the motion may be played."""
        return deciding_limit(self.trajectory, self.result.range)

    def sentence(self) -> str:
        """The outcome in a sentence."""
        found = self.result if self.timing is None else self.timing
        return self.refusal or found.sentence()

    def at_speed(self, c: float) -> "PlayerState":
        """The same outcome played at another speed: torques are distributed anew; this state stays as it is.

        Raises:
            InputError: As `choose_speed`.
            SolverError: If no solver answers.
        """
        other = copy(self)
        other.choose_speed(c)
        return other

    @property
    def time(self) -> float:
        """Of the chosen sample, at the chosen speed [s]."""
        return float(self.trajectory.time[self.sample])

    @property
    def admissible(self) -> bool:
        """Whether the chosen speed is in the range; a smooth timing keeps its rates at its own speed only."""
        if self.timing is not None and self.trajectory.c2 == 1:
            return True
        return self._admits(self.trajectory.c2)

    def choose_time(self, time: float) -> None:
        """Go to the sample nearest to a time at the chosen speed [s]."""
        self.sample = int(np.argmin(np.abs(self.trajectory.time - time)))

    def choose_speed(self, c: float) -> None:
        """Play at another speed: torques are distributed anew.

        Args:
            c: Factor of speed; one within half a step of an end of the range is that end.

        Raises:
            InputError: Unless it is finite, > 0, and at least a thousandth of the least on offer; if the state is that
                of a saved result, and has another speed.
            SolverError: If no solver answers.
        """
        if self.is_saved and c != self.trajectory.c:
            raise InputError("c", "a saved result is played as it was saved: view the cell and its motion.", value=c)
        least = 1e-3 * self.speeds.lower  # far below, c² and what is divided by it leave the range of numbers
        if not (isfinite(c) and c >= least):
            raise InputError("c", f"must be finite and >= {least:.3g}.", value=c)
        if not self.is_saved:
            self._play(self.speeds.c2(c))

    def bars(self) -> dict[str, dict[str, list[Bar]]]:
        """What is limited at the chosen time, by kind and robot; of what a hand holds, the worst direction in %."""
        rows, at = self._rows, self.sample
        value, lower, upper, used = (part[at] for part in (self._value, self._lower, self._upper, self._used))
        found: dict[str, dict[str, list[Bar]]] = {}
        holds: dict[tuple[str, str], float] = {}
        for row, name in enumerate(rows.names):
            bars = found.setdefault(name.kind, {}).setdefault(name.robot, [])
            if name.kind == "contact":
                of = name.robot, DIRECTION.sub("", name.element)
                holds[of] = max(float(used[row]), holds.get(of, 0.0))
            else:
                bars.append(Bar(name.element, float(value[row]), float(lower[row]), float(upper[row]), name.unit))
        for (robot, what), share in holds.items():
            found["contact"][robot].append(Bar(what, 100 * share, -np.inf, 100.0, "%"))
        return found

    def violations(self) -> list[Violation]:
        """Limits that are passed at some sample, the worst first."""
        worst, samples = np.max(self._beyond, axis=0), np.argmax(self._beyond, axis=0)
        found = [
            Violation(name, float(share), float(self.trajectory.time[sample]))
            for name, share, sample in zip(self._rows.names, worst, samples, strict=True)
            if share > LIMIT_TOLERANCE
        ]
        return sorted(found, key=lambda one: -one.excess)

    def joints_beyond_velocity(self) -> int:
        """How many joints pass their velocity limit at some time."""
        rows = [name.kind == "velocity" and name.robot != "object" for name in self._rows.names]
        return int(np.count_nonzero(np.any(self._beyond[:, rows] > LIMIT_TOLERANCE, axis=0)))

    def _admits(self, c2: float) -> bool:
        """Whether a c² is in the range, or in a lower interval."""
        result = self.result
        found = result.range
        if found.lower is None or not found.status.admits_motion or c2 >= found.lower.c2:
            return found.admitted(c2, 0.0) is not None
        return conflict_at(result, c2) is None

    def _play(self, c2: float) -> None:
        result = self.result
        cell, motion, options = result.cell, result.motion, result.options
        if self.timing is not None and c2 == 1:
            assert result.trajectory is not None  # noqa: S101 (a timing has torques)
            torque, wrench = result.trajectory.torque, result.trajectory.wrench
        elif self._admits(c2):
            rows = motion_rows(cell, motion, options.sharing, options.formulation)
            torque, wrench, _ = distributed_torques(rows, options, c2)
        else:
            torque, wrench = widened_torques(cell, motion, options, c2)
        self._take(ScaledTrajectory(cell, motion, c2, torque, wrench))

    def _take(self, done: ScaledTrajectory) -> None:
        """What a trajectory makes of all limits, and how far it passes those that are kept."""
        rows = self._rows = all_rows(done.cell, done.motion)
        value = rows.value(done.torque, done.wrench, 0.0, done.c)
        moving = np.broadcast_to(rows.moving(done.c), value.shape)  # what the speed takes of a motor's torque
        self._value, self._lower, self._upper = value - moving, rows.lower - moving, rows.upper - moving
        self._used, self._beyond = rows.share(value), rows.excess(value)
        kept = limit_rows(done.cell, done.motion)
        excess = np.max(kept.excess(kept.value(done.torque, done.wrench, 0.0, done.c)), axis=1, initial=0.0)
        self.trajectory, self.excess = done, np.where(excess > LIMIT_TOLERANCE, excess, 0.0)


def _scaled(cell: Cell, motion: ObjectMotion | JointTable, solver: str, asked: dict[str, Any]) -> ScalingResult:
    """The range; where nothing is selected too."""
    try:
        return scale(cell, motion, solver=solver, **asked)
    except SelectionError as error:  # the cell can only hold still, or c = 1 is too slow where nothing is too fast
        if error.result is None:
            raise
        return error.result
