# SPDX-License-Identifier: MIT
"""What the range of c² costs a sample, against what a user would otherwise write: Pinocchio and programs of one's own.

The same cell, joint angles and limits (torques, and contact wrenches of two arms; no velocities) for all; terms and
both ends of the range at every sample are in the call, and ours names the rows that set them. Models and HiGHS's one
model are made outside. One process on one processor, CPU time, medians of runs in turn.
"""

import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from pinocchio_cell import HighsRange, PinocchioArm, PinocchioCell, linprog_range

import mrts
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_ranges import motion_ranges
from mrts.scaling.range import intersect

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import DATA, along, model_with_box, one_arm, one_arm_path, shipped
from interleaved import median_times, on_one_processor, show

SAMPLES, REPEATS = 1000, 5
FIRST = 100
"""Samples that SciPy is measured on: it is too slow for all."""

ARMS = {"planar_dual_arm": ("planar_arm.urdf", "contact"), "dual_ur5": ("ur5_class_arm.urdf", "tool0")}
"""URDF and tip link of the arms of shipped cells."""

AGREEMENT = 1e-6
"""Of the largest c² of all candidates, relative: what HiGHS's default tolerances leave."""


def ours(cell: mrts.Cell, motion: mrts.CoordinatedMotion, solver: str = "kernel") -> Callable[[], float]:
    """Largest c² of a motion by mrts."""

    def run() -> float:
        found = intersect(motion_ranges(motion_rows(cell, motion, solver=solver)))
        return found.upper.c2 if found.upper else float("nan")

    return run


def compare(title: str, candidates: Mapping[str, tuple[Callable[[], float], int]], repeats: int) -> None:
    """Measure candidates, each with its number of samples, and print their table."""
    reached = {label: run() for label, (run, _) in candidates.items()}
    times = median_times({label: run for label, (run, _) in candidates.items()}, repeats)
    print(f"range of c², {title}, one processor, CPU time, median of {repeats}")
    counts = {label: samples for label, (_, samples) in candidates.items()}
    show(times, counts, "sample", {label: f"c²⁺ {end:.6f}" for label, end in reached.items()})
    whole = [end for label, end in reached.items() if counts[label] == max(counts.values())]
    if not np.allclose(whole, whole[0], rtol=AGREEMENT):
        raise RuntimeError(reached)


def several_arms(name: str, samples: int, repeats: int) -> None:
    """A shipped cell of two arms."""
    cell, motion = shipped(name, samples)
    first = min(FIRST, samples)
    rows = PinocchioCell(cell, DATA / name / ARMS[name][0], ARMS[name][1])
    highs = HighsRange(rows)
    few = motion.at(np.arange(first))
    compare(f"cell {name}, {samples} samples", {
        "mrts, kernel": (ours(cell, motion), samples),
        "mrts, qpsol:qpoases in a CasADi map": (ours(cell, motion, "qpsol:qpoases"), samples),
        "Pinocchio + HiGHS, one model, warm": (lambda: highs(motion), samples),
        f"Pinocchio + scipy linprog, first {first}": (lambda: linprog_range(rows, few), first),
    }, repeats)  # fmt: skip


def single_arm(samples: int, repeats: int) -> None:
    """One arm with the box."""
    with tempfile.TemporaryDirectory() as folder:
        cell = one_arm(Path(folder))
    motion = along(cell, one_arm_path(cell), samples)
    robot = cell.robots[0]
    arm = PinocchioArm(model_with_box(cell), np.column_stack([robot.torque_lower, robot.torque_upper]))
    compare(f"one UR5-class arm with its box, {samples} samples", {
        "mrts, kernel": (ours(cell, motion), samples),
        "Pinocchio, a row's limits in numpy": (lambda: arm(motion), samples),
    }, repeats)  # fmt: skip


def main(samples: int = SAMPLES, repeats: int = REPEATS) -> None:
    """Compare on one arm and on both shipped cells."""
    single_arm(samples, repeats)
    for name in ARMS:
        several_arms(name, samples, repeats)


if __name__ == "__main__":
    on_one_processor()
    main()
