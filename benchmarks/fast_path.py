# SPDX-License-Identifier: MIT
"""The kernel against DAQP, growth with samples and arms, the whole command; see docs/performance.md."""

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import daqp
import numpy as np
import pinocchio as pin
import yaml
from interleaved import median_times

import mrts
from mrts.base.arrays import Array
from mrts.kernel.compiler import find_compiler
from mrts.kernel.programs import compiled_programs
from mrts.samples.linear_programs import UNBOUNDED
from mrts.samples.sample_problem import build_sample_problem
from mrts.samples.trajectory_programs import motion_ranges
from mrts.scaling.range import intersect
from mrts.solvers.convex_program import ConvexPrograms

CELL = Path(str(files("mrts") / "data")) / "dual_ur5"
SAMPLES = 1000
REPEATS = 7
MOST_SAMPLES = 1_000_000


def median_time(run: Callable[[], Any], repeats: int = REPEATS) -> float:
    """Median wall time [s], where threads and processes are part of what is measured."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def motion_file(folder: Path, samples: int) -> Path:
    """The shipped lift with another number of samples."""
    text = (CELL / "lift_and_turn.yaml").read_text(encoding="utf-8").replace("samples: 101", f"samples: {samples}")
    path = folder / "motion.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def against_daqp(cell: mrts.Cell, motion: mrts.CoordinatedMotion) -> None:
    """The kernel alone on the same programs, C time only, along the path (warm) and in random order."""
    problem = build_sample_problem(cell, motion)
    count, _, k = problem.A.shape
    g = np.zeros((count, k))
    low, high = np.full((count, k), -np.inf), np.full((count, k), np.inf)
    low[:, -1], high[:, -1] = 0, UNBOUNDED
    kernel = compiled_programs(find_compiler() or ())
    print("kernel alone, the same linear programs, C time")
    for name, direction in (("least c²", 1.0), ("largest c²", -1.0)):
        g[:, -1] = direction
        effect = np.max(np.abs(problem.A[:, :, -1]), axis=1)
        A = problem.A.copy()
        A[:, :, -1] /= np.where(effect > 0, effect, 1)[:, None]
        scaled, _, _ = ConvexPrograms(None, g, A, problem.lower, problem.upper, low, high).scaled()
        lower, upper = np.hstack([scaled.lower, scaled.x_lower]), np.hstack([scaled.upper, scaled.x_upper])
        for order_name, order in (
            ("along the path", np.arange(count)),
            ("in random order", np.random.default_rng(0).permutation(count)),
        ):
            given = [np.ascontiguousarray(part[order]) for part in (scaled.g, scaled.A, lower, upper)]
            times = median_times({"ours": lambda given=given: kernel.linear_programs(*given)}, REPEATS)  # type: ignore[misc]
            cold, warm = daqp_times(*given)
            print(
                f"  {name:<11} {order_name:<16} kernel {1e6 * times['ours'] / count:5.2f} µs; DAQP a new solve each "
                f"{_told(cold, count)}, one model updated {_told(warm, count)}"
            )


def _told(times: list[float], count: int) -> str:
    return f"{1e6 * statistics.median(times):5.2f} µs ({len(times)} of {count} solved)"


def daqp_times(g: Array, A: Array, lower: Array, upper: Array) -> tuple[list[float], list[float]]:
    """DAQP's own solve times of the programs that it solves: each by itself, and by one model that is updated [s].

    Its set-up, and Python around it, are left out on purpose. Linear programs take its `eps_prox`.
    """
    count, rows, k = A.shape
    H, sense = np.zeros((k, k)), np.zeros(rows + k, dtype=np.int32)
    # simple bounds come first there
    high, low = (np.clip(np.hstack([part[:, rows:], part[:, :rows]]), -1e30, 1e30) for part in (upper, lower))
    cold, warm = [], []
    model = daqp.Model()
    for n in range(count):
        _, _, flag, info = daqp.solve(H, g[n], A[n], high[n], low[n], sense, eps_prox=-1)
        if flag == 1:
            cold.append(info["solve_time"])
        if n == 0:
            model.setup(H, g[n], A[n], high[n], low[n], sense)
            model.settings = {"eps_prox": -1}
        else:
            model.update(f=g[n], A=A[n], bupper=high[n], blower=low[n])
        _, _, flag, info = model.solve()
        if flag == 1:
            warm.append(info["solve_time"])
    return cold, warm


def growth(folder: Path) -> None:
    """With the number of samples, and of arms."""
    cell = mrts.load_cell(CELL / "cell.yaml")
    print("growth with the number of samples")
    few = mrts.follow_object(cell, _motion(folder, 101))
    for samples in (100, 1000, 10_000, 100_000, MOST_SAMPLES):
        motion = _stretched(few, samples)
        seconds = median_time(lambda: motion_ranges(cell, motion, "wrench", None, "kernel"), 3)  # noqa: B023
        print(f"  {samples:>8} samples{1e3 * seconds:>10.1f} ms{1e6 * seconds / samples:>8.2f} µs/sample")
    print("growth with the number of arms, 1000 samples")
    for arms in range(1, 7):
        cell = mrts.load_cell(_ring(folder, arms))
        if arms == 1:  # one gripper cannot hold the box within the limits of two
            cell = cell.without_wrench_limits()
        motion = _stretched(mrts.follow_object(cell, _lift(few)), SAMPLES)
        seconds = median_time(lambda: motion_ranges(cell, motion, "wrench", None, "kernel"))  # noqa: B023
        found = intersect(motion_ranges(cell, motion, "wrench", None, "kernel"))
        end = found.upper.c2 if found.upper else float("nan")
        print(
            f"  {arms} arms, {6 * (arms - 1) + 1:>2} unknowns{1e6 * seconds / SAMPLES:>8.2f} µs/sample"
            f"   ({found.status.value}, c²⁺ = {end:.4g}, {found.samples.fallbacks} left to other solvers)"
        )


def _motion(folder: Path, samples: int) -> mrts.ObjectMotion:
    motion = mrts.load_motion(motion_file(folder, samples))
    if not isinstance(motion, mrts.ObjectMotion):
        raise TypeError
    return motion


def _lift(motion: mrts.CoordinatedMotion) -> mrts.ObjectMotion:
    """Straight up by 50 mm from the start of the shipped motion."""
    description = {"duration": 0.5, "samples": 101, "profile": "quintic"}
    start = motion.object.position[0].tolist()
    ends = {"start": {"xyz": start}, "end": {"xyz": [start[0], start[1], start[2] + 0.05]}}
    return mrts.sample_motion(mrts.MotionDescription.model_validate(description | ends))


def _stretched(motion: mrts.CoordinatedMotion, samples: int) -> mrts.CoordinatedMotion:
    """The same motion at more samples, each field interpolated: for timing, where an error of closure is no harm."""
    time_now = np.linspace(0, motion.object.time[-1], samples)

    def fields(values: Array) -> Array:
        flat = values.reshape(len(values), -1)
        columns = [np.interp(time_now, motion.object.time, column) for column in flat.T]
        return np.column_stack(columns).reshape(samples, *values.shape[1:])

    given = motion.object
    moved = object.__new__(mrts.ObjectMotion)
    for name in ("position", "rotation", "twist", "acceleration"):
        object.__setattr__(moved, name, fields(getattr(given, name)))
    object.__setattr__(moved, "time", time_now)
    return replace(motion, object=moved, q=fields(motion.q), dq=fields(motion.dq), ddq=fields(motion.ddq))


def _ring(folder: Path, arms: int) -> Path:
    """The shipped left arm, `arms` times around the object."""
    cell = yaml.safe_load((CELL / "cell.yaml").read_text(encoding="utf-8"))
    left = cell["robots"][0] | {"urdf": str(CELL / cell["robots"][0]["urdf"])}
    centre = np.array([0.0, 0.1, 0.0])
    robots = []
    for index in range(arms):
        turn = pin.rpy.rpyToMatrix(0.0, 0.0, 2 * np.pi * index / arms)
        base = turn @ (np.array(left["base"]["xyz"]) - centre) + centre
        grasp = turn @ pin.rpy.rpyToMatrix(*map(float, left["grasp"]["rpy"]))
        rpy = pin.rpy.matrixToRpy(grasp).tolist()
        robots.append(left | {
            "name": f"arm{index}",
            "base": {"xyz": base.tolist(), "rpy": [0, 0, 2 * np.pi * index / arms]},
            "grasp": {"xyz": (turn @ np.array(left["grasp"]["xyz"])).tolist(), "rpy": rpy},
        })  # fmt: skip
    path = folder / f"ring{arms}.yaml"
    path.write_text(yaml.safe_dump(cell | {"name": f"ring{arms}", "robots": robots}), encoding="utf-8")
    return path


END_TO_END = """
import re, sys
from mrts.cli import main
main(["scale", sys.argv[1], sys.argv[2]])
print(re.search(r"VmHWM:\\s*(\\d+)", open("/proc/self/status").read()).group(1), file=sys.stderr)
"""


def end_to_end(folder: Path) -> None:
    """`mrts scale` with a warm cache, process start to exit, and its memory."""
    print("mrts scale, dual UR5-class cell, warm cache, process start to exit")
    peak = {}
    for samples in (SAMPLES, 20 * SAMPLES):
        command = [sys.executable, "-c", END_TO_END, str(CELL / "cell.yaml"), str(motion_file(folder, samples))]

        def run(command: list[str] = command) -> int:
            done = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
            return int(done.stderr.split()[-1])

        peak[samples] = run()
        print(f"  {samples:>6} samples{median_time(run):>8.3f} s, peak {peak[samples] / 1024:.0f} MB")
    per_sample = 1024 * (peak[20 * SAMPLES] - peak[SAMPLES]) / (19 * SAMPLES)
    print(f"  growth of the peak: {per_sample:.0f} bytes a sample")
    cell, motion = mrts.load_cell(CELL / "cell.yaml"), _motion(folder, SAMPLES)
    seconds = median_time(lambda: mrts.follow_object(cell, motion))
    print(f"  inverse kinematics of {SAMPLES} samples: {1e3 * seconds:.1f} ms")


def main() -> None:
    """Measure everything."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cell = mrts.load_cell(CELL / "cell.yaml")
        motion = mrts.follow_object(cell, _motion(folder, SAMPLES))
        against_daqp(cell, motion)
        end_to_end(folder)
        growth(folder)


if __name__ == "__main__":
    main()
