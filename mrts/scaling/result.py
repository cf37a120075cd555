# SPDX-License-Identifier: MIT
"""The outcome of scaling: range, trajectory, and the checks that it passes on itself."""

from abc import abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.atomic_file import JsonOutput
from mrts.base.errors import Progress, Remark, check_callable, printable
from mrts.base.load_box import LoadPoint
from mrts.base.notebook import InNotebooks, NotebookTable
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits import limit_rows
from mrts.limits.rows import LimitRows, RowName
from mrts.program.between_samples import Excess
from mrts.program.range_status import RangeStatus
from mrts.program.reserve import Reserve, plan_reserve
from mrts.program.sample_problem import BLOCK
from mrts.scaling.options import Options
from mrts.scaling.range import LoadStudy, ScalingRange, range_at_samples
from mrts.scaling.remarks import plan_remarks
from mrts.scaling.scaled_trajectory import LimitUse, ScaledTrajectory, by_share, limits_table
from mrts.scaling.what_if import SpeedQuestion, WhatIf, what_if

AT_END = 1e-6
"""Share of c² within which it is at an end of what a sample admits: ends that tie are right to 1e-7."""

END_TOLERANCE = 1e-7
"""Share by which c² may miss a range by rounding: a plan at its fastest read back from a file, another load's range."""

LIMIT_TOLERANCE = 1e-8
"""Largest excess over a limit that counts as rounding and the widening of the programs, as a share of it."""


Remarks = tuple[Remark, ...] | Callable[[], tuple[Remark, ...]]
"""What to know of a cell and a motion, or what finds it."""


@dataclass(frozen=True)
class Residuals:
    """How far a trajectory is from what it promises: rounding, and at most 1e-9 of a limit.

    Attributes:
        limits: Largest excess over (8) and (24), as a share of the limit; up to 1e-9 is the programs' widening.
        arms: Largest residual of the arms' dynamics (13) [N m].
        object: Largest residual of the object's dynamics (20) [N, N m].
    """

    limits: float
    arms: float
    object: float


class Result(InNotebooks, JsonOutput):
    """What is said alike of a range of c² and of a timing."""

    cell: Cell
    options: Options
    changes: WhatIf | None

    @property
    @abstractmethod
    def warnings(self) -> tuple[Remark, ...]:
        """What to know of the cell and the motion before trusting the answer."""

    @abstractmethod
    def sentence(self) -> str:
        """The outcome alone."""

    @property
    @abstractmethod
    def uses(self) -> list[LimitUse]:
        """How much of each limit is used, rates too, by falling share; nothing without a trajectory."""

    @abstractmethod
    def setting_rows(self) -> list[RowName]:
        """What sets the speed; nothing without a trajectory.

        Another row that is at its limit need not set it: it may be there by how the load is distributed.
        """

    @abstractmethod
    def speed_question(self) -> SpeedQuestion:
        """What `what_if` asks of every changed cell."""

    def what_if(self, *, progress: Progress = lambda _done, _total: None) -> WhatIf:
        """What changes to the cell would do to the speed, each by itself, solved again at the samples of the result.

        Both sides of each limit, the mass and a reserve are changed by 10 % up and down; each arm's base is moved 10 mm
        along and turned 1° about world axes through its origin, each grasp along and about the object's axes, and the
        arms follow again. Limits of rates, and the cell's further limits, stay as they are.

        Args:
            progress: Told how many of how many changes are done.

        Raises:
            InputError: If the result is that of a retimed motion, of a possible load, or of a timing with limits of
                rates.
            SolverError: If no solver answers.
        """
        check_callable("progress", progress)
        return what_if(self.speed_question(), progress)

    def limits_table(self) -> NotebookTable:
        """All limits by falling share that is used, those that set the speed first."""
        return limits_table(self.uses, self.setting_rows())

    def notebook_tables(self) -> Iterator[NotebookTable]:
        """What is made of each limited quantity."""
        yield self.limits_table()

    def summary(self) -> str:
        """The outcome in one or two sentences, and a line for each warning."""
        return "\n".join([self.sentence(), *map(str, self.warnings)])

    def notebook_words(self) -> list[str]:
        """The outcome, and a line for each warning."""
        return [f"{self.cell.name}: {self.sentence()}", *map(str, self.warnings)]

    def said_json(self) -> dict[str, Any]:
        """Entries of the JSON result that every outcome has."""
        changes = {} if self.changes is None else {"what_if": self.changes.to_json()}
        weights = None if self.options.weights is None else np.asarray(self.options.weights).tolist()
        return {
            "cell": self.cell.name,
            "summary": self.sentence(),
            "warnings": [warning.to_json() for warning in self.warnings],
            "distribute": self.options.distribute,
            "weights": weights,
            "kept_reserve": self.cell.reserve,
            **changes,
        }


@dataclass(frozen=True, repr=False)
class ScalingResult(Result):
    """What `mrts.scale` found.

    Attributes:
        cell: The cell.
        motion: The given motion of the whole cell.
        found: The admissible range of c², with the reason where there is none; None where it was not asked for.
        c2: Chosen c²; None if none is admissible.
        trajectory: The motion at the chosen c² with its torques; None where they were not distributed.
        load: What was asked of an uncertain load; None if the load is known.
        options: What was asked.
        origin: What was done to the motion before, for people; empty if nothing.
        remarks: What to know of the cell and the motion, or what finds it: it costs a tenth of a short call.
        excess: How far limits are overstepped between the samples; None if that was not looked at.
        changes: What changes to the cell would do, from `what_if`, where it is to be shown and saved with the result.
    """

    cell: Cell
    motion: CoordinatedMotion
    found: ScalingRange | None
    c2: float | None
    trajectory: ScaledTrajectory | None
    load: LoadStudy | None = None
    options: Options = field(default_factory=Options)
    origin: str = ""
    remarks: Remarks = field(default=(), compare=False)
    excess: Excess | None = None
    changes: WhatIf | None = None

    @cached_property
    def range(self) -> ScalingRange:
        """The admissible range of c², with the reason where there is none; at the samples where it was not asked for.

        Raises:
            SolverError: If no solver answers.
        """
        return self.found or range_at_samples(self.options.rows(self.cell, self.motion), self.options)[0]

    @cached_property
    def warnings(self) -> tuple[Remark, ...]:
        """What to know of the cell and the motion, and of the plan's torques, before trusting the answer."""
        remarks = self.remarks() if callable(self.remarks) else self.remarks
        if self.trajectory is not None:
            remarks += plan_remarks(self.trajectory, self.uses, rated=self.options.rates is not None)
        return tuple(dict.fromkeys(remarks))

    def __repr__(self) -> str:
        done = self.trajectory
        chosen = "" if done is None else f" Chosen: c² = {done.c2:.4g}, {done.duration:.4g} s."
        return f"<ScalingResult of cell '{self.cell.name}': {self.sentence()}{chosen}>"

    @property
    def done(self) -> ScaledTrajectory:
        """The trajectory.

        Raises:
            ValueError: If there is none.
        """
        if self.trajectory is None:
            raise ValueError("there is no trajectory: no c² was chosen")
        return self.trajectory

    @property
    def uses(self) -> list[LimitUse]:
        """How much of each limit is used, rates too, by falling share; nothing without a trajectory."""
        return [] if self.trajectory is None else by_share([*self.trajectory.limit_uses, *self.rate_uses])

    def setting_rows(self) -> list[RowName]:
        """What ends the range at c²; nothing of a retimed motion, whose timing tells it."""
        ends = () if self.c2 is None or self.origin else self.range.ends_at(self.c2, AT_END)
        return [row.name for _, end in ends for row in end.rows]

    @cached_property
    def rate_uses(self) -> list[LimitUse]:
        """How much of each limit of rates is used, those that are kept or else the cell's."""
        done = self.trajectory
        return [] if done is None else by_share(done.limited_rates(self.options.rates).uses(done.time))

    @property
    def status(self) -> RangeStatus:
        """The outcome."""
        return self.range.status

    @property
    def torque(self) -> dict[str, Array]:
        """Joint torques by robot, each Shape (N, n_i) [N m or N]; empty if there is no trajectory."""
        done = self.trajectory
        return {} if done is None else {name: done.torque[:, part] for name, part in self.cell.joint_slices.items()}

    @property
    def wrench(self) -> dict[str, Array]:
        """Contact wrenches by robot in base axes, each Shape (N, w) [N, N m]; empty if there is no trajectory."""
        done = self.trajectory
        return {} if done is None else {name: done.wrench[:, part] for name, part in self.cell.wrench_slices.items()}

    @property
    def duration(self) -> float | None:
        """Of the motion at the chosen c² [s]; None without one."""
        return None if self.c2 is None else float(self.motion.object.time[-1] / np.sqrt(self.c2))

    @property
    def loads(self) -> tuple[LoadPoint | None, ...]:
        """Loads that the range must carry; None for the cell's."""
        return (None,) if self.load is None else self.load.points

    @cached_property
    def reserve(self) -> Reserve | None:
        """By how much limits may shrink before c² is not admissible; None if there is no trajectory.

        Whatever the distribution, and for all loads that were asked about. Found when it is asked for.

        Raises:
            SolverError: If no solver answers.
        """
        if self.trajectory is None:
            return None
        rows = self.options.rows(self.cell.with_reserve(0.0), self.motion)
        return plan_reserve(rows, self.trajectory.c2, self.loads)

    def at_rate(self, rate: float) -> "ScalingResult":
        """The plan at the rate of a controller: the same motion at equal steps, with torques found there.

        It takes up to one step longer, so that it ends on one, and longer still where limits ask for it at these
        samples or between them: rows of another rate are another course.

        Args:
            rate: Of the samples [Hz].

        Raises:
            InputError: If there is no trajectory, the rate is no number that suits it, or an internal wrench is given
                for each sample.
            MotionError: If the arms cannot hold the object there.
            SelectionError: If no plan near it keeps the limits.
            SolverError: If no solver answers.
        """
        from mrts.scaling.scale import at_rate  # noqa: PLC0415 (it scales, which makes results)

        return at_rate(self, rate)

    def speed_question(self) -> SpeedQuestion:
        """How fast a changed cell may play the motion, by one factor."""
        from mrts.scaling.scale import range_question  # noqa: PLC0415 (it makes results)

        return range_question(self)

    def sentence(self) -> str:
        """The outcome alone."""
        rated = "" if self.options.rates is None else "rates apart, " if self.origin else "within the rates, "
        text = f"{kept_text(self.cell.reserve)}{rated}{self._outcome()}"
        text = text if self.load is None else f"{self.load.sentence()}: {text}"
        return printable(f"{self.origin}; as it is now, {text}" if self.origin else text)

    def _outcome(self) -> str:
        found = self.range
        if not found.status.admits_motion:
            return f"{found.status.value}: {found.explain()}"
        least = found.lower.c2
        below = f"below {found.lower.place()}" if least > 0 else ""
        if found.upper.time is None:
            return f"c² ∈ {found.text()}: {found.status.advice}" + (f" Limited {below}." if below else "")
        several = found.samples.several
        speed = _speed_advice((least, found.upper.c2), self.motion.object.time[-1], several=several)
        limits = f"above {found.upper.place()}, {below}" if below else found.upper.place()
        advice = "" if self.origin else f": {speed}"  # of the fastest timing there is none to give
        passed = f"; but {self.excess}" if self.excess is not None and self.excess.passes else ""
        return f"c² ∈ {found.text()}{advice}; limited {limits}{passed}."

    def residuals(self) -> Residuals:
        """Check the trajectory against (8), (13), (20) and (24), from the terms and not from the programs.

        Raises:
            ValueError: If there is no trajectory.
        """
        done = self.done
        arms, carried = (float(np.max(np.abs(of))) for of in (done.torque - done.inverse_dynamics, done.unbalanced))
        return Residuals(largest_excess(limit_rows(self.cell, self.motion), done), arms, carried)

    def to_json(self) -> dict[str, Any]:
        """The result as JSON values; null stands for an unbounded end."""
        samples = self.range.samples
        output: dict[str, Any] = {
            **self.said_json(),
            "explanation": self.range.explain() or None,
            "kept_rates": self.options.rates and self.options.rates.to_json(),
            **self.range.to_json(),
            "samples": samples.to_json(),
            "conflicts": [conflict.to_json() for conflict in samples.conflicts],
        }
        if self.load is not None:
            output["load"] = self.load.to_json()
        if self.trajectory is not None:
            load = LoadPoint({}, self.trajectory.cell.load).to_json()["load"]
            output |= {
                "selected": {"c2": self.c2, "duration": self.duration, "load": load},
                "reserve": self.reserve and self.reserve.to_json(),
                "excess": self.excess and self.excess.to_json(),
                **self.played_json(self.trajectory),
            }
        return output

    def played_json(self, done: ScaledTrajectory) -> dict[str, Any]:
        """Entries of the JSON result of a trajectory of this cell."""
        return done.to_json() | {"rates": [use.to_json() for use in self.rate_uses]}


def kept_text(reserve: float) -> str:
    """The beginning of an answer where all limits keep a reserve."""
    return f"with {100 * reserve:.4g} % of every limit in reserve, " if reserve else ""


def largest_excess(rows: LimitRows, done: ScaledTrajectory) -> float:
    """Largest excess over limits along a trajectory, in `LimitRows.units`; 0 within them all."""
    worst = 0.0
    for start in range(0, len(done.torque), BLOCK):
        part = slice(start, start + BLOCK)
        here = rows.at(part)
        excess = here.excess(here.value(done.torque[part], done.wrench[part], 0.0, done.c))
        worst = float(np.maximum(worst, excess.max(initial=0.0)))  # not max: it would drop what is no number
    return worst


def _speed_advice(ends: tuple[float, float], given: float, *, several: bool) -> str:
    (least, most), (slow, fast) = ends, np.sqrt(ends)
    if most <= 0:
        return "the cell can hold the object still at every sample, but not move it along this path"
    factors, times = f"{fast:.3g} × as fast as given", f"{given / fast:.4g} s instead of {given:.4g} s"
    if least <= 0:
        allowed = "may play it up to" if most >= 1 - END_TOLERANCE else "must play it at most"
        return f"you {allowed} {factors}: {times}"
    verb = "may" if several or least <= 1 <= most else "must"
    slower = "; whether it may be played slower has to be asked for each c²" if several else ""
    return f"you {verb} play it {slow:.3g} to {factors}: {given / slow:.4g} to {times}{slower}"
