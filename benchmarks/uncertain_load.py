# SPDX-License-Identifier: MIT
"""What the guaranteed range of an uncertain load costs, against the nominal range and against sampling the box."""

import statistics
import time
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import numpy as np

import mrts
from mrts.samples.trajectory_programs import motion_ranges
from mrts.scaling.range import intersect
from mrts.scaling.uncertain_load import study_load
from mrts.solvers import DEFAULT_SOLVER

DATA = Path(str(files("mrts") / "data"))
REPEATS = 5
DRAWN = 1000
RANGES = {"mass": (0.3, 2.0), "ixx": (0.5, 2.0), "iyy": (0.5, 2.0), "izz": (0.5, 2.0), "mx": (-0.1, 0.1)}


def median_time(run: Callable[[], tuple[float, int]], repeats: int = REPEATS) -> tuple[float, int, float]:
    """Largest c², loads looked at, and median wall time [s]."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        c2, loads = run()
        times.append(time.perf_counter() - start)
    return c2, loads, statistics.median(times)


def compare(name: str, motion_file: str) -> None:
    """Measure one shipped cell and print its table."""
    known = mrts.load_cell(DATA / name / "cell.yaml")
    given = mrts.load_motion(DATA / name / motion_file)
    if not isinstance(given, mrts.ObjectMotion):
        raise TypeError(motion_file)
    motion = mrts.follow_object(known, given)

    def nominal() -> tuple[float, int]:
        found = intersect(motion_ranges(known, motion, "wrench", None, DEFAULT_SOLVER))
        return found.upper.c2 if found.upper else float("nan"), 1

    def asked(question: str, names: tuple[str, ...], sharing: mrts.LoadSharing | None = None) -> tuple[float, int]:
        cell = known.with_variation(**{name: RANGES[name] for name in names})
        found, study = study_load(cell, motion, question, "wrench", sharing, DEFAULT_SOLVER)
        return found.upper.c2 if found.upper else float("nan"), len(study.points)

    def sampled() -> tuple[float, int]:
        box = known.with_variation(**RANGES).load_box
        lowest = np.inf
        for point in box.draw(np.random.default_rng(0), DRAWN) if box else ():
            found = intersect(motion_ranges(known, motion, "wrench", None, DEFAULT_SOLVER, point.load))
            lowest = min(lowest, found.upper.c2 if found.upper else np.nan)
        return lowest, DRAWN

    print(f"uncertain load, cell {name}, {motion.samples} samples, median of {REPEATS}")
    print(f"{'':<44}{'c²⁺':>10}{'loads':>7}{'ms':>10}{'x nominal':>11}")
    base = 0.0
    names = tuple(RANGES)
    rows: list[tuple[str, Callable[[], tuple[float, int]], int]] = [("nominal", nominal, REPEATS)]
    for count in range(1, len(names) + 1):
        label = "guaranteed, " + ", ".join(names[:count])
        rows.append((label, lambda count=count: asked("guaranteed", names[:count]), REPEATS))  # type: ignore[misc]
    rows += [
        ("guaranteed, all, even distribution", lambda: asked("guaranteed", names, mrts.LoadSharing()), REPEATS),
        ("grid:51 along the mass", lambda: asked("grid:51", names), REPEATS),
        ("possible, all", lambda: asked("possible", names), 1),
        (f"{DRAWN} random loads (no guarantee)", sampled, 1),
    ]
    for label, run, repeats in rows:
        c2, loads, seconds = median_time(run, repeats)
        base = base or seconds
        print(f"{label:<44}{c2:>10.4f}{loads:>7}{1e3 * seconds:>10.1f}{seconds / base:>11.1f}")


def main() -> None:
    """Compare on both shipped cells; on the planar one only the mass matters, so only its ends are looked at."""
    compare("planar_dual_arm", "lift.yaml")
    compare("dual_ur5", "lift_and_turn.yaml")


if __name__ == "__main__":
    main()
