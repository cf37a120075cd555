# SPDX-License-Identifier: MIT
"""Smooth timing: one arm with limited jerk against copp's third-order solver, two arms with torque rates.

One arm: published robots, random paths (tests/cases/jerk_paths.py), the same joint path, velocity, torque and jerk
limits and number of points. copp gets its two linearisations as its authors advise (the second-order optimum, then
about its first answer); robot, limits and torques at the points are made once for it, outside the measured calls.
Two arms: the shipped dual UR5-class cell with its wrench limits, torque rates of 11 times the torque limit a second; no
neighbour asks this. One process on one processor, CPU time, medians of runs in turn.
"""

import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from interleaved import median_times, on_one_processor

import mrts
from mrts.smooth.program import Goal
from mrts.smooth.smooth_solvers import SMOOTH_SOLVERS, CheckedSolver
from mrts.smooth.successive_steps import StepsTaken, successive_steps

TESTS = Path(__file__).resolve().parent.parent / "tests"
sys.path[:0] = [str(TESTS / "oracles"), str(TESTS / "cases")]
import copp_timing  # noqa: E402 (the checks of the tests, on the path from here on)
from jerk_paths import jerk_path  # noqa: E402 (likewise)

CELL = Path(str(files("mrts") / "data")) / "dual_ur5"
ROBOTS = {"ur5": 10, "panda": 10}
POINTS = (200, 1000)
INSIDE = 20
DUAL_POINTS = 200
RATE = 11.0
REPEATS = 3


def longer_and_excess(folder: Path, points: int) -> None:
    """Durations of all paths against copp's, and what both overstep between their points."""
    longer, ours_over, theirs_over = [], [], []
    for robot, paths in ROBOTS.items():
        for seed in range(paths):
            path = jerk_path(robot, seed, folder)
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


def steps(found: mrts.RetimingResult, solver: str, given: float) -> Callable[[], Any]:
    """The convex programs alone, from the rows of a path that was found before.

    Args:
        found: A smooth timing of one piece.
        solver: A name in `SMOOTH_SOLVERS`.
        given: Duration of the given motion [s].
    """
    program, smooth = found.pieces[0].program, found.smooth  # type: ignore[attr-defined]  # a SmoothPiece
    around = np.full(program.nodes, (given / smooth.bound) ** 2)  # type: ignore[union-attr]

    def run() -> float:
        taken = successive_steps(program, around, Goal(), CheckedSolver(solver))
        if not isinstance(taken, StepsTaken):
            raise TypeError(taken)
        return taken.costs[-1]

    return run


def rows_given(path: Any, points: int) -> Callable[[], float]:
    """Copp's two linearisations, limits of the path given."""
    robot, s = copp_timing.constraints_of(path, points)
    fastest = robot.constraints.amax_values()

    def run() -> float:
        robot.constraints.amax_substitute(fastest, 0)
        return float(copp_timing.copp.interpolation.s_to_t_topp3(s, copp_timing.third_order(robot, points))[0])

    return run


def report(candidates: dict[str, Callable[[], float]], points: int) -> None:
    """Print the times of some candidates, the fastest first."""
    durations = {label: run() for label, run in candidates.items()}
    times = median_times(candidates, REPEATS)
    for label, seconds in sorted(times.items(), key=lambda item: item[1]):
        each = 1e6 * seconds / points
        print(f"  {label:<52}{1e3 * seconds:>9.1f} ms{each:>8.1f} µs a point   duration {durations[label]:.6f} s")


def one_arm(folder: Path, robot: str, seed: int) -> None:
    """One path, our ways and copp's."""
    path, points = jerk_path(robot, seed, folder), POINTS[-1]
    motion = replace(path.motion(points), course=None)  # as a table has it: copp too has the points alone

    def whole(solver: str) -> Callable[[], float]:
        return lambda: float(mrts.retime(path.cell, motion, rates=True, between=None, solver=solver).duration or np.nan)

    found = mrts.retime(path.cell, motion, rates=True, between=None)
    candidates = {f"mrts.retime: the whole call ({name})": whole(name) for name in SMOOTH_SOLVERS}
    candidates |= {f"mrts, all programs from given rows ({name})": steps(found, name, 1.0) for name in SMOOTH_SOLVERS}
    candidates["copp-py, two linearisations, rows given"] = rows_given(path, points)
    candidates["copp-py, the same, torques by a callback (Pinocchio)"] = lambda: copp_timing.by_copp(path, points)[2]
    print(f"smooth timing, one {robot}, velocity, torque and jerk limits, {points} points, one processor, CPU time")
    report(candidates, points)


def two_arms() -> None:
    """The shipped dual cell with wrench limits and torque rates."""
    cell = mrts.load_cell(CELL / "cell.yaml")
    text = (CELL / "lift_and_turn.yaml").read_text(encoding="utf-8")
    given = mrts.MotionDescription.model_validate(yaml.safe_load(text) | {"samples": DUAL_POINTS})
    motion = mrts.follow_object(cell, mrts.sample_motion(given))

    def whole(solver: str) -> Callable[[], float]:
        return lambda: float(mrts.retime(cell, motion, rates=RATE, between=None, solver=solver).duration or np.nan)

    found, lasts = mrts.retime(cell, motion, rates=RATE, between=None), float(motion.object.time[-1])
    candidates = {f"mrts.retime: the whole call ({name})": whole(name) for name in SMOOTH_SOLVERS}
    candidates |= {f"mrts, all programs from given rows ({name})": steps(found, name, lasts) for name in SMOOTH_SOLVERS}
    print(f"smooth timing, dual UR5-class cell, wrench limits and torque rates, {DUAL_POINTS} points")
    report(candidates, DUAL_POINTS)


def main() -> None:
    """Print the tables."""
    on_one_processor()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print(
            "one arm with limited jerk: random paths of " + ", ".join(f"{n} x {robot}" for robot, n in ROBOTS.items())
        )
        for points in POINTS:
            longer_and_excess(folder, points)
        one_arm(folder, "ur5", 0)
        one_arm(folder, "panda", 1)
    two_arms()


if __name__ == "__main__":
    main()
