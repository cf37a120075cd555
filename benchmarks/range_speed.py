# SPDX-License-Identifier: MIT
"""What the range of c² costs, against what a user would otherwise write: Pinocchio and a program at every sample.

The same cell, joint angles and limits (torques and contact wrenches, no velocities) for all; terms and both ends of the
range included; one process on one processor, CPU time, medians of runs in turn.
"""

from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import numpy as np
import yaml
from interleaved import median_times, on_one_processor
from pinocchio_cell import HighsRange, PinocchioCell, linprog_range

import mrts
from mrts.samples.trajectory_programs import motion_ranges
from mrts.scaling.range import intersect

DATA = Path(str(files("mrts") / "data"))
SAMPLES = 1000
REPEATS = 5
FIRST = 100  # samples that SciPy is measured on: it is too slow for all


def compare(name: str, motion_file: str, urdf: str, tip: str) -> None:
    """Measure one shipped cell and print its table."""
    cell = mrts.load_cell(DATA / name / "cell.yaml").without_velocity_limits()
    description = yaml.safe_load((DATA / name / motion_file).read_text(encoding="utf-8")) | {"samples": SAMPLES}
    motion = mrts.follow_object(cell, mrts.sample_motion(mrts.MotionDescription.model_validate(description)))
    few = mrts.CoordinatedMotion(
        mrts.ObjectMotion(
            motion.object.time[:FIRST],
            *(getattr(motion.object, part)[:FIRST] for part in ("position", "rotation", "twist", "acceleration")),
        ),
        *(part[:FIRST] for part in (motion.q, motion.dq, motion.ddq)),
    )
    rows = PinocchioCell(cell, DATA / name / urdf, tip)
    highs = HighsRange(rows)

    def ours(solver: str, motion: mrts.CoordinatedMotion = motion) -> float:
        found = intersect(motion_ranges(cell, motion, "wrench", None, solver))
        return found.upper.c2 if found.upper else float("nan")

    candidates: dict[str, tuple[Callable[[], float], int]] = {
        "mrts, kernel": (lambda: ours("kernel"), SAMPLES),
        "mrts, qpsol:qpoases in a CasADi map": (lambda: ours("qpsol:qpoases"), SAMPLES),
        "Pinocchio + HiGHS, one model, warm": (lambda: highs(motion), SAMPLES),
        f"Pinocchio + scipy linprog, first {FIRST}": (lambda: linprog_range(rows, few), FIRST),
    }
    reached = {label: run() for label, (run, _) in candidates.items()}
    expected = [reached["mrts, kernel"]] * 3 + [ours("kernel", few)]
    if not np.allclose(list(reached.values()), expected, rtol=1e-6):
        raise RuntimeError(reached)
    times = median_times({label: run for label, (run, _) in candidates.items()}, REPEATS)
    print(f"range of c², cell {name}, {motion.samples} samples, one processor, CPU time, median of {REPEATS}")
    base = times["mrts, kernel"] / SAMPLES
    for label, (_, samples) in candidates.items():
        sample = times[label] / samples
        print(f"  {label:<40}{1e6 * sample:>10.2f} µs/sample{sample / base:>9.1f}x   c²⁺ {reached[label]:.6f}")


def main() -> None:
    """Compare on both shipped cells."""
    on_one_processor()
    compare("planar_dual_arm", "lift.yaml", "planar_arm.urdf", "contact")
    compare("dual_ur5", "lift_and_turn.yaml", "ur5_class_arm.urdf", "tool0")


if __name__ == "__main__":
    main()
