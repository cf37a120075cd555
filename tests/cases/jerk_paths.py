"""Random paths of one published arm with a load, for timings with limited jerk."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.polynomial import chebyshev
from published_robots import CASES, single_arm_cell, urdf_path
from random_cells import chain_model, configuration

import mrts
from mrts.coordination.coordinated_motion import carried_by_first

DEGREE = 5
HALF_WAY = 0.9  # rad, of the largest coefficient


@dataclass(frozen=True, eq=False)
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

    def at(self, s, order=0):
        """q or one of its derivatives by s, Shape (n, m)."""
        derived = chebyshev.chebder(self.coefficients, order, 2.0) if order else self.coefficients
        return chebyshev.chebval(2 * np.asarray(s) - 1, derived).T

    def torque(self, q, dq, ddq):
        return pin.rnea(self.model, self.data, configuration(self.model, q), dq, ddq)

    @property
    def data(self):
        if not hasattr(self, "_data"):
            object.__setattr__(self, "_data", self.model.createData())
        return self._data

    @property
    def limits(self):
        """Largest |q̇|, |τ| and |q⃛|, each Shape (m,)."""
        robot = self.cell.robots[0]
        return robot.velocity_limit, robot.torque_upper, robot.motors.jerk

    def motion(self, nodes):
        """The path over the time of a quintic, 1 s, as a motion of the cell."""
        time = np.linspace(0, 1, nodes)
        s, v, a, _ = quintic(time)
        dq, ddq = self.at(s, 1) * v[:, None], self.at(s, 2) * v[:, None] ** 2 + self.at(s, 1) * a[:, None]
        return carried_by_first(self.cell, time, self.at(s), dq, ddq)


def quintic(z):
    """The quintic from 0 to 1 at rest with no acceleration at its ends, and its three derivatives."""
    s = z**3 * (10 - 15 * z + 6 * z**2)
    return s, 30 * z**2 * (1 - z) ** 2, 60 * z * (1 - z) * (1 - 2 * z), 60 * (1 - 6 * z + 6 * z**2)


def jerk_path(robot, seed, folder):
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
