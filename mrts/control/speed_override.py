# SPDX-License-Identifier: MIT
"""A plan at a speed that changes while it runs: the C of an exported library called tick by tick, as it is wanted."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, as_array, as_path, check_type, is_number, printable
from mrts.control.override_tables import STARTS, TICK, limit_tables, rate_tables
from mrts.control.plan_nodes import plan_of
from mrts.following.coordinated_motion import carried_by_first
from mrts.motion.csv_motion import read_columns, row_times
from mrts.motion.rows_at_rest import pushing_ends
from mrts.program.rate_limits import Rates, rate_limits
from mrts.scaling.scale import ScalingResult
from mrts.scaling.scaled_trajectory import Holding, ScaledTrajectory
from mrts.timing.result import RetimingResult

MOST_SPEED = 4.0
"""Of a plan; as in the C, where it keeps squares small."""

AT_A_TICK = 10
"""Fields of a state of the C, in their order, that `OverrideState` has; others are how it goes on."""

NOT_ADMITTED = 2
"""Status of the C where limits do not admit a speed; any other error is of the place."""

WISH_COLUMNS = ("t", "speed")
"""Of a table of wishes."""

SETTLING = 10.0
"""Time after the last wish in which a wanted speed is reached [s]: cells take a hundredth of it, some within rates a
tenth."""

MOST_TICKS = 100_000
"""Of a run: a hundred seconds at 1 kHz."""

DRAWN = 20
"""Wishes of a random run, each held for about a tenth of the plan."""


@dataclass(frozen=True, repr=False, eq=False)
class OverrideState:
    """What a controller commands at a tick.

    Attributes:
        time: Of the plan, s [s].
        speed: ṡ: 1 as planned, 0 at rest, negative against the plan's direction.
        acceleration: s̈ until the next tick [1/s].
        q: Joint positions, Shape (m,) [rad or m].
        dq: q̇, Shape (m,) [rad/s or m/s].
        ddq: q̈, Shape (m,) [rad/s² or m/s²].
        torque: τ of the motors, exact for these positions, velocities and accelerations, Shape (m,) [N m or N].
        wrench: Contact wrenches, robot after robot in base axes, Shape (n w,) [N, N m].
        finished: Whether the cell is at rest at an end of the plan.
        active: The limit that keeps the speed from the wanted one; empty if nothing does.
        numbers: As the C has them; nobody writes to them.
        limits: Names of what may be active, "" first.
    """

    time: float
    speed: float
    acceleration: float
    q: Array
    dq: Array
    ddq: Array
    torque: Array
    wrench: Array
    finished: bool
    active: str
    numbers: NDArray[Any]
    limits: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<OverrideState: s = {self.time:.6g} s, speed {self.speed:.4g}>"


@dataclass(frozen=True, eq=False)
class Stops:
    """Stops on the path from the largest speed at n places of a plan, and from parts of it.

    Attributes:
        cell: Its name.
        time: Of the plan, Shape (n,) [s].
        stop_time: Until all arms stand still, the longest from any speed; infinite where they do not, Shape (n,) [s].
        distance: What the tip that goes farthest goes meanwhile, Shape (n,) [m].
        loads: How many loads the accelerations are for.
        excess: By how much of itself a limit is passed at most, at nodes and between.
        rates: Whether limits of rates are kept.
    """

    cell: str
    time: Array
    stop_time: Array
    distance: Array
    loads: int
    excess: float
    rates: bool

    def __repr__(self) -> str:
        return f"<Stops: {self.sentence()}>"

    def sentence(self) -> str:
        """What is promised."""
        loads = ", for every load of the box" if self.loads > 1 else ""
        if not np.all(np.isfinite(self.stop_time)):
            where = f"{self.time[int(np.argmax(self.stop_time))]:.4g} s of the plan"
            return f"not every stop ends: from {where} braking within the limits does not bring it to rest"
        longest, way = float(np.max(self.stop_time)), float(np.max(self.distance))
        kept = "inside all limits" if self.excess <= 0 else f"no limit passed by more than {100 * self.excess:.2g} %"
        kept += ", rates of torques too" if self.rates else ", whatever the rates of torques"
        return printable(
            f"from every point of this plan{loads} all arms come to rest on the path within {1e3 * longest:.3g} ms and "
            f"{1e3 * way:.3g} mm, {kept}"
        )


class SpeedOverride:
    """A plan played at a speed that may change at any tick, within every limit; see docs/override.md.

    Args:
        result: What `mrts.scale` or `mrts.retime` found, with a trajectory that starts and ends at rest.
        fastest: The largest speed along the plan, 1 to 4; less where limits leave less.
        backwards: Whether it may run against the plan's direction.
        rates: Rates of torques, wrenches and accelerations that are kept, as in `mrts.retime`; None keeps none. A plan
            that uses them all leaves none to slow down with: give some more than it was made with.

    Attributes:
        tables: What limits leave at its nodes, and the C that plays them.
        cell: With the limits as they are given, whatever reserve the plan kept.
        duration: Of the plan as planned [s].

    Raises:
        InputError: If the result has no such trajectory, the cell cannot stand still somewhere on it, limits are passed
            between its samples, or its accelerations jump, or use too much of the rates, where these are to be kept.
        CompilerError: If there is no C compiler, or it fails.
        SolverError: If no solver answers.
    """

    def __init__(
        self,
        result: ScalingResult | RetimingResult,
        *,
        fastest: float = 1.0,
        backwards: bool = False,
        rates: Rates | None = None,
    ) -> None:
        check_type("result", result, ScalingResult, RetimingResult)
        check_type("backwards", backwards, bool)
        if not is_number(fastest, 1, MOST_SPEED):
            raise InputError("fastest", f"must be a number from 1 to {MOST_SPEED:g}.", value=fastest)
        tables = limit_tables(plan_of(result, fastest), backwards=backwards)
        if rates is not None:
            tables = rate_tables(tables, rate_limits(tables.plan.cell, rates))
        self.tables, self.cell, self.duration = tables, tables.plan.cell, float(tables.nodes["time"][-1])

    def start(self, time: float = 0.0, speed: float = 0.0) -> OverrideState:
        """Stand at a place of the plan with a speed.

        Raises:
            InputError: If it is no place of the plan, or limits do not admit the speed there.
        """
        numbers = np.zeros((), self.tables.state)
        for name, value in (("time", time), ("speed", speed)):
            if not is_number(value):
                raise InputError(name, "must be a finite number.", value=value)
        status = self.tables.library.cell_override_start(self.tables.c, time, speed, numbers)
        if status:
            if status != NOT_ADMITTED:
                raise InputError("time", f"must be a place of the plan (0 to {self.duration:g} s).", value=time)
            most = float(np.sqrt(np.interp(time, self.tables.nodes["time"], self.tables.nodes["most"])))
            known = f"{-most if self.tables.c['backwards'] else 0:.4g} to {most:.4g}"
            raise InputError("speed", f"limits do not admit that speed there ({known}).", value=speed)
        return self._state(numbers)

    def step(self, state: OverrideState, wanted: float, dt: float = TICK) -> OverrideState:
        """Go on for a tick, then turn towards a wanted speed.

        Args:
            state: From `start` or `step`.
            wanted: Speed: 1 as planned, 0 to stop.
            dt: Time since the last step [s].

        Raises:
            InputError: Unless wanted is finite and dt > 0.
        """
        if not is_number(wanted):
            raise InputError("wanted", "must be a finite number.", value=wanted)
        _check_tick(dt)
        numbers = self._numbers(state).copy()
        self.tables.library.cell_override_step(self.tables.c, wanted, dt, numbers)
        return self._state(numbers)

    def play(self, wanted: Array, dt: float = TICK, state: OverrideState | None = None) -> NDArray[Any]:
        """States after each of k ticks, Shape (k,), with the fields of `OverrideState`.

        Args:
            wanted: Speed that is wanted at each tick, Shape (k,).
            dt: Between ticks [s].
            state: Before the first; None starts at rest at 0.
        """
        given = np.ascontiguousarray(as_array("wanted", wanted))
        if given.ndim != 1 or not np.all(np.isfinite(given)):
            raise InputError("wanted", "must have Shape (k,) and be finite.")
        _check_tick(dt)
        states = np.zeros(len(given), self.tables.state)
        self.tables.library.mrts_override_play(
            self.tables.c, len(given), given, dt, self._numbers(state or self.start()), states
        )
        return states

    def stop_time(self, state: OverrideState, dt: float = TICK) -> float:
        """Seconds until the cell stands still if that is wanted from now on [s]."""
        _check_tick(dt)
        return float(self.tables.stops(self._numbers(state).reshape(1), dt)[0][0])

    def speed_for_stop(self, state: OverrideState, seconds: float, dt: float = TICK) -> float:
        """The largest speed here from which the cell stands still within some seconds."""
        _check_tick(dt)
        if not is_number(seconds, 0):
            raise InputError("seconds", "must be a time >= 0 in s.", value=seconds)
        given = self.tables.c, self._numbers(state), seconds, dt
        return float(self.tables.library.cell_override_speed_for_stop(*given))

    def stops(self, dt: float = TICK) -> Stops:
        """How soon and how far on all arms stand still wherever they are stopped, from any speed.

        Args:
            dt: Between ticks [s]; the first goes by before braking begins.
        """
        _check_tick(dt)
        states, nodes = self.tables.starts(), self.tables.nodes
        seconds, stands = self.tables.stops(states, dt)
        tips = self.cell.functions("kinematics", len(nodes), {"q": nodes["q"]})["position"]
        way = np.linalg.norm(np.diff(tips.reshape(len(nodes), 3, -1), axis=0), axis=1)
        gone = np.concatenate([np.zeros((1, way.shape[1])), np.cumsum(way, axis=0)])
        begun, ended = (
            np.array([np.interp(at, nodes["time"], of) for of in gone.T]) for at in (states["time"], stands)
        )
        each = (-1, len(STARTS))
        return Stops(
            cell=self.cell.name,
            time=states["time"].reshape(each)[:, 0],
            stop_time=np.max(seconds.reshape(each), axis=1),
            distance=np.max(np.max(ended - begun, axis=0).reshape(each), axis=1),
            loads=len(self.tables.plan.loads),
            excess=float(np.max(self.tables.passed)),
            rates=bool(self.tables.c["keeps_rates"]),
        )

    def resume(self, q: Array, within: float) -> OverrideState:
        """Stand still at the place of the plan nearest to measured joint positions.

        Args:
            q: Shape (m,) [rad or m].
            within: Farthest that a joint may be from it [rad or m].

        Raises:
            InputError: If a joint is farther off.
        """
        given, numbers = np.ascontiguousarray(as_array("q", q)), np.zeros((), self.tables.state)
        if given.shape != (len(self.cell.joint_names),):
            raise InputError("q", f"must have Shape ({len(self.cell.joint_names)},).")
        if not is_number(within, 0):
            raise InputError("within", "must be a distance >= 0.", value=within)
        if self.tables.library.cell_override_resume(self.tables.c, given, within, numbers):
            raise InputError("q", f"no place of the plan is within {within:g} of it in every joint.")
        return self._state(numbers)

    def _numbers(self, state: OverrideState) -> NDArray[Any]:
        check_type("state", state, OverrideState)
        if state.limits is not self.tables.limits:  # its node may be none of these
            raise InputError("state", "must come from this override: those of another plan stand elsewhere.")
        return state.numbers

    def _state(self, numbers: NDArray[Any]) -> OverrideState:
        *commanded, active, finished = numbers.item()[:AT_A_TICK]  # as `cell_override` orders them
        limits = self.tables.limits
        values: tuple[Any, ...] = (*commanded, bool(finished), limits[active], numbers, limits)
        return OverrideState(*values)


def _check_tick(dt: float) -> None:
    if not is_number(dt, 0) or dt == 0:
        raise InputError("dt", "must be a time > 0 in s.", value=dt)


def read_wishes(path: Path | str) -> Array:
    """Read a CSV table with the columns t [s] and speed: times from 0 and speeds, each held until the next, (k, 2).

    Raises:
        InputError: If it is malformed, says where.
    """
    path = as_path("path", path)
    columns = read_columns(path, least=1)
    if unknown := set(columns) - set(WISH_COLUMNS):
        raise InputError(path, f"unknown column '{min(unknown)}'. Columns are {', '.join(WISH_COLUMNS)}.")
    if "speed" not in columns:
        raise InputError(path, "a column 'speed' is needed: 1 as planned, 0 to stop.")
    return np.column_stack([row_times(path, columns), columns["speed"]])


def random_wishes(seed: int, duration: float) -> Array:
    """Steps, ramps and stops for about twice a duration [s], then 1, Shape (k, 2)."""
    rng = np.random.default_rng(seed)
    rows, now = list[tuple[float, float]](), 0.0
    for kind in rng.choice(["step", "ramp", "stop"], DRAWN, p=[0.4, 0.3, 0.3]):
        held = float(rng.uniform(0.02, 0.2)) * duration
        before = rows[-1][1] if rows else 0.0
        after = 0.0 if kind == "stop" else float(rng.uniform(0.0, 1.0))
        steps = 10 if kind == "ramp" else 1
        rows += [(now + held * k / steps, before + (after - before) * (k + 1) / steps) for k in range(steps)]
        now += held
    return np.array([*rows, (now, 1.0)])


def commanded(override: SpeedOverride, wanted: Array, dt: float) -> ScaledTrajectory:
    """What a controller commands at every tick of dt [s], when some speed is wanted, Shape (k,), until nothing moves.

    At the start the first speed is had.

    Raises:
        InputError: If nothing moves, or something still does at the last tick.
    """
    start = override.start(0.0, min(max(float(wanted[0]), 0.0), 1.0))
    states = np.concatenate([start.numbers.reshape(1), override.play(wanted, dt, start)])
    moves = np.flatnonzero(states["speed"][1:])
    if not moves.size:
        raise InputError("override", "never leaves the start of the plan: some wanted speed must be > 0.")
    if moves[-1] + 1 == len(wanted):
        raise InputError("override", f"still moves after {dt * len(wanted):.4g} s.")
    played = states[: moves[-1] + 3]
    q, dq, ddq, torque, wrench = (np.array(played[name]) for name in ("q", "dq", "ddq", "torque", "wrench"))
    time = dt * np.arange(len(played), dtype=np.float64)
    ahead = np.sign(np.diff(override.tables.nodes["q"], axis=0))[played["node"]] * played["direction"][:, None]
    way = np.where(dq != 0, np.sign(dq), ahead)
    carried = carried_by_first(override.cell, time, q, dq, ddq)
    motion, still = replace(carried, travel=np.stack([way, way])), override.start(0.0)
    held = Holding(pushing_ends(dq, ddq), np.stack([still.torque, torque[-1]]), np.stack([still.wrench, wrench[-1]]))
    return ScaledTrajectory(override.cell, motion, 1.0, torque, wrench, held)


def wanted_at_ticks(wishes: Array, duration: float, dt: float) -> Array:
    """The speed wanted at every tick of dt [s] of a plan until what the last wish asks for is reached, Shape (k,).

    Raises:
        InputError: If wishes are malformed, or that takes more than `MOST_TICKS`.
    """
    given = as_array("override", wishes)
    if given.ndim != 2 or given.shape[1:] != (2,) or not len(given) or not np.all(np.isfinite(given)):  # noqa: PLR2004
        raise InputError("override", "must have Shape (k, 2): times and wanted speeds, all finite.")
    time, speed = given.T
    if np.max(np.abs(speed)) > 1:
        raise InputError(
            "override", "wants speeds up to 1, the plan's own.", value=float(speed[np.argmax(np.abs(speed))])
        )
    if time[0] != 0 or np.any(np.diff(time) <= 0):
        raise InputError("override", "must have times from 0 on that increase.", value=time.tolist())
    last = abs(float(speed[-1]))
    left = SETTLING + (duration / last if last > duration / (MOST_TICKS * dt) else 0.0)
    ticks = np.ceil((time[-1] + left) / dt)
    if ticks > MOST_TICKS:
        raise InputError("override", f"lasts more than {MOST_TICKS} ticks of {dt:g} s.", value=float(time[-1]))
    return np.asarray(speed[np.searchsorted(time, dt * (np.arange(ticks) + 1.5), side="right") - 1])
