# SPDX-License-Identifier: MIT
"""A plan at a speed that changes while it runs: the C that an exported library has, called tick by tick."""

import ctypes
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.argument_types import check_type, is_number
from mrts.base.arrays import Array
from mrts.base.embedded_inputs import EmbeddedPlan
from mrts.base.errors import InputError, as_array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import unchecked_coordinated_motion
from mrts.kernel.foreign_arrays import INFINITY
from mrts.kernel.override_library import node_type, override_library, plan_type, state_type
from mrts.limits import limit_rows
from mrts.limits.rows import object_axes
from mrts.motion.rows_at_rest import REST
from mrts.override.plan_nodes import AT_MOST, AT_REST, Corners, Plan, corners_of, divided, motion_of, plan_of, reachable
from mrts.override.rates import followed, largest_changes, levelled
from mrts.override.stops import Stops
from mrts.program.excess import BETWEEN
from mrts.program.motion_rows import motion_rows
from mrts.program.rate_limits import RateLimits, Rates, rate_limits
from mrts.program.widening import motion_widening
from mrts.scaling.result import ScalingResult
from mrts.timing.result import RetimingResult

PARTS = (0.5, 0.35, 0.25, 0.18, 0.12, 0.09, 0.06, 0.045, 0.03, 0.02)
"""Of the hardest accelerations, tried where rates are kept: the harder they are, the less is left to change them."""

RATES = "rates"
"""What is active where they keep the acceleration from changing sooner."""

MOST_SPEED = 4.0
"""Of a plan; as in the C, where it keeps squares small."""

TICK = 1e-3
"""Time between two steps where none is given: the 1 kHz of most torque interfaces [s]."""

PLACES = (0.25, MIDDLE := 0.5, 0.75)
"""Where between two nodes limits are looked at, in the middle for every load."""

ROUNDS, DIVISIONS = 8, 5
"""Times that tables are made: in the first segments are divided, then limits are moved inward by what is passed."""

LOWERINGS = 60
"""Times that accelerations which pass limits between nodes even so are lowered."""

BENT = 1e-3
"""Share of a limit passed between two nodes from which they get another between."""

MOST_MARGIN = 0.05
"""Most of a limit that is taken off."""

LESS = 0.7
"""What is left of an acceleration each time."""

MOST_PASSED = 0.01
"""Share of a limit passed between two nodes from which there is no override: samples do not tell what is between."""

PLAYED = 1
"""The place of the plan itself among the six points."""

ON_THE_WAY = 0.75
"""Share of the largest x at which limits with terms in the speed are looked at besides: below it the chord of the speed
lies well above the speed, at most of it nodes are nearest to their limits."""

STARTS = np.array([(place, part) for place in (0.0, 0.5) for part in (1.0, 0.75, 0.5, 0.25)])
"""Where in each segment stops begin, and with which parts of the largest speed."""

NOT_ADMITTED, WRONG = 2, 5
REFUSED = {
    NOT_ADMITTED: "limits do not admit that speed there",
    WRONG: "must be a place of the plan",
}
"""What the statuses of the C say."""


def sizes_of(cell: Cell) -> tuple[int, int]:
    """Joints, and components of all wrenches."""
    return len(cell.joint_names), len(cell.robots) * len(cell.wrench_components)


def plan_nodes(cell: Cell, corners: Corners) -> NDArray[Any]:
    """The tables of a plan as C reads them, Shape (n,)."""
    motion, axes = corners.motion, object_axes(cell, corners.motion)
    nodes = np.zeros(motion.samples, node_type(*sizes_of(cell)))
    for name in ("q", "dq", "ddq"):
        nodes[name] = getattr(motion, name)
    nodes["dq"][np.abs(nodes["dq"]) <= REST * np.max(np.abs(nodes["dq"]))] = 0.0  # friction is against the way ahead
    nodes["time"] = motion.object.time
    for name in ("most", "acceleration", "active", "rate", "rate_ahead"):
        nodes[name] = getattr(corners, name)
    nodes["hold"] = _turned(axes, corners.hold)
    nodes["accelerate"] = _turned(axes, corners.accelerate)
    return nodes


def _turned(axes: Any, wrenches: Array) -> Array:
    flat = wrenches.reshape(len(wrenches), -1, wrenches.shape[-1])
    turned = np.stack([axes.turned(np.ascontiguousarray(flat[:, k])) for k in range(flat.shape[1])], axis=1)
    return turned.reshape(wrenches.shape)


@dataclass(frozen=True, repr=False, eq=False)
class OverrideState:
    """What a controller commands at a tick.

    Attributes:
        numbers: As the C has them; nobody writes to them.
        limits: Names of what may be active, "" first.
    """

    numbers: NDArray[Any]
    limits: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<OverrideState: s = {self.time:.6g} s, speed {self.speed:.4g}>"

    @property
    def time(self) -> float:
        """Of the plan, s [s]."""
        return float(self.numbers["time"])

    @property
    def speed(self) -> float:
        """ṡ: 1 as planned, 0 at rest, negative against the plan's direction."""
        return float(self.numbers["speed"])

    @property
    def acceleration(self) -> float:
        """s̈ until the next tick [1/s]."""
        return float(self.numbers["acceleration"])

    @property
    def q(self) -> Array:
        """Joint positions, Shape (m,) [rad or m]."""
        return np.asarray(self.numbers["q"])

    @property
    def dq(self) -> Array:
        """q̇, Shape (m,) [rad/s or m/s]."""
        return np.asarray(self.numbers["dq"])

    @property
    def ddq(self) -> Array:
        """q̈, Shape (m,) [rad/s² or m/s²]."""
        return np.asarray(self.numbers["ddq"])

    @property
    def torque(self) -> Array:
        """τ of the motors, exact for these positions, velocities and accelerations, Shape (m,) [N m or N]."""
        return np.asarray(self.numbers["torque"])

    @property
    def wrench(self) -> Array:
        """Contact wrenches, robot after robot in base axes, Shape (n w,) [N, N m]."""
        return np.asarray(self.numbers["wrench"])

    @property
    def finished(self) -> bool:
        """Whether the cell is at rest at an end of the plan."""
        return bool(self.numbers["finished"])

    @property
    def active(self) -> str:
        """The limit that keeps the speed from the wanted one; empty if nothing does."""
        return self.limits[self.numbers["active"]]


class SpeedOverride:
    """A plan played at a speed that may change at any tick, within every limit; see docs/override.md.

    Args:
        result: What `mrts.scale` or `mrts.retime` found, with a trajectory that starts and ends at rest.
        fastest: The largest speed along the plan, 1 to 4; less where limits leave less.
        backwards: Whether it may run against the plan's direction.
        rates: Rates of torques, wrenches and accelerations that are kept, as in `mrts.retime`; None keeps none. A plan
            that uses them all leaves none to slow down with: give some more than it was made with.

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
        self.plan: Plan = plan_of(result, fastest)
        self.cell: Cell = self.plan.cell
        self.backwards = backwards
        self._library, self._kind = _opened(self.cell), state_type(*sizes_of(self.cell))
        self._has_speed_terms = motion_rows(self.cell, self.plan.motion, self.plan.sharing).has_speed_terms
        self._make()
        for _ in range(ROUNDS):
            slower = reachable(self.corners, backwards=backwards)
            if np.all(slower >= self.plan.most):
                break
            self.plan = replace(self.plan, most=slower)
            self._make()
        over = np.max(self.passed, axis=1)
        if np.max(over) > MOST_PASSED:
            where = f"between {', '.join(f'{time:.4g}' for time in self.nodes['time'][np.argmax(over) :][:2])} s"
            rule = f"{where} of the plan a limit would be passed by {100 * np.max(over):.2g} %"
            what = "played in either direction: leave `backwards` out" if backwards else "between samples: give more"
            raise InputError("result", f"{rule}, {what}, or plan with a reserve.")
        if rates is not None:
            self._keep(rate_limits(self.cell, rates), rates)

    def _keep(self, limits: RateLimits, rates: Rates) -> None:
        """Accelerations with which stops within the limits of rates are soonest."""
        if self.plan.wrench is None or np.ptp(self.plan.most):
            jumps = "whose accelerations do not jump: take one by a constant factor, or a smooth one."
            rule = f"go with a plan {jumps}" if self.plan.wrench is None else "do not go with a speed above the plan's."
            raise InputError("rates", rule, value=rates)
        whole, best, changes = self.corners, None, np.zeros((1, 2))
        kept = max(BETWEEN, float(np.max(self.passed)))
        hold = np.broadcast_to(whole.hold[:, 1:], whole.hold.shape)  # the plan's wrenches hold too, if limits admit it
        self._take(replace(whole, hold=hold))
        steady = bool(np.max(self.passed[:, AT_REST]) <= kept)
        hold = hold if steady else whole.hold
        for part in PARTS:
            self._take(levelled(whole, part, hold))
            self._lower()
            self._take(levelled(self.corners, 1.0, hold))
            self._c["coulomb"] = 0.0  # rates are of torques without dry friction, which jumps
            changes = largest_changes(self.corners, self._states, limits)
            self._take(followed(self.corners, changes, backwards=self.backwards), keeps_rates=True)
            longest = float(np.max(self.stops().stop_time))
            sound = np.all(self.corners.acceleration) and np.max(self.passed) <= kept
            if sound and (best is None or longest < best[0]):
                best = longest, self.corners
        if best is None:
            worst = self.nodes["time"][int(np.argmin(changes[:, 1]))]
            rule = (
                f"the plan leaves too little of its limits of rates for a speed that changes, least at {worst:.4g} s. "
                "Give about twice those that it was made with, or make it with reserve=0.5."
            )
            if not steady:
                rule = (
                    "the plan's wrenches do not hold the object at rest, and those that do change too fast for rates. "
                    "Leave rates out, or plan with a reserve."
                )
            raise InputError("rates", rule, value=rates)
        self._take(best[1], keeps_rates=True)

    def _make(self) -> None:
        """The tables, with what they pass between nodes taken off."""
        margin = np.zeros(self.plan.motion.samples)
        for turn in range(ROUNDS):
            self._take(corners_of(self.plan, backwards=self.backwards, margin=margin))
            over = np.max(np.where(self._chosen, self.passed, 0.0), axis=1)
            if np.max(over) <= BETWEEN:
                return
            bent = np.flatnonzero(over > BENT)
            if bent.size and turn < DIVISIONS:
                self.plan = divided(self.plan, bent, self._at(bent, 0.5))
                margin = np.insert(margin, bent + 1, margin[bent])
            else:
                over = np.append(np.where(over > BETWEEN, over, 0.0), 0.0)
                margin = np.minimum(margin + np.maximum(over, np.roll(over, 1)), MOST_MARGIN)
        self._lower()

    def _lower(self) -> None:
        """Take off accelerations that pass limits between nodes, where the plan does not do so without any."""
        for _ in range(LOWERINGS):
            without, passed = self.passed[:, [AT_REST, AT_MOST] * 2], self.passed[:, 2:]
            over = (passed > BETWEEN) & (passed > without + BETWEEN / 10)
            over = np.append(over, np.zeros((1, 4), dtype=bool), axis=0)
            if not np.any(over):
                return
            part = np.where(over | np.roll(over, 1, axis=0), LESS, 1.0)
            self._take(self.corners.lowered(part.reshape(-1, 2, 2)))

    @property
    def _chosen(self) -> NDArray[np.bool_]:
        """Of the six points those whose wrenches are found here, Shape (6,): a plan without jumps has its own."""
        planned = self.plan.wrench is not None and bool(np.all(self.plan.most == 1))
        return np.asarray(np.arange(6) != (PLAYED if planned else -1))

    def _at(self, segment: NDArray[np.intp], place: float) -> NDArray[Any]:
        """States of the plan as planned at a place in (0, 1) of some segments."""
        inside = place * np.diff(self.nodes["time"])[segment]
        return self._states(segment, inside, np.ones(len(segment)), np.zeros(len(segment)))

    def _between_nodes(self) -> Array:
        """By how much the six points pass a limit between nodes, Shape (n - 1, 6).

        With terms in the speed also on the way from rest to the largest speed; both then pass what is passed there.
        """
        step = np.diff(self.nodes["time"])
        segment = np.flatnonzero(step)
        found = np.full((len(step), 6), -1.0)
        points: list[tuple[tuple[int, ...], tuple[Array, Array]]] = [
            ((corner,), ends) for corner, ends in enumerate(self.corners.corners)
        ]
        if self._has_speed_terms:
            for k in range(0, len(points), 2):
                (_, (u, x)), (_, (u_most, x_most)) = points[k : k + 2]
                points.append(((k, k + 1), (u + ON_THE_WAY * (u_most - u), x + ON_THE_WAY * (x_most - x))))
        for shown, ends in points:
            for place in PLACES:
                u, x = (of[segment] + place * (of[segment + 1] - of[segment]) for of in ends)
                states = self._states(segment, place * step[segment], np.sqrt(x), u)
                shares = [self.excess(states)]
                if place == MIDDLE:
                    shares += self._excess_of_loads(segment, states)
                for corner in shown:
                    found[segment, corner] = np.max([found[segment, corner], *shares], axis=0)
        return found

    def _excess_of_loads(self, segment: NDArray[np.intp], states: NDArray[Any]) -> Iterator[Array]:
        """By how much each other load passes a limit in some states, whatever carries it, Shape (k,)."""
        others = [load for load in self.plan.loads if not np.array_equal(load, self.cell.load)]
        if not others:
            return
        moving = motion_of(self.cell, states)
        way = np.sign(self.nodes["q"][segment + 1] - self.nodes["q"][segment])
        motion = unchecked_coordinated_motion(moving.object, moving.q, moving.dq, moving.ddq, np.stack([way, way]))
        rows = motion_rows(self.cell, motion, self.plan.sharing)
        for load in others:
            yield motion_widening(rows, np.ones(len(segment)), load)

    def _take(self, corners: Corners, *, keeps_rates: bool = False) -> None:
        cell, motors = self.cell, [robot.motors for robot in self.cell.robots]
        self.corners = corners
        self.tables = EmbeddedPlan(
            nodes=plan_nodes(cell, corners),
            limits=(*corners.names, RATES),
            backwards=self.backwards,
            varies=bool(np.any(corners.most != 1)),
            keeps_rates=len(corners.names) if keeps_rates else 0,
            load=cell.load,
            armature=np.concatenate([motor.armature for motor in motors]),
            coulomb=np.concatenate([motor.coulomb for motor in motors]),
            viscous=np.concatenate([motor.viscous for motor in motors]),
        )
        self._geometry = np.ascontiguousarray(cell.geometry)
        addresses = {"nodes": self.nodes.ctypes.data, "geometry": self._geometry.ctypes.data, "count": len(self.nodes)}
        self._c = np.zeros((), plan_type(len(cell.joint_names)))
        for name in self._c.dtype.names or ():
            if name != "limits":  # names are looked up here
                self._c[name] = addresses[name] if name in addresses else getattr(self.tables, name)
        self.passed = self._between_nodes()

    @property
    def nodes(self) -> NDArray[Any]:
        """The tables, Shape (n,)."""
        return self.tables.nodes

    @property
    def duration(self) -> float:
        """Of the plan as planned [s]."""
        return float(self.nodes["time"][-1])

    def start(self, time: float = 0.0, speed: float = 0.0) -> OverrideState:
        """Stand at a place of the plan with a speed.

        Raises:
            InputError: If it is no place of the plan, or limits do not admit the speed there.
        """
        numbers = np.zeros((), self._kind)
        for name, value in (("time", time), ("speed", speed)):
            if not is_number(value):
                raise InputError(name, "must be a finite number.", value=value)
        status = self._library.mrts_override_start(self._c, time, speed, numbers)
        if status:
            key, value = ("speed", speed) if status == NOT_ADMITTED else ("time", time)
            known = f"0 to {self.duration:g} s"
            if status == NOT_ADMITTED:
                most = float(np.sqrt(np.interp(time, self.nodes["time"], self.nodes["most"])))
                known = f"{-most if self.backwards else 0:.4g} to {most:.4g}"
            raise InputError(key, f"{REFUSED[status]} ({known}).", value=value)
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
        self._library.mrts_override_step(self._c, wanted, dt, numbers)
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
        states = np.zeros(len(given), self._kind)
        self._library.mrts_override_play(self._c, len(given), given, dt, self._numbers(state or self.start()), states)
        return states

    def stop_time(self, state: OverrideState, dt: float = TICK) -> float:
        """Seconds until the cell stands still if that is wanted from now on [s]."""
        _check_tick(dt)
        return float(self._stops(self._numbers(state).reshape(1), dt)[0][0])

    def speed_for_stop(self, state: OverrideState, seconds: float, dt: float = TICK) -> float:
        """The largest speed here from which the cell stands still within some seconds."""
        _check_tick(dt)
        if not is_number(seconds, 0):
            raise InputError("seconds", "must be a time >= 0 in s.", value=seconds)
        speed = np.zeros(1)
        self._library.mrts_override_speed_for_stop(self._c, self._numbers(state), seconds, dt, speed)
        return float(speed[0])

    def stops(self, dt: float = TICK) -> Stops:
        """How soon and how far on all arms stand still wherever they are stopped, from any speed.

        Args:
            dt: Between ticks [s]; the first goes by before braking begins.
        """
        _check_tick(dt)
        step = np.diff(self.nodes["time"])
        segment = np.repeat(np.flatnonzero(step), len(STARTS))
        place, part = np.tile(STARTS, (len(segment) // len(STARTS), 1)).T
        most = self.nodes["most"][segment] + place * np.diff(self.nodes["most"])[segment]
        states = self._states(segment, place * step[segment], part * np.sqrt(most), np.zeros(len(segment)))
        seconds, stands = self._stops(states, dt)
        tips = self.cell.functions("kinematics", len(self.nodes), {"q": self.nodes["q"]})["position"]
        way = np.linalg.norm(np.diff(tips.reshape(len(self.nodes), 3, -1), axis=0), axis=1)
        gone = np.concatenate([np.zeros((1, way.shape[1])), np.cumsum(way, axis=0)])
        nodes, places = self.nodes["time"], (states["time"], stands)
        begun, ended = (np.array([np.interp(at, nodes, of) for of in gone.T]) for at in places)
        each = (-1, len(STARTS))
        return Stops(
            cell=self.cell.name,
            time=states["time"].reshape(each)[:, 0],
            stop_time=np.max(seconds.reshape(each), axis=1),
            distance=np.max(np.max(ended - begun, axis=0).reshape(each), axis=1),
            loads=len(self.plan.loads),
            excess=float(np.max(self.passed)),
            rates=bool(self.tables.keeps_rates),
        )

    def resume(self, q: Array, within: float) -> OverrideState:
        """Stand still at the place of the plan nearest to measured joint positions.

        Args:
            q: Shape (m,) [rad or m].
            within: Farthest that a joint may be from it [rad or m].

        Raises:
            InputError: If a joint is farther off.
        """
        given, numbers = np.ascontiguousarray(as_array("q", q)), np.zeros((), self._kind)
        if given.shape != (len(self.cell.joint_names),):
            raise InputError("q", f"must have Shape ({len(self.cell.joint_names)},).")
        if not is_number(within, 0):
            raise InputError("within", "must be a distance >= 0.", value=within)
        if self._library.mrts_override_resume(self._c, given, within, numbers):
            raise InputError("q", f"no place of the plan is within {within:g} of it in every joint.")
        return self._state(numbers)

    def _numbers(self, state: OverrideState) -> NDArray[Any]:
        check_type("state", state, OverrideState)
        if state.limits is not self.tables.limits:  # its node may be none of these
            raise InputError("state", "must come from this override: those of another plan stand elsewhere.")
        return state.numbers

    def _state(self, numbers: NDArray[Any]) -> OverrideState:
        return OverrideState(numbers, self.tables.limits)

    def _stops(self, states: NDArray[Any], dt: float) -> tuple[Array, Array]:
        seconds, stands = np.zeros((2, len(states)))
        self._library.mrts_override_stops(self._c, len(states), states, dt, seconds, stands)
        return np.where(seconds < INFINITY, seconds, np.inf), stands

    def _states(self, node: NDArray[Any], inside: Array, speed: Array, acceleration: Array) -> NDArray[Any]:
        states = np.zeros(len(node), self._kind)
        given = [np.ascontiguousarray(of, dtype=np.float64) for of in (inside, speed, acceleration)]
        self._library.mrts_override_states(
            self._c, len(node), np.ascontiguousarray(node, dtype=np.int32), *given, states
        )
        return states

    def excess(self, states: NDArray[Any]) -> Array:
        """By how much of itself each state passes a limit, below 0 within all, Shape (k,)."""
        rows = limit_rows(self.cell, motion_of(self.cell, states))
        value = rows.value(np.array(states["torque"]), np.array(states["wrench"]), 0.0, 1.0)
        return np.asarray(np.max(rows.excess(value), axis=1, initial=-1.0))


def _check_tick(dt: float) -> None:
    if not is_number(dt, 0) or dt == 0:
        raise InputError("dt", "must be a time > 0 in s.", value=dt)


def _opened(cell: Cell) -> ctypes.CDLL:
    manifest, generated = cell.functions.manifest, cell.functions.origin
    if not isinstance(generated, str):
        cell.functions.library  # noqa: B018 (it says what is missing)
    return override_library(manifest, str(generated))
