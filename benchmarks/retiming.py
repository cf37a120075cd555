# SPDX-License-Identifier: MIT
"""The fastest timing, against toppra on one of the arms and a direct transcription; see docs/performance.md."""

import statistics
import sys
import time
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import toppra
import yaml
from toppra.constraint import DiscretizationType

import mrts
from mrts.path_pieces import PathPiece, path_pieces
from mrts.path_rows import build_path_problem
from mrts.reachability import fastest_profile
from mrts.speed_regions import speed_regions

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from random_cells import chain_model, configuration
from transcription import transcription  # the check of the tests

CELL = Path(str(files("mrts") / "data")) / "dual_ur5"
POINTS = 1000
TRANSCRIBED = (101, 201)
REPEATS = 9


def median_time(run: Callable[[], Any], repeats: int = REPEATS) -> float:
    """Median wall time after a first run [s]."""
    times = []
    for _ in range(repeats + 1):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return statistics.median(times[1:])


def lift(points: int) -> mrts.ObjectMotion:
    """The shipped lift with another number of samples."""
    description = yaml.safe_load((CELL / "lift_and_turn.yaml").read_text(encoding="utf-8")) | {"samples": points}
    return mrts.sample_motion(mrts.MotionDescription.model_validate(description))


def timed(cell: mrts.Cell, piece: PathPiece) -> Any:
    """Regions and profile, as toppra's constraint parameters and parameterization."""
    regions = speed_regions(build_path_problem(cell, piece.path), float(np.sum(piece.step)))
    return fastest_profile(piece.step, regions, (0.0, 0.0))


def one_arm_by_toppra(cell: mrts.Cell, piece: PathPiece) -> Callable[[], Any]:
    """The first arm alone by toppra (seidel, interpolation scheme), its inverse dynamics by Pinocchio."""
    robot, joints = cell.robots[0], cell.joint_slices[cell.robots[0].name]
    model = chain_model(CELL / "ur5_class_arm.urdf", "tool0")
    data = model.createData()
    model.gravity.linear = robot.T_world_base.R.T @ cell.gravity
    grid = piece.path.object.time
    path = toppra.SplineInterpolator(grid[::10], piece.path.q[::10, joints])
    limits = np.column_stack([robot.torque_lower, robot.torque_upper])

    def torque(q: Any, dq: Any, ddq: Any) -> Any:
        return pin.rnea(model, data, configuration(model, q), dq, ddq)

    def run() -> Any:
        constraint = toppra.constraint.JointTorqueConstraint(
            torque, limits, np.zeros(6), discretization_scheme=DiscretizationType.Interpolation
        )
        gridpoints = np.linspace(*path.path_interval, POINTS)
        instance = toppra.algorithm.TOPPRA([constraint], path, gridpoints=gridpoints, solver_wrapper="seidel")
        found = instance.compute_parameterization(0, 0)
        if found[1] is None:
            raise RuntimeError("toppra found no profile")
        return found

    return run


def main() -> None:
    """Print the table."""
    toppra.setup_logging("ERROR")
    cell = mrts.load_cell(CELL / "cell.yaml").without_velocity_limits()
    motion = mrts.follow_object(cell, lift(POINTS))
    pieces = path_pieces(motion)
    if not isinstance(pieces, list):
        raise TypeError(pieces)
    rows = [
        (f"mrts, two arms with wrench limits, {POINTS} points: profile", lambda: timed(cell, pieces[0])),
        ("the same with torques and the constant factor (mrts.retime)", lambda: mrts.retime(cell, motion)),
        (f"toppra, one arm, torque limits only, {POINTS} points", one_arm_by_toppra(cell, pieces[0])),
    ]
    print(f"{'fastest timing, dual UR5-class cell':<64} {'ms':>9} {'µs a point':>11} {'ratio':>7}")
    base = 0.0
    for name, run in rows:
        seconds = median_time(run)
        base = base or seconds
        print(f"{name:<64} {1e3 * seconds:>9.1f} {1e6 * seconds / POINTS:>11.1f} {seconds / base:>7.2f}")
    for points in TRANSCRIBED:
        few = mrts.follow_object(cell, lift(points))
        (piece,) = path_pieces(few)  # type: ignore[misc]
        ours = median_time(lambda piece=piece: timed(cell, piece))  # type: ignore[misc]
        start = time.perf_counter()
        duration = transcription(cell, few)
        seconds = time.perf_counter() - start
        found = mrts.retime(cell, few).duration
        print(
            f"direct transcription by IPOPT, {points} points: {seconds:.2f} s, {seconds / ours:.0f} times mrts "
            f"({1e3 * ours:.1f} ms); durations {duration:.6f} and {found:.6f} s"
        )


if __name__ == "__main__":
    main()
