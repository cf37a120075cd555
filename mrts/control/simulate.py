# SPDX-License-Identifier: MIT
"""A plan played by a controller on an imperfect cell, what it makes of every limit, and the reserve that it takes."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import NoneType
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.atomic_file import JsonOutput
from mrts.base.errors import InputError, Progress, check_callable, check_type, is_number, printable, require_extra
from mrts.base.formats.record import dumped
from mrts.base.notebook import InNotebooks, NotebookTable
from mrts.base.words import aligned
from mrts.control.controller import Controller, PlantErrors
from mrts.control.plan_nodes import resting_trajectory, trajectory_of
from mrts.control.speed_override import SpeedOverride, commanded, wanted_at_ticks
from mrts.limits.rows import RowName
from mrts.program.rate_limits import Rates
from mrts.scaling.scale import ScalingResult
from mrts.scaling.scaled_trajectory import LimitUse, ScaledTrajectory
from mrts.timing.result import RetimingResult

STEP, FINEST = 1e-5, 1e-6
"""Of the simulation, at most, and at least where stiff grasps need a finer one [s]."""

MEASURED = 2.5e-4
"""From one measurement to the next, at most [s]: force sensors give up to 4000 a second."""

BEFORE, AFTER = 0.1, 0.2
"""Standstill before the motion, in which errors of load and friction settle, and after it [s]."""

PASSED = 1e-3
"""Share of a limit by which it may be passed: what the step of the simulation leaves."""

FINE = 20001
"""Points of the object's path from which its distance is measured: they are micrometres apart."""

NEAREST = 5
"""Limits that are printed, unless more are passed."""

MOST_TRIALS = 100_000

LIKELY = 95.0
"""Per cent of the trials that are told apart from the worst."""

RESERVE_WITHIN = 0.01
"""Of the least reserve, as a share of limits."""

MOST_PLANS = 16
"""That are tried: four or five halve what the first few leave."""


@dataclass(frozen=True)
class Trials:
    """The same plan on cells whose errors were drawn, T of them.

    Attributes:
        errors: Of each.
        shares: Largest share of every limit, Shape (T, r).
        saturated: Share of commands that were cut, Shape (T,).
    """

    errors: tuple[PlantErrors, ...]
    shares: Array
    saturated: Array

    @property
    def largest(self) -> Array:
        """Share of the limit of which most is used in each, Shape (T,)."""
        return np.asarray(np.max(self.shares, axis=1, initial=0.0))

    @property
    def kept(self) -> int:
        """How many keep all limits."""
        return int(np.sum(self.largest <= 1 + PASSED))

    @property
    def spread(self) -> Array:
        """The share of each limit within which 95 % of the trials stay, and the worst, Shape (2, r)."""
        return np.percentile(self.shares, [LIKELY, 100.0], axis=0)


@dataclass(frozen=True, kw_only=True, repr=False)
class Simulation(InNotebooks, JsonOutput):
    """What `mrts.simulate` found.

    Attributes:
        plan: What was to be played; under a speed override what that commanded.
        played: What became of it, until 0.2 s after its end, as measured: torques are those of the motors.
        controller: What played it.
        errors: Of the cell.
        saturated: Share of the motion's commands of which a motor's limit cut some joint's torque.
        trials: With drawn errors; None without.
    """

    plan: ScaledTrajectory
    played: ScaledTrajectory
    controller: Controller
    errors: PlantErrors
    saturated: float
    trials: Trials | None = None

    @cached_property
    def uses(self) -> tuple[tuple[LimitUse, LimitUse], ...]:
        """What the plan uses of each enforced limit, and what the simulation did, by falling share of that."""
        planned, used = kept_uses(self.plan), kept_uses(self.played)
        order = sorted(range(len(used)), key=lambda row: -used[row].share)
        return tuple((planned[row], used[row]) for row in order)

    @property
    def passed(self) -> tuple[LimitUse, ...]:
        """Limits that were passed, by falling share."""
        return tuple(used for _, used in self.uses if used.share > 1 + PASSED)

    @property
    def kept(self) -> bool:
        """Whether every limit is, in all trials too."""
        return not self.passed and (self.trials is None or self.trials.kept == len(self.trials.errors))

    @cached_property
    def joint_error(self) -> Array:
        """Of the joints against the plan, Shape (N, m) [rad or m]."""
        return np.asarray(self.played.q - self.plan.course()(np.minimum(self.played.time, self.plan.duration)))

    @cached_property
    def object_error(self) -> Array:
        """Distance of the object from where the plan has it, Shape (N,) [m]."""
        at = self._object_course()(np.minimum(self.played.time, self.plan.duration))
        return np.asarray(np.linalg.norm(self.played.motion.object.position - at, axis=1))

    @cached_property
    def path_error(self) -> Array:
        """Distance of the object from its path, whenever it should be there, Shape (N,) [m]."""
        from scipy.spatial import cKDTree  # noqa: PLC0415 (slow to import)

        path = self._object_course()(np.linspace(0.0, self.plan.duration, FINE))
        return np.asarray(cKDTree(path).query(self.played.motion.object.position)[0])

    @property
    def tracking(self) -> dict[str, tuple[float, float]]:
        """Root mean square and largest error of the joints [rad or m], the object and its path [m] during the plan."""
        moving = self.played.time <= self.plan.duration
        errors = {"joints": self.joint_error, "object": self.object_error, "path": self.path_error}
        sizes = {name: np.abs(error[moving]) for name, error in errors.items()}
        return {name: (float(np.sqrt(np.mean(size**2))), float(np.max(size))) for name, size in sizes.items()}

    def _object_course(self) -> Any:
        from scipy.interpolate import CubicHermiteSpline  # noqa: PLC0415 (slow to import)

        given = self.plan.motion.object
        return CubicHermiteSpline(self.plan.time, given.position, self.plan.c * given.twist[:, :3])

    def __repr__(self) -> str:
        return f"<Simulation: {self.sentence()}>"

    def sentence(self) -> str:
        """The verdict."""
        cut = f"; motors cut {_percent(self.saturated)} of the commands" if self.saturated > 0 else ""
        if not self.uses:
            return printable(f"there is no limit to keep{cut}")
        _, worst = self.uses[0]
        if not self.passed:
            nearest = f"nearest is {worst.name}, {100 * worst.share:.1f} % at {worst.time:.4g} s"
            said = "every limit is kept"
            if self.trials is not None and not self.kept:
                said += f" with these errors, but in {self.trials.kept} of {len(self.trials.errors)} trials alone"
            return printable(f"{said}; {nearest}{cut}")
        more = len(self.passed) - 1
        others = f", and {more} more {'are' if more > 1 else 'is'} passed" if more else ""
        passed = f"passes its limit by {_percent(worst.share - 1)} at {worst.time:.4g} s"
        return printable(f"{worst.name} {passed}{others}{cut}")

    def lines(self, *, every: bool = False) -> Iterator[str]:
        """The answer for people: verdict, errors of tracking, what was assumed, and the nearest limits, or all."""
        yield f"{self.plan.cell.name}: {self.sentence()}"
        yield from self.words()
        yield ""
        shown = self.uses if every else self.uses[: max(NEAREST, len(self.passed))]
        table = self._table(shown)
        yield from map(printable, aligned([table.head, *table.rows]))

    def words(self) -> Iterator[str]:
        """How well the plan was followed, what the trials came to, and what was assumed."""
        joints, carried, path = self.tracking.values()
        yield (
            f"joints are {1e3 * joints[0]:.3g} mrad off (at most {1e3 * joints[1]:.3g}), the object "
            f"{1e3 * carried[0]:.3g} mm ({1e3 * carried[1]:.3g}) and off its path {1e3 * path[0]:.3g} mm "
            f"({1e3 * path[1]:.3g})"
        )
        if self.trials is not None:
            most = self.trials.largest
            within, worst = _percent(float(np.percentile(most, LIKELY))), _percent(float(np.max(most)))
            yield (
                f"{len(most)} trials with drawn errors: {LIKELY:g} % stay within {within} of every limit, the worst "
                f"uses {worst}; {self.trials.kept} keep all limits"
            )
        for title, of in (("controller", self.controller), ("cell", self.errors)):
            numbers = (f"{name} {_told(value)}" for name, value in dumped(of).items())
            yield f"{title}: {', '.join(numbers)}"

    def notebook_words(self) -> list[str]:
        """Verdict and errors."""
        return [self.sentence(), *self.words()]

    def notebook_tables(self) -> Iterator[NotebookTable]:
        """Every limit, planned and used."""
        yield self._table(self.uses)

    def _table(self, uses: Sequence[tuple[LimitUse, LimitUse]]) -> NotebookTable:
        spread = self._spread()
        rows = [
            (
                str(used.name), _percent(planned.share), _percent(used.share),
                _percent(used.share - 1) if used.share > 1 else "", f"{used.time:.4g} s",
                *map(_percent, spread.get(used.name, ())),
            )
            for planned, used in uses
        ]  # fmt: skip
        of_trials = ("95 % of trials", "worst") if spread else ()
        return NotebookTable(("limit", "planned", "used", "excess", "at", *of_trials), rows)

    def _spread(self) -> dict[RowName, list[float]]:
        """Of each limit what 95 % of the trials stay within, and the worst; empty without trials."""
        if self.trials is None:
            return {}
        return {use.name: both for use, both in zip(kept_uses(self.played), self.trials.spread.T.tolist(), strict=True)}

    def to_json(self) -> dict[str, Any]:
        """All but the samples as JSON values."""
        spread = self._spread()
        found: dict[str, Any] = {
            "cell": self.plan.cell.name,
            "duration": self.plan.duration,
            "kept": self.kept,
            "outcome": self.sentence(),
            "saturated": self.saturated,
            "tracking": {name: {"rms": rms, "largest": most} for name, (rms, most) in self.tracking.items()},
            "controller": dumped(self.controller),
            "errors": dumped(self.errors),
            "limits": [
                used.name.to_json()
                | {"planned": planned.share, "used": used.share, "excess": max(0.0, used.share - 1), "time": used.time}
                | (dict(zip(("likely", "worst"), spread[used.name], strict=True)) if spread else {})
                for planned, used in self.uses
            ],
        }
        if self.trials is not None:
            found["trials"] = {
                "errors": dumped(self.trials.errors),
                "largest": self.trials.largest.tolist(),
                "saturated": self.trials.saturated.tolist(),
            }
        return found


def simulate(
    plan: ScalingResult | RetimingResult | ScaledTrajectory,
    controller: Controller | None = None,
    errors: PlantErrors | None = None,
    *,
    override: Array | None = None,
    rates: Rates | None = None,
    trials: int = 0,
    seed: int = 0,
    progress: Progress = lambda _done, _total: None,
) -> Simulation:
    """Play a plan by a controller on a cell that is not quite the plan's, in MuJoCo; needs the extra 'simulate'.

    The plan's torques are linear in time between its rows, its joints cubic splines through positions and velocities.
    The cell stands 0.1 s before and 0.2 s after it.

    Args:
        plan: What `mrts.scale` or `mrts.retime` found, or its trajectory.
        controller: None is `Controller()`.
        errors: None is `PlantErrors()`.
        override: Times from 0 [s] and speeds that are wanted from then on, Shape (k, 2): the controller plays the plan
            by its `SpeedOverride` until nothing moves any more; None plays it as planned.
        rates: That the override keeps, as in `SpeedOverride`; without, it brakes and accelerates in steps of torques.
        trials: How often it is played again, with errors drawn evenly between minus and plus `errors`.
        seed: Of the draws and of the noise.
        progress: Told of the trials.

    Returns:
        What was found; limits that are passed are an outcome.

    Raises:
        InputError: If MuJoCo is missing, a number breaks a rule, the URDFs of the cell are not there as they were, or
            the plan has no trajectory, or does not start and end at rest; of an override, as `SpeedOverride` too.
        SolverError: If the simulation runs away.
    """
    require_extra("simulate", "simulate", "mujoco")
    check_type("controller", controller, Controller, NoneType)
    check_type("errors", errors, PlantErrors, NoneType)
    if not is_number(trials, 0, MOST_TRIALS) or trials != int(trials):
        raise InputError("trials", f"must be a whole number from 0 to {MOST_TRIALS}.", value=trials)
    if not is_number(seed, 0) or seed != int(seed):
        raise InputError("seed", "must be a whole number >= 0.", value=seed)
    controller, errors = controller or Controller(), errors or PlantErrors()
    check_type("plan", plan, ScalingResult, RetimingResult, ScaledTrajectory)
    planned = resting_trajectory(plan, "plan")
    if override is not None:
        if isinstance(plan, ScaledTrajectory):
            raise InputError("override", "is of a result, such as mrts scale --save writes: this plan is a table.")
        dt = 1 / controller.rate
        wanted = wanted_at_ticks(override, planned.duration, dt)
        governor = SpeedOverride(plan, backwards=bool(np.any(wanted < 0)), rates=rates)
        planned = commanded(governor, wanted, dt)
    elif rates is not None:
        raise InputError("rates", "are those that an override keeps: give one too.", value=rates)
    planned = replace(planned, cell=planned.cell.with_reserve(0.0))
    # apart, so that the same errors are drawn whatever the controller
    drawing, noise, *noises = np.random.default_rng(seed).spawn(int(trials) + 2)
    played, saturated = _played(planned, controller, errors, noise)
    drawn, shares, cuts = tuple(errors.drawn(drawing) for _ in noises), list[list[float]](), list[float]()
    for done, (each, own) in enumerate(zip(drawn, noises, strict=True), start=1):
        motion, cut = _played(planned, controller, each, own)
        shares.append([use.share for use in kept_uses(motion)])
        cuts.append(cut)
        progress(done, len(drawn))
    several = Trials(drawn, np.array(shares), np.array(cuts)) if drawn else None
    return Simulation(
        plan=planned, played=played, controller=controller, errors=errors, saturated=saturated, trials=several
    )


@dataclass(frozen=True)
class TriedReserve:
    """A plan that was tried: its reserve, and unless there was none its duration [s] and largest use of a limit."""

    reserve: float
    duration: float | None = None
    largest: float | None = None
    limit: str | None = None
    kept: bool = False

    def __str__(self) -> str:
        told = "no plan"
        if self.duration is not None and self.largest is not None:
            told = f"{self.duration:.4g} s, uses {100 * self.largest:.1f} % of {self.limit}"
        return printable(f"  {100 * self.reserve:5.1f} %  {told}")


@dataclass(frozen=True)
class ReserveSearch:
    """The plans that were tried, by their reserve, and the one with the least that keeps all limits, if any."""

    found: ScalingResult | RetimingResult | None
    tried: tuple[TriedReserve, ...]

    @property
    def reserve(self) -> float | None:
        """The least with which all limits are kept, to `RESERVE_WITHIN`; None if no plan does."""
        return next((each.reserve for each in self.tried if each.kept), None)

    def lines(self) -> Iterator[str]:
        """What came of it, and the table of the plans."""
        if self.reserve is None:
            yield "reserve auto: no plan keeps all limits when the controller of `mrts simulate` plays it"
        else:
            yield (
                f"reserve auto: {100 * self.reserve:.3g} % of every limit, the least of {len(self.tried)} with which "
                "all are kept when the controller of `mrts simulate` plays the plan"
            )
        yield from map(str, self.tried)


def least_reserve(
    solve: Callable[[float], ScalingResult | RetimingResult],
    controller: Controller | None = None,
    errors: PlantErrors | None = None,
    *,
    progress: Progress = lambda _done, _total: None,
) -> ReserveSearch:
    """Find the least reserve with which a plan keeps all limits in `mrts.simulate`, by bisection.

    Args:
        solve: Makes the plan with a reserve: `lambda reserve: mrts.retime(cell, motion, reserve=reserve)`.
        controller: As in `mrts.simulate`.
        errors: Likewise; each plan is played with them and with their opposite.
        progress: Told of the plans.

    Raises:
        InputError: As `solve` and `mrts.simulate`.
    """
    check_callable("solve", solve)
    check_callable("progress", progress)
    check_type("errors", errors, PlantErrors, NoneType)
    tried, best = list[TriedReserve](), None
    low, edge = 0.0, 1.0  # limits are passed at `low`; at `edge` they are kept, or there is no plan
    reserve, proportional = 0.0, 0.5
    while edge - low > RESERVE_WITHIN and len(tried) < MOST_PLANS:
        plan = solve(reserve)
        last = _tried(plan, reserve, controller, errors)
        tried.append(last)
        progress(len(tried), MOST_PLANS)
        if last.kept or last.largest is None:
            edge, best = reserve, plan if last.kept else best
        else:
            low, proportional = reserve, 1 - (1 - reserve) / last.largest + RESERVE_WITHIN
        reserve = min((low + edge) / 2, proportional)
    return ReserveSearch(best, tuple(sorted(tried, key=lambda each: each.reserve)))


def _tried(
    plan: ScalingResult | RetimingResult, reserve: float, controller: Controller | None, errors: PlantErrors | None
) -> TriedReserve:
    trajectory = trajectory_of(plan)
    if trajectory is None:
        return TriedReserve(reserve)
    errors = PlantErrors() if errors is None else errors
    played = [simulate(trajectory, controller, each) for each in (errors, errors.opposite())]
    nearest = [used for one in played for _, used in one.uses[:1]]
    if not nearest:
        raise InputError("solve", "its cell has no limit that a reserve could be kept of.")
    worst = max(nearest, key=lambda use: use.share)
    kept = not any(one.passed for one in played)
    return TriedReserve(reserve, trajectory.duration, worst.share, str(worst.name), kept=kept)


def kept_uses(done: ScaledTrajectory) -> list[LimitUse]:
    """Of all limits that a cell keeps, and of power, in the order of its rows."""
    kept = done.cell.enforces_velocity_limits
    uses = (*done.limit_uses, *done.power_uses)
    return [use for use in uses if kept or use.name.kind != "velocity"]


def _at_rest(plan: ScaledTrajectory, name: str) -> Array:
    """Torques or wrenches before and after the motion, Shape (2, …): of the rows that hold still if it has any."""
    values, held = getattr(plan, name)[[0, -1]], plan.holding
    return np.asarray(values if held is None else np.where(np.array(held.ends)[:, None], getattr(held, name), values))


def _reference(plan: ScaledTrajectory, controller: Controller) -> tuple[Array, Array, Array, Array]:
    """Times of the controller's commands, Shape (k,) [s], with the plan's q, q̇ and torques then, each Shape (k, m)."""
    period, torque, end = 1 / controller.rate, plan.torque, plan.duration
    time = np.arange(-np.ceil(BEFORE / period), np.ceil((end + AFTER) / period) + 1) * period
    inside, joints = np.clip(time, 0.0, end), plan.course()
    if not controller.friction:
        torque = torque - plan.friction
    forward = np.column_stack([np.interp(time, plan.time, column) for column in torque.T])
    forward[time < 0], forward[time > end] = _at_rest(plan, "torque")
    return time, joints(inside), joints(inside, 1) * (inside == time)[:, None], forward


def _played(
    plan: ScaledTrajectory, controller: Controller, errors: PlantErrors, rng: np.random.Generator
) -> tuple[ScaledTrajectory, float]:
    """What becomes of a plan, and the share of the motion's commands that were cut."""
    from mrts.control.plant import Plant, without_log  # noqa: PLC0415 (the extra 'simulate')

    period = 1 / controller.rate
    steps = int(np.ceil(period / STEP))  # of the simulation in a period of the controller
    plant = Plant(plan.cell, errors, controller.lag, period / steps)
    torque, wrench = (_at_rest(plan, name)[0] for name in ("torque", "wrench"))
    plant.start(plan, torque, wrench)
    finer = int(np.ceil(min(period / steps / plant.stable_step(), STEP / FINEST)))
    if finer > 1:
        steps *= finer
        plant = Plant(plan.cell, errors, controller.lag, period / steps)
        plant.start(plan, torque, wrench)
    position_gain, velocity_gain = controller.gains(plant.inertia())
    lower = plan.cell.stacked("torque_lower")
    upper = plan.cell.stacked("torque_upper")
    resolution = controller.resolution * np.maximum(-lower, upper)
    noise = (controller.position_noise,), (controller.velocity_noise,)
    periods, late = divmod(round(controller.delay * controller.rate * steps), steps)
    sent = deque([torque] * (periods + 1), periods + 2)  # the last ones, of which the first is at the motors
    measured = range(0, steps, max(1, int(MEASURED / period * steps)))
    stops = sorted({*measured, late})
    times, rows, cut = list[float](), list[Array](), list[bool]()
    with without_log():
        for now, *wanted, forward in zip(*_reference(plan, controller), strict=True):
            off = np.array(wanted) - plant.joints() - rng.normal(0.0, noise, (2, len(forward)))
            asked = forward + position_gain * off[0] + velocity_gain * off[1]
            if controller.resolution > 0:
                asked = np.round(asked / resolution) * resolution
            sent.append(np.clip(asked, lower, upper))
            if 0 <= now <= plan.duration:
                cut.append(bool(np.any(asked != sent[-1])))
            for stop, following in zip(stops, [*stops[1:], steps], strict=True):
                if now > -period / 2 and stop in measured:
                    times.append(now + stop * period / steps)
                    rows.append(plant.sample())
                plant.step(sent[int(stop >= late)], following - stop)
    plant.check_sound()
    return plant.trajectory(np.array(times), np.array(rows)), float(np.mean(cut))


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def _told(value: Any) -> str:
    """A number as it is printed with what was assumed."""
    if isinstance(value, list):
        return "[" + ", ".join(map(_told, value)) + "]"
    return "from the inertia" if value is None else f"{value:g}" if not isinstance(value, bool) else str(value).lower()
