# SPDX-License-Identifier: MIT
"""The tables of a plan as the C plays them: within limits, between nodes too, and within rates if these are kept.

What changes at a rate z' along the motion, and by z_u for each unit of u, keeps |z' + z_u u̇| within its rate r while
|u̇| <= (r - |z'|) / |z_u|, of all the least. That is measured at rest, at half and at the largest speed, at the least,
no and the largest u. A governor that may change u no faster must begin in time to bring it back to 0: its bounds fall
no faster along the plan than u can follow, and within what it takes until u is 0 the least change counts.
"""

import ctypes
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.manifest import LOAD_ENTRIES
from mrts.cell.cell import Cell
from mrts.cell.robot import EFFECTS
from mrts.control.plan_nodes import AT_MOST, AT_REST, Corners, Plan, corners_of, divided, motion_of, reachable
from mrts.kernel.binding import INFINITY, structure
from mrts.kernel.c_text import OVERRIDE, override_source
from mrts.kernel.compiler import compiled_library
from mrts.limits import limit_rows
from mrts.limits.rows import object_axes, turned
from mrts.motion.rows_at_rest import moving_joints
from mrts.program.between_samples import BETWEEN
from mrts.program.infeasibility import motion_widening
from mrts.program.motion_rows import motion_rows
from mrts.program.rate_limits import RateLimits

PARTS = (0.5, 0.35, 0.25, 0.18, 0.12, 0.09, 0.06, 0.045, 0.03, 0.02)
"""Of the hardest accelerations, tried where rates are kept: the harder they are, the less is left to change them."""

RATES = "rates"
"""What is active where they keep the acceleration from changing sooner."""

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


SPEED_PARTS = (0.0, 0.5, 1.0)
"""Parts of the largest speed at which changes are measured."""

RATE_PLACES = (0.05, 0.5, 0.95)
"""Places in each segment, likewise."""

AHEAD = 1e-4
"""Part of a segment over which a rate is a difference."""


class PlayedTables:
    """Tables of a plan, and the library that plays them.

    Attributes:
        plan: The plan.
        corners: What limits leave at its nodes.
        nodes: `cell_plan_node` of the exported header, Shape (n,).
        limits: Names of what may be active, "" first.
        library: The C, called with `c`.
        c: `cell_plan` of the exported header.
        state: `cell_override` of the exported header.
    """

    def __init__(self, corners: Corners, library: ctypes.CDLL, *, backwards: bool, keeps_rates: bool = False) -> None:
        self.plan, self.corners, self.library = corners.plan, corners, library
        cell = self.plan.cell
        self.nodes, self._geometry = _plan_nodes(corners), np.ascontiguousarray(cell.geometry)
        self.limits = (*corners.names, RATES)  # whose names are looked up here, not in the C
        self.c, self.state = np.zeros((), _structure("cell_plan", cell)), _structure("cell_override", cell)
        self.c["nodes"], self.c["count"] = self.nodes.ctypes.data, len(self.nodes)
        self.c["geometry"], self.c["load"] = self._geometry.ctypes.data, cell.load
        self.c["backwards"], self.c["varies"] = backwards, np.any(self.plan.most != 1)
        self.c["keeps_rates"] = len(corners.names) if keeps_rates else 0
        for name in EFFECTS:
            self.c[name] = cell.stacked(f"motors.{name}")

    def of(self, corners: Corners, *, keeps_rates: bool = False) -> "PlayedTables":
        """Other tables of the same plan."""
        return PlayedTables(corners, self.library, backwards=bool(self.c["backwards"]), keeps_rates=keeps_rates)

    def states(self, node: NDArray[Any], inside: Array, speed: Array, acceleration: Array) -> NDArray[Any]:
        """States at places after nodes [s], with speeds and accelerations, Shape (k,)."""
        states = np.zeros(len(node), self.state)
        given = [np.ascontiguousarray(of, dtype=np.float64) for of in (inside, speed, acceleration)]
        nodes = np.ascontiguousarray(node, dtype=np.int32)
        self.library.mrts_override_states(self.c, len(node), nodes, *given, states)
        return states

    def stops(self, states: NDArray[Any], dt: float) -> tuple[Array, Array]:
        """Time until the cell stands still, infinite where it does not, and where on the plan, each Shape (k,) [s]."""
        seconds, stands = np.zeros((2, len(states)))
        self.library.mrts_override_stops(self.c, len(states), states, dt, seconds, stands)
        return np.where(seconds < INFINITY, seconds, np.inf), stands

    def starts(self) -> NDArray[Any]:
        """States from which stops begin, `STARTS` of each segment."""
        step, most = np.diff(self.nodes["time"]), self.nodes["most"]
        segment = np.repeat(np.flatnonzero(step), len(STARTS))
        place, part = np.tile(STARTS, (len(segment) // len(STARTS), 1)).T
        largest = most[segment] + place * np.diff(most)[segment]
        return self.states(segment, place * step[segment], part * np.sqrt(largest), np.zeros(len(segment)))

    def excess(self, states: NDArray[Any]) -> Array:
        """By how much of itself each state passes a limit, below 0 within all, Shape (k,)."""
        rows = limit_rows(self.plan.cell, motion_of(self.plan.cell, states))
        value = rows.value(np.array(states["torque"]), np.array(states["wrench"]), 0.0, 1.0)
        return np.asarray(np.max(rows.excess(value), axis=1, initial=-1.0))

    @cached_property
    def passed(self) -> Array:
        """By how much the six points pass a limit between nodes, Shape (n - 1, 6).

        With terms in the speed also on the way from rest to the largest speed; both then pass what is passed there.
        """
        step = np.diff(self.nodes["time"])
        segment = np.flatnonzero(step)
        found = np.full((len(step), 6), -1.0)
        points: list[tuple[tuple[int, ...], tuple[Array, Array]]] = [
            ((corner,), ends) for corner, ends in enumerate(self.corners.corners)
        ]
        if self.plan.has_speed_terms:
            for k in range(0, len(points), 2):
                (_, (u, x)), (_, (u_most, x_most)) = points[k : k + 2]
                points.append(((k, k + 1), (u + ON_THE_WAY * (u_most - u), x + ON_THE_WAY * (x_most - x))))
        for shown, ends in points:
            for place in PLACES:
                u, x = (of[segment] + place * (of[segment + 1] - of[segment]) for of in ends)
                states = self.states(segment, place * step[segment], np.sqrt(x), u)
                shares = [self.excess(states)]
                if place == MIDDLE:
                    shares += self._excess_of_loads(segment, states)
                for corner in shown:
                    found[segment, corner] = np.max([found[segment, corner], *shares], axis=0)
        return found

    def _excess_of_loads(self, segment: NDArray[np.intp], states: NDArray[Any]) -> Iterator[Array]:
        """By how much each other load passes a limit in some states, whatever carries it, Shape (k,)."""
        cell = self.plan.cell
        others = [load for load in self.plan.loads if not np.array_equal(load, cell.load)]
        if not others:
            return
        moving = motion_of(cell, states)
        way = np.sign(self.nodes["q"][segment + 1] - self.nodes["q"][segment])
        rows = motion_rows(cell, replace(moving, travel=np.stack([way, way])), self.plan.options.sharing)
        for load in others:
            yield motion_widening(rows, np.ones(len(segment)), load)


def limit_tables(plan: Plan, *, backwards: bool) -> PlayedTables:
    """Tables with which a plan keeps its limits, between their nodes too.

    Raises:
        InputError: If the cell cannot stand still somewhere on it, or limits are passed between its samples.
        CompilerError: If there is no C compiler, or it fails.
        SolverError: If no solver answers.
    """
    library = _opened(plan.cell)
    for _ in range(ROUNDS + 1):
        tables = _within_limits(plan, library, backwards=backwards)
        slower = reachable(tables.corners, backwards=backwards)
        if np.all(slower >= tables.plan.most):
            break
        plan = replace(tables.plan, most=slower)
    over = np.max(tables.passed, axis=1)
    if np.max(over) > MOST_PASSED:
        where = f"between {', '.join(f'{time:.4g}' for time in tables.nodes['time'][np.argmax(over) :][:2])} s"
        rule = f"{where} of the plan a limit would be passed by {100 * np.max(over):.1f} %"
        what = "played in either direction: leave `backwards` out" if backwards else "between samples: give more"
        raise InputError("result", f"{rule}, {what}, or plan with a reserve.")
    return tables


def _within_limits(plan: Plan, library: ctypes.CDLL, *, backwards: bool) -> PlayedTables:
    """Tables with what they pass between nodes taken off: more nodes first, then limits inward, then accelerations."""
    margin = np.zeros(plan.motion.samples)
    for turn in range(ROUNDS):
        tables = PlayedTables(corners_of(plan, backwards=backwards, margin=margin), library, backwards=backwards)
        # a plan without jumps has wrenches of its own
        planned = plan.wrench is not None and bool(np.all(plan.most == 1))
        chosen = np.arange(6) != (PLAYED if planned else -1)
        over = np.max(np.where(chosen, tables.passed, 0.0), axis=1)
        if np.max(over) <= BETWEEN:
            return tables
        bent = np.flatnonzero(over > BENT)
        if bent.size and turn < DIVISIONS:
            inside = np.diff(tables.nodes["time"])[bent] / 2
            plan = divided(plan, bent, tables.states(bent, inside, np.ones(len(bent)), np.zeros(len(bent))))
            margin = np.insert(margin, bent + 1, margin[bent])
        else:
            over = np.append(np.where(over > BETWEEN, over, 0.0), 0.0)
            margin = np.minimum(margin + np.maximum(over, np.roll(over, 1)), MOST_MARGIN)
    return _lowered(tables)


def _lowered(tables: PlayedTables) -> PlayedTables:
    """Tables less accelerations that pass limits between nodes, where the plan does not do so without any."""
    for _ in range(LOWERINGS):
        without, passed = tables.passed[:, [AT_REST, AT_MOST] * 2], tables.passed[:, 2:]
        over = (passed > BETWEEN) & (passed > without + BETWEEN / 10)
        over = np.append(over, np.zeros((1, 4), dtype=bool), axis=0)
        if not np.any(over):
            break
        part = np.where(over | np.roll(over, 1, axis=0), LESS, 1.0)
        tables = tables.of(tables.corners.lowered(part.reshape(-1, 2, 2)))
    return tables


def rate_tables(whole: PlayedTables, limits: RateLimits) -> PlayedTables:
    """Of tables that are found for limits alone, those with accelerations with which stops within rates are soonest.

    Raises:
        InputError: If the plan's accelerations jump, it may be played faster, or it leaves too little of its rates.
    """
    plan, backwards = whole.plan, bool(whole.c["backwards"])
    if plan.wrench is None or np.ptp(plan.most):
        jumps = "whose accelerations do not jump: take one by a constant factor, or a smooth one."
        rule = f"go with a plan {jumps}" if plan.wrench is None else "do not go with a speed above the plan's."
        raise InputError("rates", rule)
    kept, best = max(BETWEEN, float(np.max(whole.passed))), None
    given = whole.corners.hold
    hold = np.broadcast_to(given[:, 1:], given.shape)  # the plan's wrenches hold too, if limits admit it
    steady = bool(np.max(whole.of(replace(whole.corners, hold=hold)).passed[:, AT_REST]) <= kept)
    hold = hold if steady else given
    for part in PARTS:
        level = _lowered(whole.of(_levelled(whole.corners, part, hold)))
        level = whole.of(_levelled(level.corners, 1.0, hold))
        level.c["coulomb"] = 0.0  # rates are of torques without dry friction, which jumps
        changes = _largest_changes(level, limits)
        tables = whole.of(_followed(level.corners, changes, backwards=backwards), keeps_rates=True)
        longest = float(np.max(tables.stops(tables.starts(), TICK)[0]))
        sound = np.all(tables.corners.acceleration) and np.max(tables.passed) <= kept
        if sound and (best is None or longest < best[0]):
            best = longest, tables
    if best is not None:
        return best[1]
    worst = whole.nodes["time"][int(np.argmin(changes[:, 1]))]
    rule = (
        f"the plan leaves too little of its limits of rates for a speed that changes, least at {worst:.4g} s. "
        "Give about twice those that it was made with, or make it with reserve=0.5."
    )
    if not steady:
        rule = (
            "the plan's wrenches do not hold the object at rest, and those that do change too fast for rates. "
            "Leave rates out, or plan with a reserve."
        )
    raise InputError("rates", rule)


def _levelled(corners: Corners, part: float, hold: Array) -> Corners:
    """Accelerations alike at rest and at the largest speed, up to a part of the median one, and steady wrenches.

    What the object takes for them goes to all arms alike, as what wrenches lack does while it plays: the wrenches of
    the hardest accelerations are found node by node, and change from one to the next faster than rates allow.
    """
    size = np.abs(corners.acceleration)
    most = part * np.median(size)
    least = np.minimum(np.min(size, axis=2, keepdims=True), most) * np.sign(corners.acceleration)
    accelerate = np.broadcast_to(hold[:, None], corners.accelerate.shape)
    return replace(corners, acceleration=least, hold=hold, accelerate=accelerate)


def _largest_changes(tables: PlayedTables, limits: RateLimits) -> Array:
    """Largest |u̇| at rest and at the largest speed, below 0 where rates are passed anyhow, Shape (n, 2)."""
    corners, rates = tables.corners, np.concatenate([limits.torque, limits.wrench, limits.jerk])
    step = np.diff(corners.plan.motion.object.time)
    segment = np.flatnonzero(step)

    def changing(inside: Array, v: Array, u: Array) -> Array:
        states = tables.states(segment, inside, v, u)
        return np.concatenate([states["torque"], states["wrench"], states["ddq"]], axis=1)

    found = np.full((len(SPEED_PARTS), len(step)), INFINITY)
    for speed, of_speed in enumerate(SPEED_PARTS):
        for place in RATE_PLACES:
            least, largest, most = (
                of[segment] + place * (of[segment + 1] - of[segment])
                for of in (corners.acceleration[:, 0, 0], corners.acceleration[:, 1, 0], corners.plan.most)
            )
            v, inside = of_speed * np.sqrt(most), place * step[segment]
            tried = (least, np.zeros_like(v), largest)
            here = [changing(inside, v, u) for u in tried]
            per_u = [
                np.divide(value - here[1], u[:, None], out=np.zeros_like(value), where=u[:, None] != 0)
                for value, u in ((here[0], least), (here[2], largest))
            ]
            slope = np.maximum(*np.abs(per_u))
            for value, u in zip(here, tried, strict=True):
                dt = AHEAD * step[segment] / np.maximum(1.0, v + np.abs(u) * step[segment])
                left = rates - np.abs(changing(inside + v * dt, v + u * dt, u) - value) / dt[:, None]
                with np.errstate(divide="ignore", invalid="ignore"):
                    room = np.where(np.isfinite(left) & (slope > 0), left / slope, np.where(left < 0, left, INFINITY))
                found[speed, segment] = np.minimum(found[speed, segment], np.min(room, axis=1))
    at_rest, half, most_ = found
    pairs = np.stack([at_rest, np.minimum(most_, 2 * half - at_rest)])  # the line between lies below at half the speed
    shown = np.full((2, len(step) + 1), INFINITY)
    shown[:, :-1] = pairs
    shown[:, 1:] = np.minimum(shown[:, 1:], pairs)
    return np.asarray(shown.T)


def _followed(corners: Corners, rate: Array, *, backwards: bool) -> Corners:
    """Corners whose accelerations a governor can follow with changes up to `rate`, Shape (n, 2)."""
    time, least = corners.plan.motion.object.time, np.maximum(np.min(rate, axis=1), 0.0)
    count, fastest = len(time), float(np.sqrt(np.max(corners.plan.most)))
    size = np.abs(corners.acceleration[:, :, 0])
    room, ahead = _until_none(np.max(size, axis=1), least, time / fastest)
    if backwards:
        back = _until_none(np.max(size, axis=1)[::-1], least[::-1], -time[::-1] / fastest)
        room, ahead = (np.minimum(of, other[::-1]) for of, other in zip((room, ahead), back, strict=True))
    size = np.minimum(size, room[:, None])
    follow = np.minimum(least[:-1], least[1:]) * np.diff(time) / fastest
    for k in range(count - 2, -1, -1):
        size[k] = np.minimum(size[k], size[k + 1] + follow[k])
    for k in range(1, count):
        size[k] = np.minimum(size[k], size[k - 1] + follow[k - 1])
    given = np.abs(corners.acceleration)
    part = np.divide(size[:, :, None], given, out=np.zeros_like(given), where=given > 0)
    return replace(corners.lowered(part), rate=rate, rate_ahead=ahead)


def _until_none(wanted: Array, change: Array, time: Array) -> tuple[Array, Array]:
    """The u up to those wanted from which changes lead back to 0 before any that is less begins, and that change.

    At the end of the plan nothing moves, whatever u is.
    """
    room, least = np.zeros_like(time), np.zeros_like(time)
    for k in range(len(time)):
        lowest = np.minimum.accumulate(change[k:])
        reach = np.append(lowest[:-1] * (time[k:-1] - time[k]), np.inf if lowest[-1] > 0 else 0.0)
        enough = np.flatnonzero(reach >= wanted[k])
        best = int(enough[0]) if enough.size else int(np.argmax(reach))
        room[k], least[k] = min(reach[best], wanted[k]), lowest[best]
    return room, least


def _structure(name: str, cell: Cell) -> np.dtype[Any]:
    """A structure of the exported header: `cell_plan_node`, `cell_plan`, or `cell_override`, the state."""
    sizes = {"CELL_JOINTS": len(cell.joint_names), "CELL_LOAD": len(LOAD_ENTRIES)}
    sizes["CELL_WRENCHES"] = len(cell.robots) * len(cell.wrench_components)
    made: np.dtype[Any] = np.dtype(structure("exported/cell_override.h", name, **sizes))
    return made


def _plan_nodes(corners: Corners) -> NDArray[Any]:
    """The tables of a plan as C reads them, Shape (n,)."""
    cell, motion = corners.plan.cell, corners.plan.motion
    axes = object_axes(cell, motion)
    nodes = np.zeros(motion.samples, _structure("cell_plan_node", cell))
    for name in ("q", "dq", "ddq"):
        nodes[name] = getattr(motion, name)
    nodes["dq"][~moving_joints(motion.dq)] = 0.0  # friction is against the way ahead
    nodes["time"], nodes["most"] = motion.object.time, corners.plan.most
    for name in ("acceleration", "active", "rate", "rate_ahead"):
        nodes[name] = getattr(corners, name)
    for name in ("hold", "accelerate"):
        given = getattr(corners, name)
        columns = given.reshape(len(given), -1, given.shape[-1]).transpose(0, 2, 1)
        nodes[name] = turned(axes, columns).transpose(0, 2, 1).reshape(given.shape)
    return nodes


def _opened(cell: Cell) -> ctypes.CDLL:
    """The exported functions that play a plan, compiled unless the cache holds them."""
    manifest, generated = cell.generated.manifest, cell.generated.origin
    if not isinstance(generated, str):
        cell.library  # noqa: B018 (it says what is missing)
    source = override_source(manifest, str(generated))
    return compiled_library("override", source, (OVERRIDE,))
