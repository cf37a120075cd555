# SPDX-License-Identifier: MIT
"""Smooth timing: one arm with limited jerk against copp's third-order solver, two arms with torque rates.

One arm: published robots, random paths (jerk_paths.py), the same joint path, velocity, torque and jerk
limits and number of points. copp gets its two linearisations as its authors advise (the second-order optimum, then
about its first answer); robot, limits and torques at the points are made once for it, outside the measured calls.
Two arms: the shipped dual UR5-class cell with its wrench limits, torque rates of 11 times the torque limit a second; no
neighbour asks this. One process on one processor, CPU time, medians of runs in turn.
"""

import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from cases import shipped
from interleaved import median_times, on_one_processor, show

import mrts
from mrts.program.path_solver import KernelSolver, last_step, successive_steps
from mrts.program.smooth_program import Goal

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "cases"))
import copp_timing
from jerk_paths import JerkPath, jerk_path

ROBOTS = {"ur5": 0, "panda": 1}
"""Published robots, and which of their paths is measured."""

PATHS = 10
POINTS = (200, 1000)
INSIDE = 20
DUAL_POINTS = 200
RATE = 11.0
REPEATS = 3


def longer_and_excess(paths: Sequence[JerkPath], points: int) -> None:
    """Durations of all paths against copp's, and what both overstep between their points."""
    longer, ours_over, theirs_over = [], [], []
    for path in paths:
        ours = mrts.retime(path.cell, path.motion(points), rates=True)
        profile, s, duration = copp_timing.by_copp(path, points)
        longer.append(float(ours.duration or np.inf) / duration - 1)
        ours_over.append(copp_timing.dense_of_ours(ours, path, INSIDE).excess(path))
        theirs_over.append(copp_timing.dense(profile, s, duration, INSIDE).excess(path))
    low, middle, high = np.percentile(longer, [0, 50, 100])
    print(f"  {points:>4} points  duration against copp's: {low:+.2%} to {high:+.2%}, median {middle:+.2%}")
    for name, over in (("mrts", ours_over), ("copp", theirs_over)):
        worst = np.maximum(np.max(over, axis=0), 0.0)
        shares = ", ".join(
            f"{kind} {share:.2%}" for kind, share in zip(("speed", "torque", "jerk"), worst, strict=True)
        )
        print(f"  {points:>4} points  {name} oversteps between its points at most: {shares}")


def steps(found: mrts.RetimingResult, given: float) -> Callable[[], Any]:
    """The convex programs alone, from the rows of a path that was found before.

    Args:
        found: A smooth timing of one piece.
        given: Duration of the given motion [s].
    """
    program, smooth = found.pieces[0].program, found.smooth  # type: ignore[attr-defined]  # a SmoothPiece
    around = np.full(len(program.square), (given / smooth.bound) ** 2)  # type: ignore[union-attr]

    def run() -> float:
        solver = KernelSolver()
        taken = last_step(program, successive_steps(program, around, Goal(), solver), Goal(), solver)
        return program.duration(taken.profile.x)

    return run


def rows_given(path: Any, points: int) -> Callable[[], float]:
    """Copp's two linearisations, limits of the path given."""
    robot, s = copp_timing.constraints_of(path, points)
    fastest = robot.constraints.amax_values()

    def run() -> float:
        robot.constraints.amax_substitute(fastest, 0)
        return float(copp_timing.copp.interpolation.s_to_t_topp3(s, copp_timing.third_order(robot, points))[0])

    return run


def report(candidates: dict[str, Callable[[], float]], points: int, repeats: int) -> None:
    """Print the times of some candidates."""
    durations = {label: run() for label, run in candidates.items()}
    times = median_times(candidates, repeats)
    show(times, points, "point", {label: f"duration {seconds:.6f} s" for label, seconds in durations.items()})


def one_arm(robot: str, path: JerkPath, points: int, repeats: int) -> None:
    """One path, our ways and copp's."""
    motion = replace(path.motion(points), course=None)  # as a table has it: copp too has the points alone

    def whole() -> float:
        return float(mrts.retime(path.cell, motion, rates=True, between=None).duration or np.nan)

    found = mrts.retime(path.cell, motion, rates=True, between=None)
    candidates = {"mrts.retime: the whole call": whole, "mrts, all programs from given rows": steps(found, 1.0)}
    candidates["copp-py, two linearisations, rows given"] = rows_given(path, points)
    candidates["copp-py, the same, torques by a callback (Pinocchio)"] = lambda: copp_timing.by_copp(path, points)[2]
    print(f"smooth timing, one {robot}, velocity, torque and jerk limits, {points} points, CPU time")
    report(candidates, points, repeats)


def two_arms(points: int, repeats: int) -> None:
    """The shipped dual cell with wrench limits and torque rates."""
    cell, motion = shipped("dual_ur5", points, velocities=True)

    def whole() -> float:
        return float(mrts.retime(cell, motion, rates=RATE, between=None).duration or np.nan)

    found, lasts = mrts.retime(cell, motion, rates=RATE, between=None), float(motion.object.time[-1])
    candidates = {"mrts.retime: the whole call": whole, "mrts, all programs from given rows": steps(found, lasts)}
    print(f"smooth timing, dual UR5-class cell, wrench limits and torque rates, {points} points")
    report(candidates, points, repeats)


def main(
    paths: int = PATHS, points: tuple[int, ...] = POINTS, dual_points: int = DUAL_POINTS, repeats: int = REPEATS
) -> None:
    """Print the tables."""
    with tempfile.TemporaryDirectory() as name:
        of_robot = {robot: [jerk_path(robot, seed, Path(name)) for seed in range(paths)] for robot in ROBOTS}
    print(f"one arm with limited jerk: {paths} random paths of each of {', '.join(ROBOTS)}")
    for number in points:
        longer_and_excess([path for each in of_robot.values() for path in each], number)
    for robot, chosen in ROBOTS.items():
        one_arm(robot, of_robot[robot][min(chosen, paths - 1)], points[-1], repeats)
    two_arms(dual_points, repeats)


if __name__ == "__main__":
    on_one_processor()
    main()
