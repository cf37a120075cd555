# SPDX-License-Identifier: MIT
"""What the range of c² costs, against what a user would otherwise write: Pinocchio and a program at every sample.

The same cell, motion and joint angles for all; terms and both ends of the range included; one process, medians.
"""

import statistics
import sys
import time
from collections.abc import Callable, Iterator
from importlib.resources import files
from pathlib import Path

import numpy as np
from scipy.optimize import linprog

import mrts
from mrts.scaling_range import intersect
from mrts.solvers import DEFAULT_SOLVER
from mrts.trajectory_programs import motion_ranges

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from reference import ReferenceCell, highs_range  # the independent implementation of the tests

DATA = Path(str(files("mrts") / "data"))
REPEATS = 7


def linprog_range(A: np.ndarray, lower: np.ndarray, upper: np.ndarray, low: np.ndarray, high: np.ndarray) -> float:
    """Largest c² by two calls of `scipy.optimize.linprog` (the least is found and dropped)."""
    equal = lower == upper
    rows = np.concatenate([A[~equal], -A[~equal]])
    rhs = np.concatenate([upper[~equal], -lower[~equal]])
    bounds = np.column_stack([low, high])
    ends = [
        linprog(np.eye(A.shape[1])[-1] * sign, rows, rhs, A[equal], lower[equal], bounds, "highs").x for sign in (1, -1)
    ]
    return float("inf") if ends[1] is None else float(ends[1][-1])


def median_time(run: Callable[[], float]) -> tuple[float, float]:
    """Result and median wall time [s]."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        value = run()
        times.append(time.perf_counter() - start)
    return value, statistics.median(times)


def compare(name: str, motion_file: str) -> None:
    """Measure one shipped cell and print its table."""
    folder = DATA / name
    cell = mrts.load_cell(folder / "cell.yaml")
    given = mrts.load_motion(folder / motion_file)
    if not isinstance(given, mrts.ObjectMotion):
        raise TypeError(motion_file)
    motion = mrts.follow_object(cell, given)
    reference = ReferenceCell(folder / "cell.yaml")
    _, samples = reference.object_motion(folder / motion_file)
    parts = list(cell.joint_slices.values())
    joints = [[(motion.q[k, s], motion.dq[k, s], motion.ddq[k, s]) for s in parts] for k in range(motion.samples)]

    def ours() -> float:
        found = intersect(motion_ranges(cell, motion, "wrench", None, DEFAULT_SOLVER))
        return found.upper.c2 if found.upper else float("nan")

    def programs() -> Iterator[tuple[np.ndarray, ...]]:
        return (reference.program(reference.terms(s, j), even=False) for s, j in zip(samples, joints, strict=True))

    rivals: dict[str, Callable[[], float]] = {
        "mrts": ours,
        "Pinocchio + scipy.optimize.linprog": lambda: min(linprog_range(*program) for program in programs()),
        "Pinocchio + highspy": lambda: min(highs_range(*program)[2] for program in programs()),
    }
    base = 0.0
    print(f"range of c², cell {name}, {motion.samples} samples, median of {REPEATS}")
    print(f"{'':<36}{'c²⁺':>10}{'ms':>10}{'µs/sample':>12}{'ratio':>9}")
    for rival, run in rivals.items():
        value, seconds = median_time(run)
        base = base or seconds
        per_sample = 1e6 * seconds / motion.samples
        print(f"{rival:<36}{value:>10.6f}{1e3 * seconds:>10.2f}{per_sample:>12.1f}{seconds / base:>8.1f}x")


def main() -> None:
    """Compare on both shipped cells."""
    compare("planar_dual_arm", "lift.yaml")
    compare("dual_ur5", "lift_and_turn.yaml")


if __name__ == "__main__":
    main()
