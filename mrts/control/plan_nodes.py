# SPDX-License-Identifier: MIT
"""The tables of a plan that may be played at any speed: accelerations that limits admit, and wrenches with them.

A plan has a time of its own, s, and a speed along it: with x = ṡ² and u = s̈ torques are A u + E x + V ṡ + G + JᵀF. At
one s every limit is linear in u, x and F, so what lies between points that have admissible wrenches is admissible with
the same mixture of these. Six points a node: without acceleration, at the least and at the largest, each at rest and at
the largest x. Friction and torque-speed lines grow with √x, which lies above the chord: at rest their rows are moved
inward by half of what they are at the largest speed, which is the most that the mixture then lacks.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply
from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion, carried_by_first
from mrts.kernel.binding import INFINITY
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.rows_at_rest import REST
from mrts.program.infeasibility import least_widening
from mrts.program.motion_rows import motion_rows, travel_directions
from mrts.program.reserve import reserved
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.program.sample_ranges import motion_ranges
from mrts.program.solvers import ConvexPrograms, solve_programs
from mrts.program.torque_distribution import distribute_torques, torque_weights
from mrts.scaling.options import Options
from mrts.scaling.scale import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory
from mrts.timing.result import RetimingResult, TimedPiece, at_segment_ends, new_times

HARDEST = 0.98
"""Share of the hardest braking and acceleration, and of the largest x, that is used: at the end itself wrenches are one
point, and jump from node to node."""

STEEPEST = 2.0
"""Times the acceleration of the nodes beside that a node may have: near an end of the plan, where nothing moves, any
would do, and a line between two nodes would not."""

BRAKES = 0.8
"""Share of the braking at two nodes that a largest speed may ask for between them: ticks are not nodes."""

SAME_ACCELERATION = 1e-3
"""Share of the largest acceleration of a joint up to which those before and after a sample are one."""

HIGHEST = 1e3
"""Acceleration of the plan's time that nothing exceeds [1/s²]: from rest to the planned speed in 1 ms."""

HOLDS = 1e-7
"""Share of a limit by which standing still may pass it: rounding."""

LEAST = 1e-3
"""Acceleration below which nodes are alike [1/s²]: from rest it takes a quarter of an hour to the planned speed."""

SPEEDS = "range of speeds"
"""What is active where a speed is wanted that no place of the plan has."""

BRAKE, PUSH = 0, 1
AT_REST, AT_MOST = 0, 1


@dataclass(frozen=True)
class Plan:
    """A plan in its own time.

    Attributes:
        cell: The cell with the limits as they are given, whatever reserve the plan kept.
        motion: At n nodes; its time is s, twice the same where the acceleration jumps.
        wrench: Planned contact wrenches in base axes, Shape (n, n w); None where they jump with the acceleration.
        options: What was asked of it.
        loads: Load vectors that it carries, each Shape (10,).
        most: Largest x, 1 unless it may be played faster, Shape (n,).
        has_speed_terms: Whether a row has a term in ṡ beside others.
    """

    cell: Cell
    motion: CoordinatedMotion
    wrench: Array | None
    options: Options
    loads: tuple[Array, ...]
    most: Array
    has_speed_terms: bool


@dataclass(frozen=True, kw_only=True)
class Corners:
    """What limits leave at n nodes of a plan, and wrenches in base axes.

    Attributes:
        plan: The plan at the nodes.
        acceleration: Least and largest u, at rest and at the largest x, Shape (n, 2, 2) [1/s²].
        active: Rows that set these, and what bounds the speed, as places in `names`, Shape (n, 5).
        hold: Wrenches at u = 0, at rest and at the largest x, Shape (n, 2, n w).
        accelerate: Wrenches at `acceleration`, Shape (n, 2, 2, n w).
        names: What is active, "" first.
        rate: Largest |u̇|, at rest and at the largest speed, Shape (n, 2) [1/s³].
        rate_ahead: The least of these until u has become 0 again, Shape (n,) [1/s³].
    """

    plan: Plan
    acceleration: Array
    active: NDArray[np.int16]
    hold: Array
    accelerate: Array
    names: tuple[str, ...]
    rate: Array
    rate_ahead: Array

    @property
    def corners(self) -> list[tuple[Array, Array]]:
        """Accelerations u and squared speeds x of the six points, each Shape (n,)."""
        most, hardest = self.plan.most, self.acceleration.reshape(-1, 4).T
        none = np.zeros_like(most)
        return list(zip([none, none, *hardest], [none, most] * 3, strict=True))

    def lowered(self, part: Array) -> "Corners":
        """The same with a part of each acceleration, Shape (n, 2, 2), and the mixture of wrenches that goes with it."""
        hold = self.hold[:, None]
        accelerate = hold + part[..., None] * (self.accelerate - hold)
        return replace(self, acceleration=part * self.acceleration, accelerate=accelerate)


def trajectory_of(plan: ScalingResult | RetimingResult | ScaledTrajectory) -> ScaledTrajectory | None:
    """The trajectory of a result; None if it has none."""
    shown = plan.retimed if isinstance(plan, RetimingResult) else plan
    return shown.trajectory if isinstance(shown, ScalingResult) else shown


def resting_trajectory(plan: ScalingResult | RetimingResult | ScaledTrajectory, key: str) -> ScaledTrajectory:
    """The trajectory of a result that a controller is to play; `key` is the argument that it is.

    Raises:
        InputError: If it has none, or one that does not start and end at rest.
    """
    done = trajectory_of(plan)
    if done is None:
        raise InputError(key, "has no trajectory: there is no speed at which it keeps its limits.")
    if np.max(np.abs(done.dq[[0, -1]])) > REST * np.max(np.abs(done.dq)):
        raise InputError(key, "must start and end at rest: a controller holds still before and after it.")
    return done


def plan_of(result: ScalingResult | RetimingResult, fastest: float) -> Plan:
    """The plan of a result.

    Args:
        result: The result.
        fastest: The largest speed along it, 1 or more; less where limits leave less.

    Raises:
        InputError: If it has none, or one that does not start and end at rest.
    """
    timed, done = result if isinstance(result, RetimingResult) else None, resting_trajectory(result, "result")
    cell, options = result.cell.with_reserve(0.0), result.options
    if options.sharing is not None and options.sharing.varies:
        raise InputError(
            "result", "has an internal wrench of each sample: between them none is known. Give one for all."
        )
    jumps = timed.pieces if timed and timed.smooth is None else ()
    motion = _both_sides(jumps) if jumps else done.played
    varies = cell.load_box is not None and options.load == "guaranteed"
    loads = tuple(point.load for point in cell.load_box.corners()) if varies and cell.load_box else (cell.load,)
    loads = timed.loads if timed else loads
    most, rows = np.full(motion.samples, fastest**2), motion_rows(cell, motion, options.sharing)
    if fastest > 1:
        upper = [motion_ranges(rows, load, fastest**2).upper for load in loads]
        most = np.maximum(np.minimum(most, HARDEST * np.min(upper, axis=0)), 1.0)
    return Plan(cell, motion, None if jumps else done.wrench, options, loads, most, rows.has_speed_terms)


def _both_sides(pieces: Sequence[TimedPiece]) -> CoordinatedMotion:
    """The plan before and after each of its samples; once where its acceleration does not jump."""
    times, sides = new_times(pieces), [tuple(map(_columns, at_segment_ends(part))) for part in pieces]
    values = {
        name: np.concatenate([np.stack([first[name], last[name]], axis=1) for first, last in sides])
        for name in sides[0][0]
    }
    values = {name: of.reshape(-1, *of.shape[2:]) for name, of in values.items()}
    change = np.max(np.abs(np.diff(values["ddq"], axis=0)), axis=1)
    same = np.append(change <= SAME_ACCELERATION * np.max(np.abs(values["ddq"])), False)
    same[::2] = False  # the two ends of a segment
    kept = np.append(True, ~same[:-1])
    return _motion(np.repeat(times, 2)[1:-1][kept], {name: of[kept] for name, of in values.items()})


def _columns(motion: CoordinatedMotion) -> dict[str, Array]:
    """What a motion is at its samples, with the directions of travel before and after each, Shape (N, 2, m)."""
    of, travel = motion.object, travel_directions(motion).transpose(1, 0, 2)
    columns = {"q": motion.q, "dq": motion.dq, "ddq": motion.ddq, "travel": travel, "position": of.position}
    return columns | {"rotation": of.rotation, "twist": of.twist, "acceleration": of.acceleration}


def _motion(time: Array, of: dict[str, Array]) -> CoordinatedMotion:
    poses = (of[name] for name in ("position", "rotation", "twist", "acceleration"))
    travel = np.ascontiguousarray(of["travel"].transpose(1, 0, 2))
    carried = ObjectMotion(time, *poses, checked=False)
    return CoordinatedMotion(carried, of["q"], of["dq"], of["ddq"], travel=travel, checked=False)


def divided(plan: Plan, segments: NDArray[np.intp], states: NDArray[Any]) -> Plan:
    """A plan with one more node in some segments, as the states there say; the object as the first arm carries it."""
    after, here = segments + 1, _columns(plan.motion)
    there = _columns(motion_of(plan.cell, states if len(states) > 1 else states.repeat(2)))
    there = {name: of[: len(states)] for name, of in there.items()} | {"travel": here["travel"][segments][:, [1, 1]]}
    time = np.insert(plan.motion.object.time, after, states["time"])
    motion = _motion(time, {name: np.insert(of, after, there[name], axis=0) for name, of in here.items()})
    planned = None if plan.wrench is None else np.insert(plan.wrench, after, states["wrench"], axis=0)
    most = np.insert(plan.most, after, np.minimum(plan.most[segments], plan.most[after]))
    return replace(plan, motion=motion, wrench=planned, most=most)


def reachable(corners: Corners, *, backwards: bool) -> Array:
    """Largest x at every node from which braking leads below it at all others, Shape (n,)."""
    most, step = corners.plan.most.copy(), np.diff(corners.plan.motion.object.time)
    for side, order in ((BRAKE, range(len(step) - 1, -1, -1)), *([(PUSH, range(len(step)))] if backwards else [])):
        least = BRAKES * np.min(np.abs(corners.acceleration[:, side]), axis=1)
        for k in order:
            node, ahead = (k, k + 1) if side == BRAKE else (k + 1, k)
            most[node] = min(most[node], most[ahead] + 2 * min(least[node], least[ahead]) * step[k])
    return np.asarray(np.maximum(most, 1.0))


def motion_of(cell: Cell, states: NDArray[Any]) -> CoordinatedMotion:
    """Two or more states as samples of a motion, the object as the first arm carries it; its time only counts them."""
    q, dq, ddq = (np.array(states[name]) for name in ("q", "dq", "ddq"))
    return carried_by_first(cell, np.arange(len(q), dtype=np.float64), q, dq, ddq)


@dataclass(frozen=True)
class _Limits:
    """Rows of [F, u] of one load at n nodes, whatever x is.

    Attributes:
        problem: The rows.
        most: Largest x, Shape (n,).
        dry: What dry friction is in each row, Shape (n, r) or (n, 1).
        backwards: Whether friction may be against the plan's direction too.
        margin: Share of itself by which a limit is moved inward, Shape (n,); not beyond what `used` uses.
        passed: Share by which limits are passed without acceleration, at rest and at the largest x, each Shape (n,):
            between its samples a plan may pass one by its tolerance.
        used: Wrenches that hold and play, at rest and at the largest x; None before they are known.
    """

    problem: SampleProblem
    most: Array
    dry: Array
    backwards: bool
    margin: Array
    passed: tuple[Array, ...] | None = None
    used: tuple[Array, Array] | None = None

    def sides(self, end: int) -> tuple[Array, Array]:
        """Lower and upper sides of A [F, u] at rest or at the largest x, each Shape (n, r)."""
        problem, none = self.problem, np.zeros((1, 1))
        lower, upper = problem.limits_at((self.most * end)[:, None])
        root = none if problem.speed is None else problem.speed * np.sqrt(self.most)[:, None]
        chord, turned = (root / 2, self.dry) if end == AT_REST else (none, self.dry + root)
        wider = none if self.passed is None else self.passed[end][:, None]
        low, high = lower + np.maximum(-chord, 0) - wider, upper - np.maximum(chord, 0) + wider
        if self.backwards:
            low = np.maximum(low, lower + 2 * turned + np.maximum(chord, 0) - wider)
            high = np.minimum(high, upper + 2 * turned - np.maximum(-chord, 0) + wider)
        if self.used is None:
            return low, high
        inward = np.where(problem.limit_lower < problem.limit_upper, self.margin[:, None], 0.0)
        uses = apply(problem.A[:, :, :-2], self.used[end][:, : problem.unknowns - 2])
        return np.minimum(low + inward, np.maximum(low, uses)), np.maximum(high - inward, np.minimum(high, uses))

    def wrenches(self, end: int) -> Array:
        """Those that hold, or play; zeros before they are known, Shape (n, n w)."""
        return np.zeros(self.problem.wrench_offset.shape) if self.used is None else self.used[end]


def corners_of(plan: Plan, *, backwards: bool, margin: Array) -> Corners:
    """The tables of a plan.

    Args:
        plan: The plan.
        backwards: Whether limits hold against its direction too.
        margin: Share of itself by which each limit is moved inward at every node, Shape (n,).

    Raises:
        InputError: If the cell cannot stand still at a node.
        SolverError: If no solver answers.
    """
    cell, motion, count = plan.cell, plan.motion, plan.motion.samples
    rows = motion_rows(cell, motion, plan.options.sharing)
    limits, dry = rows.given.limits, np.zeros((count, 1))
    if rows.motors is not None:
        dry = rows.motors.dry @ limits.torque_matrix.T / limits.units
    most, none = plan.most, np.zeros(count)
    of_loads = []
    for load in (cell.load, *(load for load in plan.loads if not np.array_equal(load, cell.load))):
        problem = build_sample_problem(rows, load=load, varying=True)
        of_loads.append(_with_standing(plan, _Limits(problem, most, dry, backwards, none), margin))
    nominal = of_loads[0]
    if plan.wrench is not None:
        planned = np.where(most[:, None] > 1, nominal.wrenches(AT_MOST), plan.wrench)
        nominal = of_loads[0] = replace(nominal, used=(nominal.wrenches(AT_REST), planned))
    names = ("", SPEEDS, *dict.fromkeys(map(str, nominal.problem.names)))
    place = np.array([names.index(str(name)) for name in nominal.problem.names], dtype=np.int16)

    acceleration, active = np.zeros((count, 2, 2)), np.full((count, 5), names.index(SPEEDS), dtype=np.int16)
    for end in (AT_REST, AT_MOST):
        for side, sign in ((BRAKE, -1.0), (PUSH, 1.0)):
            u, row = map(np.array, zip(*(_hardest(limits, end, sign) for limits in of_loads), strict=True))
            worst = np.argmin(np.abs(u), axis=0), np.arange(count)
            acceleration[:, side, end], active[:, 2 * side + end] = u[worst], place[row[worst]]
    acceleration = HARDEST * _evened(motion.object.time, acceleration)
    ends = [(side, end) for side in (BRAKE, PUSH) for end in (AT_REST, AT_MOST)]
    accelerate = np.stack([_wrench(plan, nominal, end, acceleration[:, side, end]) for side, end in ends], axis=1)
    return Corners(
        plan=plan,
        acceleration=acceleration,
        active=active,
        hold=np.stack([nominal.wrenches(end) for end in (AT_REST, AT_MOST)], axis=1),
        accelerate=accelerate.reshape(count, 2, 2, -1),
        names=names,
        rate=np.full((count, 2), INFINITY),
        rate_ahead=np.full(count, INFINITY),
    )


def _with_standing(plan: Plan, limits: _Limits, margin: Array) -> _Limits:
    """The limits with wrenches that hold and play, and from then on the margin.

    Raises:
        InputError: If none hold the object still.
    """
    problem, none = limits.problem, np.zeros(limits.problem.samples)
    passed, dual = zip(*(_passed(problem, *limits.sides(end)) for end in (AT_REST, AT_MOST)), strict=True)
    worst = int(np.argmax(passed[AT_REST]))
    most = float(passed[AT_REST][worst])
    if most > HOLDS:
        row = problem.names[int(np.argmax(np.abs(dual[AT_REST][worst])))]
        raise InputError(
            "result",
            f"the cell cannot stand still at {plan.motion.object.time[worst]:.4g} s of the plan, as stopping asks for: "
            f"{row} passes its limit by {100 * most:.4g} %.",
        )
    wider = replace(limits, passed=passed)
    keeps = plan.options.distribute == "reserve"
    used = [_wrench(plan, wider, end, none, reserve=end == AT_REST or keeps) for end in (AT_REST, AT_MOST)]
    return replace(wider, used=(used[AT_REST], used[AT_MOST]), margin=margin)


def _passed(problem: SampleProblem, lower: Array, upper: Array) -> tuple[Array, Array]:
    """By how much limits are passed at u = 0 whatever the wrenches, Shape (n,), and which rows tell, Shape (n, r)."""
    if problem.unknowns == 2:  # noqa: PLR2004 (u and x)
        beyond = np.maximum(lower, -upper)
        return np.maximum(np.max(beyond, axis=1, initial=0.0), 0.0), beyond
    passed, dual = least_widening(problem.A[:, :, :-2], lower, upper)
    return passed, dual.sum(axis=0)


def _hardest(limits: _Limits, end: int, sign: float) -> tuple[Array, NDArray[np.intp]]:
    """The least (sign -1) or largest (1) u at rest or at the largest x, Shape (n,), and the row that sets it."""
    problem, (lower, upper) = limits.problem, limits.sides(end)
    kept = np.flatnonzero(~problem.is_cap)
    g = np.zeros((problem.samples, problem.unknowns - 1))
    g[:, -1] = -sign
    bound = np.full_like(g, np.inf)
    bound[:, -1] = HIGHEST
    lower, upper = np.hstack([lower[:, kept], -bound]), np.hstack([upper[:, kept], bound])
    programs = ConvexPrograms(H=None, g=g, A=problem.free[:, kept], lower=lower, upper=upper)
    answers = solve_programs(programs, problem.solver)
    still = np.max(np.abs(problem.rate), axis=1) <= REST * np.max(np.abs(problem.rate))
    u = np.where(still, HIGHEST, np.where(answers.verified, sign * answers.x[:, -1], 0.0))
    return sign * np.maximum(u, 0.0), kept[np.argmax(np.abs(answers.dual[:, : len(kept)]), axis=1)]


def _evened(time: Array, acceleration: Array) -> Array:
    """Accelerations at most `STEEPEST` times those of the nodes beside."""
    found, ends = acceleration.copy(), np.flatnonzero(np.diff(time) > 0) + 1
    for node, beside in [*((k, k - 1) for k in ends), *((k - 1, k) for k in ends[::-1])]:
        most = STEEPEST * np.maximum(np.abs(found[beside]), LEAST)
        found[node] = np.clip(found[node], -most, most)
    return found


def _wrench(plan: Plan, limits: _Limits, end: int, u: Array, *, reserve: bool = False) -> Array:
    """Wrenches with u within the limits, base axes, Shape (n, n w): those that are used already where u is 0."""
    moving, found = np.flatnonzero(u) if limits.used else np.arange(len(u)), limits.wrenches(end).copy()
    if not len(moving):
        return found
    (lower, upper), problem, x, u = limits.sides(end), limits.problem.at(moving), end * limits.most[moving], u[moving]
    none = np.zeros((*problem.A.shape[:2], 1))
    by_u = problem.rate * u[:, None]
    there: dict[str, Any] = {}
    for of in ("torque", "wrench"):
        maps, offset = getattr(problem, f"{of}_map"), getattr(problem, f"{of}_offset")
        there[f"{of}_map"] = np.concatenate([maps[:, :, :-2], np.zeros((*maps.shape[:2], 1))], axis=2)
        there[f"{of}_offset"] = offset + maps[:, :, -2] * u[:, None] + maps[:, :, -1] * x[:, None]
    if problem.torque_speed is not None:
        there["torque_offset"] = there["torque_offset"] + problem.torque_speed * np.sqrt(x)[:, None]
    alone = replace(
        problem,
        **there,
        A=np.concatenate([problem.A[:, :, :-2], none], axis=2),
        lower=lower[moving] - by_u,
        upper=upper[moving] - by_u,
        speed=None,
        torque_speed=None,
    )
    if reserve:
        alone = reserved(alone, 0.0)
    weights = torque_weights(plan.options.weights, plan.cell)
    found[moving] = alone.wrench(distribute_torques(alone, 0.0, weights))
    return found
