# SPDX-License-Identifier: MIT
"""Coarse grids: what a timing with limits at 100 samples oversteps between them, and what it loses, beside toppra.

One UR5-class arm with the shipped box, torque limits. Random paths, given to mrts as tables of joint positions and as
motion files with waypoints, 100 samples each: by the path's own parameter, or from rest to rest by a time law. toppra
(Seidel, interpolation scheme) gets the path by its own parameter, with dynamics by Pinocchio, and the same 100 samples
as its grid points. Both are looked at 50 times denser on the exact path, each with its own speed between the samples;
the durations are compared with that of toppra on a fine grid.
"""

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import toppra
import yaml
from pinocchio import rnea
from scipy.interpolate import BPoly, CubicSpline
from toppra.constraint import DiscretizationType, JointTorqueConstraint

import mrts
from mrts.base.arrays import Array
from mrts.base.errors import MotionError
from mrts.motion.joint_table import JointTable
from mrts.motion.object_courses import PROFILES
from mrts.timing.path_pieces import PathError, path_pieces
from mrts.timing.result import TimedPiece

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cases import DUAL, MOTIONS, duration, model_with_box, one_arm

LIFT = DUAL / MOTIONS["dual_ur5"]
POINTS = 100
PATHS = 20
WAYPOINTS = 6
LAST = 2.0
FINE = np.linspace(0, 1, 20001)
EXACT = np.linspace(0, 1, 2001)
DENSER = 50
KNOTS = 401


@dataclass(frozen=True, eq=False)
class ArmPath:
    """One arm with its load, and an exact joint path by its own parameter s from 0 to 1.

    Attributes:
        cell: Torque limits only.
        model: Of Pinocchio, with the load.
        spline: The path.
    """

    cell: mrts.Cell
    model: Any
    spline: CubicSpline

    @cached_property
    def limits(self) -> Array:
        """Least and largest torques, Shape (m, 2) [N m]."""
        robot = self.cell.robots[0]
        return np.column_stack([robot.torque_lower, robot.torque_upper])

    @cached_property
    def data(self) -> Any:
        """Pinocchio's memory."""
        return self.model.createData()

    @cached_property
    def arc(self) -> CubicSpline:
        """Arc length by s, root mean square of the joints."""
        return CubicSpline(FINE, np.sqrt(np.mean(self.spline(FINE, 1) ** 2, axis=1))).antiderivative()

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Pinocchio's inverse dynamics [N m]."""
        return np.asarray(rnea(self.model, self.data, q, dq, ddq))

    def by_toppra(self, grid: Array) -> Array:
        """Toppra's squared speeds at grid points, Shape (n,)."""
        path = toppra.SplineInterpolator(self.spline.x, self.spline(self.spline.x))
        limit = JointTorqueConstraint(
            self.torque,
            self.limits,
            np.zeros(len(self.limits)),
            discretization_scheme=DiscretizationType.Interpolation,
        )
        planner = toppra.algorithm.TOPPRA([limit], path, gridpoints=grid, solver_wrapper="seidel")
        _, speeds, *_ = planner.compute_parameterization(0, 0)
        return np.asarray(speeds) ** 2

    def excess(self, s: Array, x: Array, u: Array) -> float:
        """The largest overstepping of a torque limit, as a share of half the room between both.

        Args:
            s: Places on the path, Shape (k,).
            x: ṡ² there.
            u: s̈ there.
        """
        q, first, second = (self.spline(s, order) for order in range(3))
        dq, ddq = first * np.sqrt(x)[:, None], first * u[:, None] + second * x[:, None]
        torque = np.array([self.torque(*row) for row in zip(q, dq, ddq, strict=True)])
        over = np.maximum(torque - self.limits[:, 1], self.limits[:, 0] - torque)
        return float(np.max(2 * over / np.ptp(self.limits, axis=1)))

    def excess_of_toppra(self, grid: Array, x: Array) -> float:
        """Between grid points, with the constant s̈ of each segment."""
        away = (np.arange(DENSER) + 0.5) / DENSER
        step, change = np.diff(grid)[:, None], np.diff(x)[:, None]
        s, dense = grid[:-1, None] + step * away, x[:-1, None] + change * away
        return self.excess(s.ravel(), dense.ravel(), np.repeat(change / (2 * step), DENSER))

    def excess_of(self, part: TimedPiece, grid: Array) -> float:
        """Between samples of ours at places s of the path: between two of them σ is a quintic of the arc length's."""
        path, away = part.piece.path, (np.arange(DENSER) + 0.5) / DENSER
        pace = part.piece.arc_speed
        chart = BPoly.from_derivatives(
            path.object.time, np.column_stack([self.arc(grid), pace, np.mean(path.dq * path.ddq, axis=1) / pace])
        )
        sigma = (path.object.time[:-1, None] + part.piece.step[:, None] * away).ravel()
        start, change = part.rates[:, :1], np.diff(part.rates, axis=1)
        x = (part.x[:-1, None] + 2 * part.piece.step[:, None] * away * (start + change * away / 2)).ravel()
        u = (start + change * away).ravel()
        s = np.interp(chart(sigma), self.arc(FINE), FINE)
        first, second = self.spline(s, 1), self.spline(s, 2)
        speed = np.sqrt(np.mean(first**2, axis=1))
        rise = np.mean(first * second, axis=1) / speed
        along, rate = chart(sigma, 1) ** 2 * x, chart(sigma, 1) * u + chart(sigma, 2) * x  # of the arc length
        return self.excess(s, along / speed**2, (rate - rise * along / speed**2) / speed)


@dataclass(frozen=True)
class Comparison:
    """One path timed by both on the same samples.

    Attributes:
        theirs: Toppra's excess between its grid points, share of a limit.
        ours: Ours between the samples as they were given.
        refined: That which `mrts.retime` leaves, after it has added samples.
        samples: It then has.
        longer: Durations against the optimum's, less 1: toppra's, ours, ours with the samples that were added.
    """

    theirs: float
    ours: float
    refined: float
    samples: int
    longer: tuple[float, float, float]


def compared(path: ArmPath, motion: Any, grid: Array) -> Comparison:
    """Time a path by both.

    Args:
        path: The exact path.
        motion: Its samples, as mrts is given them.
        grid: Where on the path they are, Shape (n,).
    """
    optimum, x = duration(EXACT, path.by_toppra(EXACT)), path.by_toppra(grid)
    as_given, refined = (mrts.retime(path.cell, motion, between=between) for between in (None, 1e-4))
    (part,) = as_given.pieces
    if refined.excess is None:
        raise TypeError(refined.status)
    times = (duration(grid, x), as_given.duration or np.inf, refined.duration or np.inf)
    return Comparison(
        theirs=path.excess_of_toppra(grid, x),
        ours=path.excess_of(part, grid),
        refined=refined.excess.share,
        samples=refined.motion.samples,
        longer=(times[0] / optimum - 1, times[1] / optimum - 1, times[2] / optimum - 1),
    )


def spline_path(cell: mrts.Cell, model: Any, seed: int) -> ArmPath:
    """A random spline of the joints about the arm's posture."""
    rng, knots = np.random.default_rng([18, seed]), np.linspace(0, 1, WAYPOINTS)
    around = cell.robots[0].posture + rng.uniform(-0.8, 0.8, (WAYPOINTS, len(cell.robots[0].joints)))
    return ArmPath(cell, model, CubicSpline(knots, around))


def table(path: ArmPath, grid: Array) -> JointTable:
    """Joint positions alone, at even times."""
    robot = path.cell.robots[0]
    columns = {f"{robot.name}/{joint}": column for joint, column in zip(robot.joints, path.spline(grid).T, strict=True)}
    return JointTable(Path("table.csv"), np.linspace(0, LAST, len(grid)), columns)


def through_waypoints(cell: mrts.Cell, model: Any, seed: int) -> tuple[ArmPath, mrts.CoordinatedMotion, Array] | None:
    """A motion file through random poses about the shipped lift's start, its exact path and its samples' places on it.

    None where the arm cannot follow, or a joint turns back so sharply that the motion stops between two samples.
    """
    rng = np.random.default_rng([19, seed])
    start = np.array(yaml.safe_load(LIFT.read_text(encoding="utf-8"))["start"]["xyz"])
    poses = [
        {"xyz": (start + away).tolist(), "rpy": turn.tolist()}
        for away, turn in zip(rng.uniform(-0.15, 0.15, (5, 3)), rng.uniform(-0.5, 0.5, (5, 3)), strict=True)
    ]
    poses[0] = {"xyz": start.tolist(), "rpy": [0, 0, 0]}
    given: dict[str, Any] = {"waypoints": poses, "duration": LAST, "profile": "quintic"}

    def followed(samples: int) -> mrts.CoordinatedMotion:
        return mrts.follow_object(cell, mrts.load_motion(given | {"samples": samples}))

    try:
        fine, motion = followed(len(FINE)), followed(POINTS)
        path_pieces(cell, motion)
    except (MotionError, PathError):
        return None
    share = PROFILES["quintic"](FINE)[0]
    kept = np.unique(np.searchsorted(share, np.linspace(0, 1, KNOTS)).clip(max=len(share) - 1))
    spline = CubicSpline(share[kept], fine.q[kept])
    return ArmPath(cell, model, spline), motion, PROFILES["quintic"](np.linspace(0, 1, POINTS))[0]


def files_through_waypoints(cell: mrts.Cell, model: Any, paths: int) -> Iterator[Comparison]:
    """The first paths through waypoints that the arm can follow."""
    found = seed = 0
    while found < paths:
        given = through_waypoints(cell, model, seed)
        seed += 1
        if given is not None:
            found += 1
            yield compared(*given)


def report(label: str, found: list[Comparison]) -> None:
    """Print a kind of path."""

    def spread(values: Any, unit: str = " %") -> str:
        numbers = np.array(list(values), dtype=float) * (100 if unit else 1)
        return f"{np.median(numbers):.3g}{unit}, worst {np.max(numbers):.3g}{unit}"

    print(f"{label}, {len(found)} paths, {POINTS} samples: median, worst")
    print(f"  excess between samples   toppra {spread(one.theirs for one in found)}")
    print(f"                           mrts, no samples added {spread(one.ours for one in found)}")
    print(f"                           mrts {spread(one.refined for one in found)}")
    print(f"  samples                  mrts {spread((one.samples for one in found), '')}")
    for place, who in enumerate(("toppra", "mrts, no samples added", "mrts")):
        where = "longer than the optimum  " if place == 0 else " " * 25
        print(f"  {where}{who} {spread(one.longer[place] for one in found)}")
    ratio = [(1 + one.longer[2]) / (1 + one.longer[0]) for one in found]
    print(f"  duration, mrts / toppra  {np.median(ratio):.4f}, from {np.min(ratio):.4f} to {np.max(ratio):.4f}")


def main(paths: int = PATHS) -> None:
    """Print the table.

    Args:
        paths: Of each kind.
    """
    toppra.setup_logging("ERROR")
    with tempfile.TemporaryDirectory() as name:
        cell = one_arm(Path(name))
        model = model_with_box(cell)
        even = np.linspace(0, 1, POINTS)
        for label, grid in (
            ("joint tables, even in the spline's parameter", even),
            ("joint tables, a quintic from rest to rest", PROFILES["quintic"](even)[0]),
        ):
            splines = [spline_path(cell, model, seed) for seed in range(paths)]
            report(label, [compared(path, table(path, grid), grid) for path in splines])
        arm = replace(cell.robots[0], position_lower=np.full(6, -7.0), position_upper=np.full(6, 7.0))
        cell = replace(cell, robots=(arm,))
        report("motion files, a quintic from rest to rest", list(files_through_waypoints(cell, model, paths)))


if __name__ == "__main__":
    main()
