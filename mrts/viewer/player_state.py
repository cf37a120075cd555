# SPDX-License-Identifier: MIT
"""What a viewer shows: a motion played at a chosen speed, admissible or not, or arms that do not reach.

Speeds on offer, torques and limits of a motion; arms that hold the object or come as near as they can, of a cell that
stands or along a motion out of reach.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, floor, inf, isfinite, log10, sqrt
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.following.bodies import tip_at_posture
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.tracking import FURTHER_STEPS, reached, solve_grasps
from mrts.limits import limit_rows
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.plots.card import Card, answer_card
from mrts.program.infeasibility import widening_at
from mrts.program.rate_limits import Rates
from mrts.program.reserve import reserved
from mrts.program.sample_problem import SampleProblem
from mrts.program.torque_distribution import motion_torques, torque_weights, torques_by_blocks
from mrts.scaling.options import Options
from mrts.scaling.range import ScalingRange
from mrts.scaling.scale import LIMIT_TOLERANCE, ScalingResult, SelectionError, scale
from mrts.scaling.scaled_trajectory import LimitUse, ScaledTrajectory, by_share
from mrts.scene.scene import Scene
from mrts.timing.result import RetimingResult
from mrts.timing.retime import retime

BEYOND = 1.2
"""Speeds are offered up to this factor beyond an end of the range, so that one sees what forbids them."""

FASTEST_INFEASIBLE, FASTEST_UNBOUNDED = 2.0, 3.0
"""Largest offered c where no end gives one."""

SLOWEST = 0.02
"""Least offered c, as a share of the largest, where the cell may stand still."""

STEPS = 400
"""Least number of speeds on offer."""

INTERIOR = 1e-6
"""A widened limit is widened by this share more: at the least widening the feasible set is a point."""

Profile = Literal["constant", "optimal", "smooth"]

MOST_SAMPLES = 41
"""Samples that are looked at: a picture of where arms end needs no more."""


@dataclass(frozen=True)
class Speeds:
    """The speeds c that are offered: from `lower` to `upper` in `digits` decimal places; `start` is the first choice.

    `ends` are those c² of both ends that are finite and > 0.
    """

    ends: list[float]
    lower: float
    upper: float
    digits: int
    start: float

    def c2(self, c: float) -> float:
        """The c² that a c on offer stands for: the exact end where the end lies within half a step."""
        near = [c2 for c2 in self.ends if abs(sqrt(c2) - c) <= 10.0**-self.digits / 2]
        return near[-1] if near else c * c


def offered_speeds(found: ScalingRange) -> Speeds:
    """Speeds to slightly beyond both ends of a range of c²; without an admissible one c = 1 is the first choice."""
    both = found.lower.c2, found.upper.c2
    ends = [c2 for c2 in both if isfinite(c2) and c2 > 0]
    of_ends, moves = [sqrt(c2) for c2 in ends], found.status.admits_motion and both[1] > 0
    start, most = 1.0, FASTEST_UNBOUNDED if moves else FASTEST_INFEASIBLE
    if moves and isfinite(both[1]):
        start, most = sqrt(both[1]), 0.0
    elif moves:
        start = max(1.0, sqrt(both[0]))
    upper = max([most, *(BEYOND * c for c in of_ends)])
    stands = not 0 < both[0] < inf or found.samples.several
    lower = SLOWEST * upper if stands else min([start, *of_ends]) / BEYOND
    digits = max(0, -floor(log10((upper - lower) / STEPS)))
    steps = 10.0**digits
    return Speeds(ends, max(floor(lower * steps), 1) / steps, ceil(upper * steps) / steps, digits, start)


OF_TIMINGS = Speeds(ends=[1.0], lower=0.1, upper=BEYOND, digits=3, start=1.0)
"""Speeds of a timing that was found: shares of its own."""


@dataclass(frozen=True, eq=False)
class PlayerState:
    """A motion at a chosen speed, admissible or not.

    Attributes:
        found: The answer for the constant profile, or the timing that was asked for, or why there is none.
        trajectory: At the chosen speed; where limits do not admit it, that of `widened_torques`.
        speeds: The speeds on offer.
    """

    found: ScalingResult | RetimingResult
    trajectory: ScaledTrajectory
    speeds: Speeds

    @classmethod
    def saved(cls, found: ScalingResult | RetimingResult) -> "PlayerState":
        """A result that was read from a file, at its own speed: other torques take the functions of its cell."""
        done = played_result(found).done
        return cls(found, done, Speeds([], done.c, done.c, 0, done.c))

    @property
    def timing(self) -> RetimingResult | None:
        """The timing that was found; None of the constant profile, and where there is none."""
        found = self.found
        return found if isinstance(found, RetimingResult) and found.retimed is not None else None

    @property
    def result(self) -> ScalingResult:
        """As of `played_result`."""
        return played_result(self.found)

    def at_speed(self, c: float) -> "PlayerState":
        """The same outcome played at another speed, a factor > 0: one within half a step of an end is that end.

        Raises:
            SolverError: If no solver answers.
        """
        return replace(self, trajectory=_trajectory(self.result, self.speeds.c2(c)))

    @cached_property
    def excess(self) -> Array:
        """Share by which a limit that is kept is overstepped at most at each sample, 0 for rounding, Shape (N,)."""
        done = self.trajectory
        kept = limit_rows(done.cell, done.motion)
        excess = np.max(kept.excess(kept.value(done.torque, done.wrench, 0.0, done.c)), axis=1, initial=0.0)
        return np.where(excess > LIMIT_TOLERANCE, excess, 0.0)

    @cached_property
    def scene(self) -> Scene:
        """What is drawn of it."""
        return Scene.of(self.trajectory, self.excess > 0)

    @property
    def played(self) -> ScalingResult:
        """The result with the trajectory at the chosen speed, whether or not that is admissible."""
        done, result = self.trajectory, self.result
        return replace(result, found=result.range, c2=done.c2, trajectory=done)

    @property
    def plan(self) -> ScalingResult | RetimingResult:
        """What is played, as it was found; a timing at its own speed."""
        timing = self.timing
        return timing if timing is not None and self.trajectory.c2 == 1 else self.played

    @property
    def card(self) -> Card:
        """The answer in one line, and the limits that are nearest; where no speed is admissible, why."""
        return answer_card(self.plan)

    @property
    def admissible(self) -> bool:
        """Whether the chosen speed is in the range; a smooth timing keeps its rates at its own speed only."""
        return self.plan is self.found or self.result.admitted(self.trajectory.c2) is not None

    def violations(self) -> list[LimitUse]:
        """Limits that are passed at some sample, the worst first."""
        return [use for use in by_share(self.trajectory.limit_uses) if use.share > 1 + LIMIT_TOLERANCE]


def play(
    cell: Cell, motion: ObjectMotion | JointTable, *, profile: Profile = "constant", rates: Rates = False, **asked: Any
) -> PlayerState:
    """Find a motion at its fastest admissible speed, or c = 1 if there is none; with options of `mrts.scale`.

    Raises:
        MrtsError: As `mrts.scale`; an infeasible motion is no error.
    """
    found: ScalingResult | RetimingResult
    if profile == "constant":
        try:
            found = scale(cell, motion, **asked)
        except SelectionError as error:  # it can only hold still, or c = 1 is too slow where nothing is too fast
            found = error.result
    else:
        found = retime(cell, motion, rates=rates if profile == "smooth" else False, **asked)
        found.factor  # noqa: B018 (found here, not by whoever shows it)
    result = played_result(found)
    result.range.samples  # noqa: B018 (likewise)
    speeds = OF_TIMINGS if result.origin else offered_speeds(result.range)
    return PlayerState(found, _trajectory(result, speeds.c2(speeds.start)), speeds)


def played_result(found: ScalingResult | RetimingResult) -> ScalingResult:
    """The range, or of a timing what is played, whose c² = 1 is the timing itself."""
    return found if isinstance(found, ScalingResult) else found.retimed or found.factor


def _trajectory(result: ScalingResult, c2: float) -> ScaledTrajectory:
    cell, motion, options, done = result.cell, result.motion, result.options, result.trajectory
    if done is not None and done.c2 == c2:
        return done
    if result.admitted(c2) is None:
        torque, wrench = widened_torques(cell, motion, options, c2)
    else:
        rows, weights = options.rows(cell, motion), torque_weights(options.weights, cell)
        torque, wrench = motion_torques(rows, c2, weights, options.distribute)
    return ScaledTrajectory(cell, motion, c2, torque, wrench)


def widened_torques(cell: Cell, motion: CoordinatedMotion, options: Options, c2: float) -> tuple[Array, Array]:
    """Torques, Shape (N, m), and wrenches, Shape (N, n w), at any c² > 0.

    At a sample that keeps its limits at this c² they are those of `motion_torques`. At any other, all limits are
    first moved outward by the least share of their size that leaves a solution, so that what is beyond its limit is
    what forbids the speed. A fixed distribution asks no limits.

    Raises:
        InputError: If an option breaks a rule.
        SolverError: If no solver answers.
    """
    by_reserve = options.distribute == "reserve"
    cell = cell.with_reserve(0.0) if by_reserve else cell  # it is of the limits as they are given
    W = torque_weights(options.weights, cell)

    def widened(problem: SampleProblem) -> SampleProblem:
        problem = problem.only(np.flatnonzero(np.any(problem.free, axis=(0, 2))))  # torques change no other row
        widening = _least_widening(problem, c2)[:, None]
        problem = replace(problem, lower=problem.lower - widening, upper=problem.upper + widening)
        return reserved(problem, c2) if by_reserve else problem

    rows = options.rows(cell, motion)
    return torques_by_blocks(rows, c2, W, within=widened)


def _least_widening(problem: SampleProblem, c2: float) -> Array:
    if problem.unknowns == 1:
        return np.zeros(problem.samples)
    share = widening_at(problem, c2)
    return np.where(share > INTERIOR, share * (1 + INTERIOR), share)


@dataclass(frozen=True, eq=False, kw_only=True)
class HeldPoses:
    """Where arms are at k poses of the object, by joint positions that come nearest.

    Attributes:
        gap: What is left between tip and grasp, Shape (k, robots) [m].
        reached: Whether an arm holds its grasp, Shape (k, robots); by itself, perhaps in another branch.
        message: Why some arm cannot follow the motion, with robot, sample and amount; empty where none was given.
    """

    scene: Scene
    gap: Array
    reached: NDArray[np.bool_]
    message: str = ""


def still_motion(cell: Cell) -> ObjectMotion:
    """The object at rest where the first arm holds it at its posture."""
    robot = cell.robots[0]
    held = tip_at_posture(robot) @ robot.T_object_tip.inverse()
    rest = np.zeros((2, 6))
    return ObjectMotion(np.array([0.0, 1.0]), np.tile(held.p, (2, 1)), np.tile(held.R, (2, 1, 1)), rest, rest)


def held_poses(cell: Cell, motion: ObjectMotion, message: str = "") -> HeldPoses:
    """How near arms come to their grasps along a motion that they cannot follow, or one as of `still_motion`."""
    count = min(MOST_SAMPLES, len(motion.time))
    samples = np.unique(np.linspace(0, len(motion.time) - 1, count).round().astype(np.intp))
    start = np.tile(cell.posture, (len(samples), 1))
    held, gap, turn, _ = solve_grasps(cell, motion, samples, start, FURTHER_STEPS)
    holds = reached(gap, turn)
    carried = motion.time[samples], held, motion.position[samples], motion.rotation[samples]
    scene = Scene(cell, *carried, passed=~np.all(holds, axis=1))
    return HeldPoses(scene=scene, gap=gap, reached=holds, message=message)
