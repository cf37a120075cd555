"""The fastest timing of one arm by toppra, its dynamics by Pinocchio."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import toppra
from cell_bank import random_spatial_cell
from random_cells import chain_model, configuration
from toppra.constraint import DiscretizationType

toppra.setup_logging("ERROR")


def one_arm(seed, folder):
    """An arm with its load, as a cell of ours and as a model of Pinocchio with the object welded to its hand."""
    rng = np.random.default_rng([77, seed])
    cell = random_spatial_cell(rng, folder, 1).cell.without_wrench_limits()
    robot = cell.robots[0]
    model = chain_model(folder / "arm0.urdf")
    model.gravity.linear = robot.T_world_base.R.T @ cell.gravity
    frame = model.frames[model.getFrameId("tip")]
    tip_object = pin.SE3(robot.T_object_tip.R, robot.T_object_tip.p).inverse()
    model.appendBodyToJoint(
        frame.parentJoint, pin.Inertia(cell.mass, np.zeros(3), cell.inertia), frame.placement * tip_object
    )
    strong = rng.uniform(150, 400, 6)
    wide = {"position_lower": np.full(6, -10.0), "position_upper": np.full(6, 10.0)}
    robot = replace(robot, torque_lower=-strong, torque_upper=strong, **wide)
    path = toppra.SplineInterpolator(np.linspace(0, 1, 5), robot.posture + rng.uniform(-0.8, 0.8, (5, 6)))
    return replace(cell, robots=(robot,)), model, path


def by_toppra(cell, model, path, grid):
    """Speeds squared at the grid points with rotor inertia and dry friction, None if there are none."""
    data, robot = model.createData(), cell.robots[0]

    def torque(q, dq, ddq):
        return pin.rnea(model, data, configuration(model, q), dq, ddq) + robot.motors.armature * ddq

    limits = np.column_stack([robot.torque_lower, robot.torque_upper])
    speed = np.column_stack([-robot.velocity_limit, robot.velocity_limit])
    constraints = [
        toppra.constraint.JointTorqueConstraint(
            torque, limits, robot.motors.coulomb, discretization_scheme=DiscretizationType.Interpolation
        ),
        toppra.constraint.JointVelocityConstraint(speed),
    ]
    return speeds_squared(constraints, path, grid)


def motion_by_toppra(robot, path, grid):
    """Likewise with the velocity and acceleration limits of an arm, and nothing else."""
    speed = np.column_stack([-robot.velocity_limit, robot.velocity_limit])
    acceleration = np.column_stack([robot.acceleration_lower, robot.acceleration_upper])
    interpolation = {"discretization_scheme": DiscretizationType.Interpolation}
    constraints = [
        toppra.constraint.JointVelocityConstraint(speed),
        toppra.constraint.JointAccelerationConstraint(acceleration, **interpolation),
    ]
    return speeds_squared(constraints, path, grid)


def speeds_squared(constraints, path, grid):
    instance = toppra.algorithm.TOPPRA(constraints, path, gridpoints=grid, solver_wrapper="seidel")
    _, speeds, *_ = instance.compute_parameterization(0, 0)
    return None if speeds is None else np.asarray(speeds) ** 2


def duration(step, x):
    speed = np.sqrt(x)
    return float(np.sum(2 * step / (speed[:-1] + speed[1:])))
