# SPDX-License-Identifier: MIT
"""The fastest timing of one arm, against copp and toppra, which ask the same of one arm; see docs/performance.md.

One UR5-class arm carries the shipped box along the shipped lift, and along random splines. All have the same joint path
at the same grid points, torque limits and nothing else, limits at both ends of every segment (interpolation scheme),
rest at both ends. What lasts longer than one path (models, constraints' buffers, options) is made once for every
candidate, outside the measured calls. Our whole call besides gives torques and a check between the points.

copp is `copp-py` of PyPI. toppra's C++ core is measured where it is installed with headers (`cmake -DBUILD_TESTS=OFF`
of the folder cpp of its repository): TOPPRA_PREFIX names the folder of its include/ and lib/.
"""

import ctypes
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import copp_py as copp
import numpy as np
import pinocchio as pin
import toppra
from toppra.constraint import DiscretizationType, LinearConstraint
from toppra.constraint.linear_constraint import canlinear_colloc_to_interpolate

import mrts
from mrts.base.arrays import Array
from mrts.following.coordinated_motion import carried_by_first
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.timing.path_pieces import path_pieces

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import along, duration, model_with_box, one_arm, one_arm_path
from coarse_grids import spline_path
from interleaved import median_times, on_one_processor, show
from timing_alone import timing_alone

POINTS, REPEATS, SPLINES = 1000, 15, 12
REST = (0.0, 0.0)
SPEED, ACCELERATION, LOOSE = np.full(6, 2.0), np.full(6, 10.0), np.full(6, 1e6)
"""Of the question without torques [rad/s, rad/s², N m]."""

WHOLE = "mrts.retime: the whole call"
FROM_PATH = "mrts, rows from the path and profile (fastest_timing)"

Rows = tuple[Array, Array, Array]
"""a, b, c of limits on a u + b x + c at every point, each Shape (N, m)."""


class GivenRows(LinearConstraint):  # type: ignore[misc]  # toppra ships no types
    """lower <= a u + b x + c <= upper with everything given."""

    def __init__(self, rows: Rows, limits: Array) -> None:
        super().__init__()
        self.rows, self.identical = rows, True
        self.set_discretization_type(DiscretizationType.Interpolation)
        eye = np.eye(rows[0].shape[1])
        self.F, self.g = np.vstack([eye, -eye]), np.concatenate([limits[:, 1], -limits[:, 0]])

    def compute_constraint_params(self, _path: Any, gridpoints: Array) -> Any:
        """The rows at both ends of each segment."""
        return canlinear_colloc_to_interpolate(*self.rows, self.F, self.g, None, None, gridpoints, identical=True)


def by_toppra(constraints: list[Any], path: Any, grid: Array) -> Callable[[], float]:
    """Toppra's Python package with its compiled Seidel solver."""

    def run() -> float:
        planner = toppra.algorithm.TOPPRA(constraints, path, gridpoints=grid, solver_wrapper="seidel")
        _, speeds, *_ = planner.compute_parameterization(0, 0)
        return duration(grid, speeds**2)

    return run


def copp_profile(grid: Array, constraints: Any) -> float:
    """Duration by copp's second-order reachability analysis [s]."""
    problem = copp.solver.topp2_ra.Problem(constraints, idx_s_interval=(0, len(grid) - 1), a_boundary=REST)
    return duration(grid, copp.solver.topp2_ra.solve(problem, copp.solver.topp2_ra.Options()))


def by_copp(grid: Array, rows: Callable[[], tuple[Rows, Array, Array]], joints: int) -> Callable[[], float]:
    """Copp, rows as some function gives them with their lower and upper limits, one buffer for all calls."""
    constraints = copp.constraints.Constraints(joints, capacity=len(grid))

    def run() -> float:
        (a, b, c), lower, upper = rows()
        constraints.clear()
        constraints.append_s(grid)
        constraints.add_constraint_2nd(b, a, upper - c, 0)
        constraints.add_constraint_2nd(-b, -a, c - lower, 0)
        return copp_profile(grid, constraints)

    return run


def by_copp_robot(grid: Array, path: Any, limits: Array, torque: Callable[..., Array]) -> Callable[[], float]:
    """Copp as its documentation shows it: a robot with an inverse dynamics of its own, one for all calls."""
    robot = copp.Robot(len(limits), capacity=len(grid), inverse_dynamics=torque)

    def run() -> float:
        robot.constraints.clear()
        robot.append_s(grid)
        robot.set_q(path(grid), path(grid, 1), path(grid, 2), 0)
        robot.add_torque_limits(limits[:, 1], limits[:, 0], start_idx_s=0, length=len(grid))
        return copp_profile(grid, robot.constraints)

    return run


def by_copp_generated(cell: mrts.Cell, motion: mrts.CoordinatedMotion) -> Callable[[], float]:
    """Copp with the same rows by mrts's generated C: dynamics of one arm and its load from the URDF."""
    path = path_pieces(cell, motion)[0].path

    def rows() -> tuple[Rows, Array, Array]:
        problem = build_sample_problem(motion_rows(cell, path), varying=True)
        u, x = (np.ascontiguousarray(problem.A[:, :, column]) for column in (-2, -1))
        return (u, x, np.zeros_like(u)), problem.lower, problem.upper

    return by_copp(path.object.time, rows, motion.q.shape[1])


def by_toppra_core(folder: Path, grid: Array, rows: Rows, limits: Array) -> Callable[[], float] | None:
    """Toppra's C++ core with the same rows; None where it is not installed."""
    prefix = os.environ.get("TOPPRA_PREFIX")
    if prefix is None:
        return None
    source, library = Path(__file__).resolve().parents[1] / "c" / "toppra_core.cpp", folder / "toppra_core.so"
    place = Path(prefix) / "lib"
    search = [f"-I{Path(prefix) / 'include'}", "-I/usr/include/eigen3", f"-L{place}", f"-Wl,-rpath,{place}"]
    command = [shutil.which("c++") or "c++", "-std=c++11", "-O2", "-shared", "-fPIC", str(source), "-o", str(library)]
    subprocess.run([*command, *search, "-ltoppra"], check=True)  # noqa: S603 (fixed words, the folder is the user's own)
    core = ctypes.CDLL(str(library))
    core.toppra_question.restype = ctypes.c_void_p
    given = [np.ascontiguousarray(part) for part in (grid, limits[:, 0], limits[:, 1], *rows)]
    pointers = [part.ctypes.data_as(ctypes.c_void_p) for part in given]
    question = ctypes.c_void_p(core.toppra_question(len(grid), len(limits), *pointers))
    x = np.zeros(len(grid))

    def run() -> float:
        if core.toppra_answer(question, x.ctypes.data_as(ctypes.c_void_p)):
            raise RuntimeError("toppra's C++ core found no timing")
        return duration(grid, x)

    return run


def of_motion_alone(cell: mrts.Cell, path: Any, grid: Array) -> dict[str, Callable[[], float]]:
    """Whole calls with velocity and acceleration limits of the joints and nothing else, each from the spline itself.

    Ruckig has none: between waypoints its free version plans from state to state, and follows no path.
    """
    limits = {"velocity_limit": SPEED, "acceleration_lower": -ACCELERATION, "acceleration_upper": ACCELERATION}
    robot = replace(cell.robots[0], **limits, torque_lower=-LOOSE, torque_upper=LOOSE)
    limited = replace(cell, robots=(robot,), enforces_velocity_limits=True)
    rival = copp.Robot(len(SPEED), capacity=len(grid))
    constraints = [
        toppra.constraint.JointVelocityConstraint(np.column_stack([-SPEED, SPEED])),
        toppra.constraint.JointAccelerationConstraint(
            np.column_stack([-ACCELERATION, ACCELERATION]), discretization_scheme=DiscretizationType.Interpolation
        ),
    ]

    def by_copp_motion() -> float:
        rival.constraints.clear()
        rival.append_s(grid)
        rival.set_q(path(grid), path(grid, 1), path(grid, 2), 0)
        rival.add_velocity_limits(SPEED, -SPEED, start_idx_s=0, length=len(grid))
        rival.add_acceleration_limits(ACCELERATION, -ACCELERATION, start_idx_s=0, length=len(grid))
        return copp_profile(grid, rival.constraints)

    motion = along(limited, path, len(grid))
    return {
        WHOLE: lambda: float(mrts.retime(limited, along(limited, path, len(grid))).duration or np.nan),
        "mrts.retime, the motion of arm and object at hand": lambda: float(
            mrts.retime(limited, motion).duration or np.nan
        ),
        "copp-py": by_copp_motion,
        "toppra": by_toppra(constraints, path, grid),
    }


def on_random_splines(
    cell: mrts.Cell, model: Any, limits: Array, points: int
) -> tuple[dict[str, Callable[[], float]], float]:
    """Whole calls, each for all splines with their total duration; and the share that got further samples."""
    data, grid = model.createData(), np.linspace(0, 1, points)
    splines = [spline_path(cell, model, seed).spline for seed in range(SPLINES)]
    motions = [carried_by_first(cell, grid, *(spline(grid, order) for order in range(3))) for spline in splines]
    refined = [mrts.retime(cell, motion).motion.samples > points for motion in motions]

    def torque(q: Array, dq: Array, ddq: Array) -> Array:
        return np.asarray(pin.rnea(model, data, q, dq, ddq))

    theirs = toppra.constraint.JointTorqueConstraint(
        torque, limits, np.zeros(len(limits)), discretization_scheme=DiscretizationType.Interpolation
    )
    planners = [by_toppra([theirs], toppra.SplineInterpolator(one.x, one(one.x)), grid) for one in splines]
    candidates: dict[str, Callable[[], float]] = {
        WHOLE: lambda: sum(float(mrts.retime(cell, motion).duration or np.nan) for motion in motions),
        "the same, between=None": lambda: sum(
            float(mrts.retime(cell, motion, between=None).duration or np.nan) for motion in motions
        ),
        "toppra, torques by a callback (Pinocchio)": lambda: sum(run() for run in planners),
    }
    return candidates, float(np.mean(refined))


def compare(candidates: dict[str, Callable[[], float]], points: int, repeats: int) -> None:
    """Print the time and the duration of each."""
    durations = {label: run() for label, run in candidates.items()}
    times = median_times(candidates, repeats)
    show(times, points, "point", {label: f"duration {seconds:.6f} s" for label, seconds in durations.items()})


def main(points: int = POINTS, repeats: int = REPEATS) -> None:
    """Print the table."""
    toppra.setup_logging("ERROR")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cell = one_arm(folder)
        robot = cell.robots[0]
        limits = np.column_stack([robot.torque_lower, robot.torque_upper])
        model = model_with_box(cell)
        data = model.createData()
        path = one_arm_path(cell)
        grid = np.linspace(*path.path_interval, points)

        def torque(q: Array, dq: Array, ddq: Array) -> Array:
            return np.asarray(pin.rnea(model, data, q, dq, ddq))

        theirs = toppra.constraint.JointTorqueConstraint(
            torque, limits, np.zeros(len(limits)), discretization_scheme=DiscretizationType.Interpolation
        )
        a, b, c, *_ = theirs.compute_constraint_params(path, grid)
        rows = tuple(np.ascontiguousarray(part[:, : len(limits)]) for part in (a, b, c))
        motion = along(cell, path, points)
        constant = mrts.scale(cell, motion, between=None)
        core = by_toppra_core(folder, grid, rows, limits)
    given = rows, limits[:, 0], limits[:, 1]
    candidates: dict[str, Callable[[], float]] = {
        WHOLE: lambda: float(mrts.retime(cell, motion).duration or np.nan),
        FROM_PATH: lambda: timing_alone(constant),
        "copp-py, rows given": by_copp(grid, lambda: given, len(limits)),
        "copp-py, rows by mrts's generated C": by_copp_generated(cell, motion),
        "copp-py, torques by a callback (Pinocchio)": by_copp_robot(grid, path, limits, torque),
        "toppra, rows given": by_toppra([GivenRows(rows, limits)], path, grid),
        "toppra, torques by a callback (Pinocchio)": by_toppra([theirs], path, grid),
    } | ({} if core is None else {"toppra's C++ core, rows given": core})
    print(f"fastest timing, one UR5-class arm with its box, torque limits, {points} points, one processor, CPU time")
    compare(candidates, points, repeats)
    if core is None:
        print("  toppra's C++ core is not installed (TOPPRA_PREFIX)")
    print("velocities and accelerations alone, whole calls from the same spline")
    compare(of_motion_alone(cell, path, grid), points, repeats)
    candidates, refined = on_random_splines(cell, model, limits, points)
    print(f"{SPLINES} random splines, torque limits; {100 * refined:.0f} % got samples between their own")
    compare(candidates, SPLINES * points, repeats)


if __name__ == "__main__":
    on_one_processor()
    main()
