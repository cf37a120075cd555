"""Random paths of one published arm with a load, for timings with limited jerk."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.polynomial import chebyshev
from published_robots import CASES, single_arm_cell, urdf_path
from random_cells import chain_model, configuration
from scipy.interpolate import CubicSpline

import mrts
from mrts.following.coordinated_motion import carried_by_first
from mrts.motion.joint_table import JointCourse

DEGREE = 5
HALF_WAY = 0.9  # rad, of the largest coefficient
FINE = np.linspace(0, 1, 4001)
NEWTON_STEPS = 3


@dataclass(eq=False)
class JerkPath:
    """An arm as a cell of ours and as a model of Pinocchio with the load welded to its hand, and a path q(s).

    Attributes:
        cell: With velocity, torque and jerk limits.
        model: Of the same arm.
        coefficients: Chebyshev's, of s in [0, 1], Shape (DEGREE + 1, m).
    """

    cell: mrts.Cell
    model: Any
    coefficients: np.ndarray

    def at(self, s: np.ndarray | float, order: int = 0) -> np.ndarray:
        """Joint positions or one of its derivatives by s, Shape (n, m)."""
        derived = chebyshev.chebder(self.coefficients, order, 2.0) if order else self.coefficients
        return chebyshev.chebval(2 * np.asarray(s) - 1, derived).T

    def torque(self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> np.ndarray:
        """Inverse dynamics by Pinocchio [N m]."""
        return pin.rnea(self.model, self.data, configuration(self.model, q), dq, ddq)

    @property
    def limits(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Largest |q̇|, |τ| and |q⃛|, each Shape (m,)."""
        robot = self.cell.robots[0]
        return robot.velocity_limit, robot.torque_upper, robot.motors.jerk

    def motion(self, nodes: int) -> mrts.CoordinatedMotion:
        """The path over the time of a quintic of its arc length, 1 s, as a motion of the cell that knows its course."""
        time, course = np.linspace(0, 1, nodes), JointCourse(lambda at, order=0: self.by_time(np.asarray(at))[order])
        return replace(carried_by_first(self.cell, time, *self.by_time(time)), course=course)

    def by_time(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Joint positions and its first two derivatives by the time of that quintic, each Shape (n, m)."""
        s, v, a, _ = (part[:, None] for part in self.course(time))
        first, second = self.at(s[:, 0], 1), self.at(s[:, 0], 2)
        return self.at(s[:, 0]), first * v, second * v**2 + first * a

    def course(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The place s and its first three derivatives by the time of that quintic, each Shape (n,)."""
        s, (_, speed, change, jerk) = self.s_at(time), (self.arc(1.0) * part for part in quintic(time))
        q1, q2, q3 = (self.at(s, order) for order in (1, 2, 3))
        pace = np.sqrt(np.mean(q1**2, axis=1))
        rise = np.mean(q1 * q2, axis=1) / pace
        bend = (np.mean(q2**2 + q1 * q3, axis=1) - rise**2) / pace
        v = speed / pace
        a = (change - rise * v**2) / pace
        return s, v, a, (jerk - 3 * rise * v * a - bend * v**3) / pace

    def s_at(self, time: np.ndarray | float) -> np.ndarray:
        """The place s by the time of that quintic, Shape (n,)."""
        gone = self.arc(1.0) * quintic(time)[0]
        s = np.interp(gone, self.arc(FINE), FINE)
        for _ in range(NEWTON_STEPS):
            s = np.clip(s - (self.arc(s) - gone) / np.sqrt(np.mean(self.at(s, 1) ** 2, axis=1)), 0.0, 1.0)
        return s

    @cached_property
    def arc(self) -> Any:
        """Arc length by s."""
        return CubicSpline(FINE, np.sqrt(np.mean(self.at(FINE, 1) ** 2, axis=1))).antiderivative()

    @cached_property
    def data(self) -> Any:
        """Of the model."""
        return self.model.createData()


def quintic(z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The quintic from 0 to 1 at rest with no acceleration at its ends, and its three derivatives."""
    s = z**3 * (10 - 15 * z + 6 * z**2)
    return s, 30 * z**2 * (1 - z) ** 2, 60 * z * (1 - z) * (1 - 2 * z), 60 * (1 - 6 * z + 6 * z**2)


def jerk_path(robot: str, seed: int, folder: Path) -> JerkPath:
    """A random path of a published robot: its own velocity and torque limits, a random jerk limit, no friction."""
    rng = np.random.default_rng([seed, *robot.encode()])
    reference, tip = CASES[robot]
    model = chain_model(urdf_path(reference), tip)
    middle = (model.lowerPositionLimit + model.upperPositionLimit) / 2
    room = np.minimum((model.upperPositionLimit - model.lowerPositionLimit) / 2, np.pi)
    spread = rng.uniform(-1, 1, (DEGREE + 1, model.nq)) / np.arange(1, DEGREE + 2)[:, None] ** 2
    spread *= np.minimum(HALF_WAY, 0.8 * room / np.sum(np.abs(spread), axis=0))
    spread[0] += middle
    cell = mrts.load_cell(single_arm_cell(folder, reference, tip, model.nq)).without_wrench_limits()
    arm = cell.robots[0]
    none, most = np.zeros(model.nq), np.full(model.nq, 10 ** rng.uniform(1.5, 3.0))
    motors = replace(arm.motors, jerk=most, viscous=none, coulomb=none)
    arm = replace(arm, motors=motors, torque_lower=-model.effortLimit, torque_upper=model.effortLimit.copy())
    cell = replace(cell, robots=(arm,))
    model.gravity.linear = arm.T_world_base.R.T @ cell.gravity
    frame, tip_object = model.frames[model.getFrameId(tip)], pin.SE3(arm.T_object_tip.R, arm.T_object_tip.p).inverse()
    load = pin.Inertia(cell.mass, np.zeros(3), cell.inertia)
    model.appendBodyToJoint(frame.parentJoint, load, frame.placement * tip_object)
    return JerkPath(cell, model, spread)
