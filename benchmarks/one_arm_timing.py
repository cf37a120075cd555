# SPDX-License-Identifier: MIT
"""The fastest timing of one arm, against copp and toppra, which ask the same of one arm; see docs/performance.md.

One UR5-class arm carries the shipped box along the shipped lift. All have the same joint path at the same grid points,
torque limits and nothing else, limits at both ends of every segment (interpolation scheme), rest at both ends. What
lasts longer than one path (models, constraints, options, buffers' sizes) is made once for every candidate, outside the
measured calls. One process on one processor, CPU time, medians of runs in turn; durations are printed to be compared.

copp is `copp-py` of PyPI. toppra's C++ core is measured where it is installed with headers: TOPPRA_PREFIX names the
folder of its include/ and lib/.
"""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import copp_py as copp
import numpy as np
import pinocchio as pin
import toppra
import yaml
from interleaved import median_times, on_one_processor
from toppra.constraint import DiscretizationType, LinearConstraint
from toppra.constraint.linear_constraint import canlinear_colloc_to_interpolate

import mrts
from mrts.base.arrays import Array
from mrts.coordination.coordinated_motion import carried_by_first
from mrts.reachability.fastest_profile import SpeedProfile, fastest_profile
from mrts.reachability.speed_regions import speed_regions
from mrts.retiming.path_pieces import PathPiece, path_pieces
from mrts.samples.sample_problem import build_sample_problem

CELL = Path(str(files("mrts") / "data")) / "dual_ur5"
POINTS = 1000
WAYPOINTS = 60
REPEATS = 15


def one_arm(folder: Path) -> mrts.Cell:
    """The left arm of the shipped cell with the box, torque limits only."""
    description = yaml.safe_load((CELL / "cell.yaml").read_text(encoding="utf-8"))
    left = description["robots"][0] | {"urdf": str(CELL / description["robots"][0]["urdf"])}
    path = folder / "cell.yaml"
    path.write_text(yaml.safe_dump(description | {"name": "one_ur5", "robots": [left]}), encoding="utf-8")
    return mrts.load_cell(path).without_wrench_limits().without_velocity_limits()


def model_with_box(cell: mrts.Cell) -> Any:
    """Pinocchio's model of the arm with the box welded to its hand, in base axes."""
    robot = cell.robots[0]
    model = pin.buildModelFromUrdf(str(CELL / "ur5_class_arm.urdf"))
    model.gravity.linear = robot.T_world_base.R.T @ cell.gravity
    frame = model.frames[model.getFrameId("tool0")]
    tip_object = pin.SE3(robot.T_object_tip.R, robot.T_object_tip.p).inverse()
    box = pin.Inertia(cell.mass, np.zeros(3), cell.inertia)
    model.appendBodyToJoint(frame.parentJoint, box, frame.placement * tip_object)
    return model


def path_of(cell: mrts.Cell) -> Any:
    """Toppra's cubic spline through joint positions of the shipped lift, over their arc length."""
    text = (CELL / "lift_and_turn.yaml").read_text(encoding="utf-8")
    description = yaml.safe_load(text) | {"samples": WAYPOINTS}
    q = mrts.follow_object(cell, mrts.sample_motion(mrts.MotionDescription.model_validate(description))).q
    least = np.max(np.ptp(q, axis=0)) / WAYPOINTS / 4  # a spline wants waypoints that differ
    kept = q[np.concatenate([[True], np.linalg.norm(np.diff(q, axis=0), axis=1) > least])]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(kept, axis=0), axis=1))])
    return toppra.SplineInterpolator(way, kept)


class GivenRows(LinearConstraint):  # type: ignore[misc]  # toppra ships no types
    """lower <= a u + b x + c <= upper with everything given."""

    def __init__(self, a: Array, b: Array, c: Array, limits: Array) -> None:
        super().__init__()
        self.rows, self.identical = (a, b, c), True
        self.set_discretization_type(DiscretizationType.Interpolation)
        eye = np.eye(a.shape[1])
        self.F, self.g = np.vstack([eye, -eye]), np.concatenate([limits[:, 1], -limits[:, 0]])

    def compute_constraint_params(self, _path: Any, gridpoints: Array) -> Any:
        """The rows at both ends of each segment."""
        return canlinear_colloc_to_interpolate(*self.rows, self.F, self.g, None, None, gridpoints, identical=True)


def duration(grid: Array, x: Array) -> float:
    """Of a profile of speeds squared [s]."""
    speed = np.sqrt(np.maximum(x, 0.0))
    return float(np.sum(2 * np.diff(grid) / (speed[1:] + speed[:-1])))


def by_toppra(constraint: Any, path: Any, grid: Array) -> Callable[[], float]:
    """Toppra's Python package with its compiled Seidel solver."""

    def run() -> float:
        planner = toppra.algorithm.TOPPRA([constraint], path, gridpoints=grid, solver_wrapper="seidel")
        _, speeds, *_ = planner.compute_parameterization(0, 0)
        return duration(grid, speeds**2)

    return run


def by_copp(grid: Array, a: Array, b: Array, c: Array, limits: Array) -> Callable[[], float]:
    """Copp's second-order reachability analysis, rows given."""
    options = copp.solver.topp2_ra.Options()
    upper, lower = limits[:, 1] - c, c - limits[:, 0]

    def run() -> float:
        constraints = copp.constraints.Constraints(a.shape[1], capacity=len(grid))
        constraints.append_s(grid)
        constraints.add_constraint_2nd(b, a, upper, 0)
        constraints.add_constraint_2nd(-b, -a, lower, 0)
        problem = copp.solver.topp2_ra.Problem(constraints, idx_s_interval=(0, len(grid) - 1), a_boundary=(0.0, 0.0))
        return duration(grid, copp.solver.topp2_ra.solve(problem, options))

    return run


def by_copp_robot(grid: Array, path: Any, limits: Array, torque: Callable[..., Array]) -> Callable[[], float]:
    """Copp as its documentation shows it: a robot with an inverse dynamics of its own."""
    options = copp.solver.topp2_ra.Options()

    def run() -> float:
        robot = copp.Robot(len(limits), capacity=len(grid), inverse_dynamics=torque)
        robot.append_s(grid)
        robot.set_q(path(grid), path(grid, 1), path(grid, 2), 0)
        robot.add_torque_limits(limits[:, 1], limits[:, 0], start_idx_s=0, length=len(grid))
        problem = copp.solver.topp2_ra.Problem(
            robot.constraints, idx_s_interval=(0, len(grid) - 1), a_boundary=(0.0, 0.0)
        )
        return duration(grid, copp.solver.topp2_ra.solve(problem, options))

    return run


def by_toppra_core(folder: Path, grid: Array, rows: tuple[Array, Array, Array], limits: Array) -> tuple[float, float]:
    """Median CPU time of a call [s] and duration [s] of toppra's C++ core; NaN where it is not installed."""
    prefix = os.environ.get("TOPPRA_PREFIX")
    if prefix is None:
        return float("nan"), float("nan")
    source, program = Path(__file__).resolve().parent / "c" / "toppra_core.cpp", folder / "toppra_core"
    include, library = Path(prefix) / "include", Path(prefix) / "lib"
    compiler = shutil.which("c++") or "c++"
    search = [f"-I{include}", "-I/usr/include/eigen3", f"-L{library}", f"-Wl,-rpath,{library}"]
    command = [compiler, "-std=c++11", "-O2", str(source), "-o", str(program), *search, "-ltoppra"]
    subprocess.run(command, check=True)  # noqa: S603 (fixed words, the folder is the user's own)
    numbers = [[len(grid), len(limits), REPEATS], grid, limits[:, 0], limits[:, 1], *(part.ravel() for part in rows)]
    given = np.concatenate(numbers).astype(np.float64).tobytes()
    done = subprocess.run([str(program)], input=given, capture_output=True, check=True)  # noqa: S603
    seconds, found = map(float, done.stdout.split())
    return seconds, found


def main() -> None:
    """Print the table."""
    on_one_processor()
    toppra.setup_logging("ERROR")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cell = one_arm(folder)
        robot = cell.robots[0]
        limits = np.column_stack([robot.torque_lower, robot.torque_upper])
        model = model_with_box(cell)
        data = model.createData()
        path = path_of(cell)
        grid = np.linspace(*path.path_interval, POINTS)

        def torque(q: Array, dq: Array, ddq: Array) -> Array:
            return np.asarray(pin.rnea(model, data, q, dq, ddq))

        theirs = toppra.constraint.JointTorqueConstraint(
            torque, limits, np.zeros(len(limits)), discretization_scheme=DiscretizationType.Interpolation
        )
        a, b, c, *_ = theirs.compute_constraint_params(path, grid)
        a, b, c = (np.ascontiguousarray(part[:, : len(limits)]) for part in (a, b, c))
        motion = carried_by_first(cell, grid, path(grid), path(grid, 1), path(grid, 2), smooth=False)
        pieces = path_pieces(motion)
        if not isinstance(pieces, list):
            raise TypeError(pieces)

        def profile(piece: PathPiece = pieces[0]) -> float:
            regions = speed_regions(build_sample_problem(cell, piece.path, varying=True), float(np.sum(piece.step)))
            found = fastest_profile(piece.step, regions, (0.0, 0.0))
            if not isinstance(found, SpeedProfile):
                raise TypeError(found)
            return float(np.sum(2 * piece.step / (np.sqrt(found.x[1:]) + np.sqrt(found.x[:-1]))))

        candidates: dict[str, Callable[[], float]] = {
            "mrts.retime: the whole call": lambda: float(mrts.retime(cell, motion).duration or np.nan),
            "mrts, rows from the path and profile only": profile,
            "copp-py, rows given": by_copp(grid, a, b, c, limits),
            "copp-py, torques by a callback (Pinocchio)": by_copp_robot(grid, path, limits, torque),
            "toppra, rows given": by_toppra(GivenRows(a, b, c, limits), path, grid),
            "toppra, torques by a callback (Pinocchio)": by_toppra(theirs, path, grid),
        }
        durations = {label: run() for label, run in candidates.items()}
        times = median_times(candidates, REPEATS)
        label = "toppra's C++ core, rows given"
        times[label], durations[label] = by_toppra_core(folder, grid, (a, b, c), limits)
    print(f"fastest timing, one UR5-class arm with its box, torque limits, {POINTS} points, one processor, CPU time")
    for label, seconds in sorted(times.items(), key=lambda item: item[1]):
        if np.isnan(seconds):
            print(f"  {label:<44} not installed (TOPPRA_PREFIX)")
        else:
            print(f"  {label:<44}{1e6 * seconds / POINTS:>9.2f} µs a point   duration {durations[label]:.6f} s")


if __name__ == "__main__":
    main()
