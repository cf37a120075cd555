# SPDX-License-Identifier: MIT
"""MMTSF, the paper's algorithm, whole: range, choice of c², torques; and its outcome."""

from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.atomic_file import JsonOutput
from mrts.base.errors import (
    InputError,
    MrtsError,
    Progress,
    Remark,
    SolverError,
    check_callable,
    check_type,
    is_number,
    printable,
)
from mrts.base.load_box import LoadPoint
from mrts.base.notebook import InNotebooks, NotebookTable
from mrts.cell.cell import Cell
from mrts.following.coordinate import ClosureBound, coordinate
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import between_samples
from mrts.limits import Limit, limit_rows
from mrts.limits.rows import LimitRows, RowName, rows_text
from mrts.motion.joint_table import NO_SPEED, JointTable, joint_contradictions
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.rows_at_rest import pushing_ends
from mrts.program.between_samples import BETWEEN, Excess, refine
from mrts.program.formulation import DistributionName, FormulationName
from mrts.program.infeasibility import Conflict, conflicts_at, motion_widening
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import MotionRows
from mrts.program.rate_limits import Rates, rate_limits
from mrts.program.reserve import Reserve, plan_reserve
from mrts.program.sample_problem import BLOCK, build_sample_problem
from mrts.program.sample_ranges import POINT_TOLERANCE, RangeStatus, SampleRanges
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.program.torque_distribution import TORQUE_WIDENING, motion_torques, torque_weights
from mrts.scaling.constant_rates import RatedFactors, torques_within_rates
from mrts.scaling.options import Options, limited_cell
from mrts.scaling.range import LoadStudy, ScalingRange, range_at_samples
from mrts.scaling.remarks import interpolated, motion_remarks, plan_remarks
from mrts.scaling.scaled_trajectory import Holding, LimitUse, ScaledTrajectory, by_share, limits_table
from mrts.scaling.what_if import NO_CHANGE, SpeedAnswer, SpeedQuestion, WhatIf, what_if

END_TOLERANCE = 1e-7
"""Share by which c² may miss a range by rounding: a plan at its fastest read back from a file, another load's range."""

LIMIT_TOLERANCE = 1e-8
"""Largest excess over a limit that counts as rounding and the widening of the programs, as a share of it."""

MOST_ROWS = 1_000_000
"""Of a plan: as many as a table may have that is read."""

ATTEMPTS = 10
"""Durations that are tried, each by what the one before passed its limits."""

WHOLE = 1e-9
"""Share of a step by which a duration may miss a whole number of steps: rounding."""

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

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of cell '{self.cell.name}': {self.sentence()}>"

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
    found: ScalingRange | None = None
    c2: float | None = None
    trajectory: ScaledTrajectory | None = None
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
        if self.c2 is None or self.origin or not self.range.status.admits_motion:
            return []
        ends = [end for end in (self.range.lower, self.range.upper) if end.is_at(self.c2)]
        return [row.name for end in ends for row in end.rows]

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

    def admitted(self, c2: float, tolerance: float = 0.0) -> float | None:
        """The admissible c² that a given one stands for: itself, or an end that it misses by a share; None without one.

        Where samples admit several intervals, slower ones than the range are looked at too.
        """
        found = self.range
        low, high = found.lower.c2, found.upper.c2
        if found.status.admits_motion and low * (1 - tolerance) <= c2 <= high * (1 + tolerance):
            return min(max(c2, low), high)
        return c2 if found.samples.several and c2 < low and conflict_at(self, c2) is None else None

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
        done, options = self.trajectory, replace(self.options, load="nominal", select=1.0, rates=None)
        if done is None:
            raise InputError("rate", "there is no trajectory to sample: no c² was chosen.", value=rate)
        if not is_number(rate, 1 / done.duration, MOST_ROWS / done.duration):
            rule = f"must be a number of rows per second, of which {done.duration:.4g} s have 1 to {MOST_ROWS}."
            raise InputError("rate", rule, value=rate)
        if options.sharing is not None and options.sharing.varies:
            rule = "an internal wrench that is given for each sample is not known at others."
            raise InputError("rate", rule, value=rate)
        steps, refused = int(np.ceil(done.duration * rate * (1 - WHOLE))), MrtsError("")
        for _ in range(ATTEMPTS):
            motion = _sampled(self, steps, float(rate))
            found, _, excess_at = admissible_range(done.cell, motion, options)
            ends, c2 = found.range, found.admitted(1.0, END_TOLERANCE)
            if c2 is None:
                refused = SelectionError(f"at {rate:g} Hz: {found.sentence()}", found)
                least, most = ends.lower.c2, ends.upper.c2
                slower = int(np.ceil(steps / np.sqrt(most))) if most > 0 else 0
                steps = int(steps / np.sqrt(least)) if 1 < least < np.inf else max(steps + 1, slower)
                continue
            own_range = ends if found.motion is motion else None
            excess = excess_at and excess_at(c2)
            own = replace(options, rates=self.options.rates)
            plan = replace(found, motion=motion, found=own_range, c2=c2, options=own, excess=excess)
            try:
                sampled = with_torques(plan)  # of its own rows alone, whatever was looked at
            except SolverError as error:  # where rates do not suit
                steps, refused = steps + 1, error
                continue
            played = sampled.trajectory
            assert played is not None and played.holding is not None  # noqa: S101, PT018 (c² is in the range)
            played = replace(played, holding=replace(played.holding, rate=float(rate)))
            return replace(sampled, trajectory=played, origin=f"sampled at {rate:g} Hz")
        raise refused

    def speed_question(self) -> SpeedQuestion:
        """The range of c² of a changed cell, at the samples of this result.

        Raises:
            InputError: If the result is that of another speed, or of what is possible with some load.
        """
        if self.origin:
            why = "is of a motion that was retimed: ask what mrts.retime found, or scale the motion as it was given."
            raise InputError("result", why)
        cell, study = self.cell, self.load
        options = replace(self.options, between=None)
        if options.load == "possible":
            why = "is of what is possible with some load, which no change is asked of: ask for the guaranteed range."
            raise InputError("result", why, value=options.load)
        if study is not None:
            cell = replace(cell, load=study.box.nominal_point().load, load_box=study.box)

        known = study is None and options.rates is None

        def answer(changed: Cell, motion: CoordinatedMotion, before: SpeedAnswer | None) -> SpeedAnswer:
            found = admissible_range(changed, motion, options)[0].range
            if known and before and before.c2 is not None and np.isclose(found.c2_upper, before.c2, NO_CHANGE, 0):
                return before  # to find which rows bind takes longer than to see that the range stays
            status, upper = found.status, found.upper
            if not status.admits_motion:
                return SpeedAnswer(status=status.value, reason=found.reason())
            duration = float(motion.object.time[-1] / np.sqrt(upper.c2)) if upper.c2 > 0 else np.inf
            limits = tuple(dict.fromkeys(row.name.short for row in upper.rows))
            return SpeedAnswer(status=status.value, c2=upper.c2, duration=duration, limits=limits)

        return cell, self.motion, answer

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


class SelectionError(MrtsError):
    """The requested c² is not in the admissible range, or no single value answers the request.

    Attributes:
        result: The result with the range that was found.
    """

    def __init__(self, message: str, result: ScalingResult) -> None:
        super().__init__(message)
        self.result = result

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (str(self), self.result)


def scale(
    cell: Cell,
    motion: ObjectMotion | JointTable | CoordinatedMotion,
    select: float | None = None,
    *,
    sharing: LoadSharing | None = None,
    formulation: FormulationName = "wrench",
    weights: Array | float | None = None,
    solver: str = DEFAULT_SOLVER,
    load: str = "auto",
    distribute: DistributionName = "least-torque",
    reserve: float | None = None,
    limits: Sequence[Limit] | None = None,
    closure: ClosureBound | None = None,
    between: float | None = BETWEEN,
    rates: Rates = False,
    progress: Progress = lambda _done, _total: None,
) -> ScalingResult:
    """Find the admissible range of c², choose c² and distribute the torques (steps 1 to 5 of MMTSF).

    Args:
        cell: The cell.
        motion: Motion of the object, a table of joint motion, or motion of the whole cell.
        select: c², 1 as the motion is given; None takes c²⁺, or 1 where nothing limits the speed.
        sharing: A fixed distribution of the load; None leaves it to the quadratic program.
        formulation: "wrench", or the paper's "torque".
        weights: W of the quadratic program: None weighs each torque by its limit, diag(1 / τ̂²), so that weak joints are
            spared; 1 weighs all alike, as in the paper; else the diagonal, Shape (m,), or the matrix, Shape (m, m).
        solver: Name in the registry of solvers.
        load: Which range is asked for where the load varies: "guaranteed" (for every load), "possible" (for some
            load), "grid:N" (for N masses), or "nominal". "auto" is "guaranteed" if the cell has a load box. Torques
            are those of the nominal load; "possible" has none, as it leaves open which load it is.
        distribute: What redundant torques are chosen by: "least-torque", or "reserve", which first makes the largest
            share of any limit as small as can be at each sample.
        reserve: Share of every limit that is kept free, 0 or more and below 1; None is the cell's own.
        limits: Functions of a cell and its motion that give further `mrts.limits.rows.LimitRows`, as in
            `Cell.with_limits`; docs/extending.md. None is the cell's own.
        closure: How far given joints may be off their grasps; None allows 2 mm and 5 mrad.
        between: Share of a limit by which it may be overstepped between the samples; samples are added where it takes
            them. None looks at the given samples alone.
        rates: Whether torques, accelerations and contact wrenches may only change at limited rates: True for the limits
            of the cell, a number for the torque rate of the joints that have none, as a multiple of their torque limit
            [1/s]; docs/real_cell.md. Rates are those between neighbouring samples. The torques are then chosen for the
            whole motion at once, by the least ∫ τᵀWτ dt.
        progress: Told how many of how many pieces of work on an uncertain load are done.

    Returns:
        The outcome. An infeasible motion is an outcome: see `ScalingResult.range`.

    Raises:
        InputError: If an argument breaks a rule.
        MotionError: If the arms cannot follow the object.
        SelectionError: If c² is not in the range; its `result` holds the range.
        SolverError: If no solver answers.
    """
    check_callable("progress", progress)
    check_type("cell", cell, Cell)
    cell = limited_cell(cell, reserve, limits)
    options = Options(
        select=select,
        sharing=sharing,
        formulation=formulation,
        weights=weights,
        solver=solver,
        load=load,
        distribute=distribute,
        between=between,
        rates=None if rates is False else rate_limits(cell, rates),
    ).checked(cell)
    given = coordinate(cell, motion, closure)
    if given.untimed:
        raise InputError("motion", NO_SPEED)
    chosen, rows = chosen_factor(cell, given, options, progress)
    return with_torques(chosen, rows=rows)


def chosen_factor(
    cell: Cell, motion: CoordinatedMotion, options: Options, progress: Progress = lambda _done, _total: None
) -> tuple[ScalingResult, MotionRows]:
    """Steps 1 to 3 of MMTSF, `scale` before the torques are distributed: the result, and the limits along its motion.

    Raises:
        MotionError: If the arms cannot hold the object between the samples.
        SelectionError: If c² is not in the range; its `result` holds the range.
        SolverError: If no solver answers.
    """
    result, rows, excess = admissible_range(cell, motion, options, progress)
    if not result.range.status.admits_motion or options.load == "possible":
        return result, rows
    c2 = choose_c2(result, rows)
    return replace(result, c2=c2, excess=excess and excess(c2)), rows


def admissible_range(
    cell: Cell, motion: CoordinatedMotion, options: Options, progress: Progress = lambda _done, _total: None
) -> tuple[ScalingResult, MotionRows, Callable[[float], Excess] | None]:
    """The range of c² of a motion within its rates (steps 1 and 2 of MMTSF), between its samples too.

    For what is possible with some load, and with an internal wrench a sample, only the given samples are looked at.

    Returns:
        A result without a c², of the motion with the samples that were added, the limits along it, and what was found
        between the samples; None if that was not looked at.

    Raises:
        InputError, MotionError, SolverError: As `scale`.
    """
    rows = options.rows(cell, motion)
    found, study = range_at_samples(rows, options, progress)
    excess, told = None, tuple[Remark, ...]()
    prescribed = options.sharing is not None and options.sharing.varies
    if options.between is not None and options.load != "possible" and not prescribed and found.status.admits_motion:
        ends = found.lower.c2, found.upper.c2

        def ranges(there: MotionRows) -> SampleRanges:
            return range_at_samples(there, options, high=ends[1])[0].samples

        refined, excess = refine(rows, found.samples, ends, ranges, options.between)
        if refined is not motion:
            given, rows = found, rows.along(refined)
            found, study = range_at_samples(rows, options, progress)
            if 0 < given.c2_upper < np.inf:
                told = interpolated(motion, 1 - max(found.c2_upper, 0.0) / given.c2_upper, "c²⁺ {} less")
    if options.rates is not None and found.status.admits_motion:

        def below(high: float) -> ScalingRange:
            return range_at_samples(rows, options, high=high * (1 + POINT_TOLERANCE))[0]

        loads = (None,) if study is None else study.points
        found = RatedFactors(rows, loads, options.rates).within(found, below)
    remarks = partial(motion_remarks, cell, motion, rows.motion, told, constant=True)
    return ScalingResult(cell, rows.motion, found, load=study, options=options, remarks=remarks), rows, excess


def conflict_at(result: ScalingResult, c2: float) -> Conflict | None:
    """What forbids a c², at the sample where limits would have to move outward the most; None if nothing does.

    There all rows are linear, and no interval has to be known.
    """
    motion, worst = result.motion, None
    rows = result.options.rows(result.cell, motion)
    for point in result.loads:
        load = None if point is None else point.load
        share = motion_widening(rows, np.full(motion.samples, c2), load)
        sample = np.array([np.argmax(share)])
        problem = build_sample_problem(rows, load=load, samples=sample)
        (found,) = conflicts_at(problem, np.array([c2]), motion.object.time[sample])
        if found is not None and (worst is None or found.widening > worst.widening):
            worst = replace(found, sample=int(sample[0]), load=point, c2=c2)
    return worst


def choose_c2(result: ScalingResult, rows: MotionRows) -> float:
    """Step 3.1 of MMTSF: choose c² in the admissible range of a result, as its options say.

    Raises:
        SelectionError: If the value is not admissible, not finite, or not above 0.
    """
    found, select, rates = result.range, result.options.select, result.options.rates

    def refused(why: str) -> SelectionError:
        return SelectionError(f"{kept_text(result.cell.reserve)}c² ∈ {found.text(digits=6)}: {why}", result)

    if select is None and found.status is not RangeStatus.UNBOUNDED:
        if found.upper.c2 <= 0:
            raise refused(f"the cell can only hold still. The upper end is set {found.upper.place()}.")
        return found.upper.c2
    select = 1.0 if select is None else select
    c2 = float(select) if is_number(select) else np.inf
    if not 0 < c2 < np.inf:
        raise refused(f"{select} is no c² of a speed: it must be finite and > 0.")
    admitted = result.admitted(c2, END_TOLERANCE)
    if admitted is None:
        raise refused(f"c² = {c2:g} is outside this range{_passed(result, c2)}")
    if rates is not None and admitted not in {found.lower.c2, found.upper.c2}:
        binds = RatedFactors(rows, result.loads, rates).refused(admitted)
        if binds is not None:
            at = f"at t = {binds.time:.4g} s {rows_text(binds.rows)} would be passed."
            raise refused(f"c² = {admitted:g} lies in a gap that rates leave in this range: {at}")
    return admitted


def _passed(result: ScalingResult, c2: float) -> str:
    """What a c² outside the range passes."""
    found = result.range
    worst = conflict_at(result, c2) if found.samples.several and c2 < found.lower.c2 else None
    if worst is not None:
        at = f"at t = {worst.time:.4g} s{worst.with_load}"
        return f", and no slower one admits it: {at} {rows_text(worst.rows, '; ')} forbid it."
    side, end = ("lower", found.lower) if c2 < found.lower.c2 else ("upper", found.upper)
    return f". The {side} end is set {end.place()}."


def torques_for_load(result: ScalingResult, load: Array) -> ScalingResult:
    """Eqs. (47), (48), (49): the quadratic program with a known load k, at the c² of a result.

    At a c² of the guaranteed range every load of the box has such torques; motion and duration stay as they are. Limits
    of rates that the result keeps are kept.

    Args:
        result: A result with a trajectory.
        load: Load vector, Shape (10,), as from `LoadBox.load_at` or of `LoadBox.draw`.

    Returns:
        The same result with the torques of this load, distributed as the result's own.

    Raises:
        InputError: If the result has no trajectory or an argument breaks a rule.
        SelectionError: If this load cannot be carried at that c²; its `result` holds the range that it admits.
        SolverError: If no solver answers.
    """
    check_type("result", result, ScalingResult)
    if result.trajectory is None or result.c2 is None:
        raise InputError("result", "has no trajectory: no c² was chosen.", value=result.status.value)
    cell, options, c2 = result.cell.with_load(load), result.options, result.c2
    of_load = replace(options, load="nominal", between=None, rates=None)
    own, rows, _ = admissible_range(cell, result.motion, of_load)
    if own.admitted(c2, END_TOLERANCE) is None:
        why = own.sentence()
        if own.status.admits_motion:
            why = f"{kept_text(cell.reserve)}c² ∈ {own.range.text(digits=6)}{_passed(own, c2)}"
        raise SelectionError(f"c² = {c2:g} does not suit this load: {why}", own)
    # what is overstepped between the samples is convex in the load: of a box the corners tell it
    excess = result.excess if options.load == "guaranteed" else None
    try:
        return with_torques(replace(result, cell=cell, excess=excess), rows=rows)
    except SolverError as error:
        if options.rates is None:
            raise
        raise SelectionError(f"c² = {c2:g} does not suit this load where rates are kept: {error}", own) from None


def with_torques(
    result: ScalingResult, given: tuple[Array, Array] | None = None, rows: MotionRows | None = None
) -> ScalingResult:
    """A result with the torques of its options at its c², if it has one, and with what is to be said of them.

    Torques and wrenches may be `given`, Shape (N, m) and (N, n w), and the rows from `motion_rows`.

    Raises:
        SolverError: If no solver answers, or the torques overstep a limit.
    """
    cell, motion, options, c2 = result.cell, result.motion, result.options, result.c2
    if c2 is None:
        return result
    rows, W = rows or options.rows(cell, motion), torque_weights(options.weights, cell)
    if given is not None:
        torque, wrench = given
    elif options.rates is None:
        torque, wrench = motion_torques(rows, c2, W, options.distribute)
    else:
        torque, wrench = torques_within_rates(rows, options.rates, c2, W, options.distribute)
    done = ScaledTrajectory(cell, motion, c2, torque, wrench, _holding(options, rows, W))
    excess = largest_excess(rows.given, done)
    if not excess <= LIMIT_TOLERANCE:
        raise SolverError(
            f"the torques found overstep a limit by {excess:.2g} of it, more than {LIMIT_TOLERANCE:.0e}: the limits or "
            "the masses of this cell are too unlike in size to be solved."
        )
    return replace(result, trajectory=done)


def _holding(options: Options, rows: MotionRows, weights: Array) -> Holding:
    """What holds the object still at both ends, c² = 0, where a controller needs it and the limits admit it."""
    cell, motion = rows.cell, rows.motion
    held, places = np.array(pushing_ends(motion.dq, motion.ddq)), np.array([0, motion.samples - 1])
    torque, wrench = np.zeros((2, motion.q.shape[1])), np.zeros((2, len(cell.robots) * len(cell.wrench_components)))
    still = rows if rows.motors is None else replace(rows, motors=None)  # no friction opposes a motion
    if held.any():
        held &= motion_widening(still, np.zeros(2), None, places) <= TORQUE_WIDENING
    if held.any():  # where one end has none, the other stands for both
        kept = places[held][[0, -1]]
        found = motion_torques(still, 0.0, weights, options.distribute, kept)
        torque, wrench = (np.where(held[:, None], values, 0.0) for values in found)
    return Holding((bool(held[0]), bool(held[1])), torque, wrench)


def _sampled(result: ScalingResult, steps: int, rate: float) -> CoordinatedMotion:
    """The motion as it is played, at equal steps from its first sample to its last, slower by less than one of them."""
    assert result.trajectory is not None  # noqa: S101 (the caller has looked)
    given, time = result.motion, np.arange(steps + 1) / rate
    end = float(given.object.time[-1])
    some = between_samples(result.trajectory.cell, given, time[1:-1] * (end / time[-1]))
    c = end / float(time[-1])
    played = some.played(time, c)
    for found in joint_contradictions(result.cell.joint_names, time, played.q, played.dq, played.ddq):
        raise InputError("rate", f"is too low for this plan: {found}", value=rate)
    return played


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
