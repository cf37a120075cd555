"""The fastest timing of one arm by Drake's Toppra: its own kinematics, limits of joints and of a frame."""

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.optimization import Toppra
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame
from pydrake.trajectories import PiecewisePolynomial


def spline(s, q):
    """A path through joint positions, with continuous second derivatives."""
    return PiecewisePolynomial.CubicWithContinuousSecondDerivatives(s, q.T)


def derivatives(path, grid):
    """q, q' and q'' of such a path, each Shape (n, m)."""
    return [path.MakeDerivative(order).vector_values(grid).T for order in range(3)]


def by_drake(urdf, robot, path, grid, point, speed, box):
    """Duration within limits of the joints, of a point's speed [m/s], and of its acceleration along axes of a box [s].

    The box is axes in the base frame, Shape (3, 3), and the largest acceleration along each [m/s²]. None where Drake's
    forward pass fails, as on some paths with many segments.
    """
    axes, most = box
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(urdf))
    base = RigidTransform(RotationMatrix(axes), np.zeros(3))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(robot.source.base_link), base)
    frame = FixedOffsetFrame("limited", plant.GetFrameByName(point.link), RigidTransform(np.array(point.point)))
    frame = plant.AddFrame(frame)
    plant.Finalize()
    toppra = Toppra(path, plant, grid)
    toppra.AddJointVelocityLimit(-robot.velocity_limit, robot.velocity_limit)
    toppra.AddJointAccelerationLimit(robot.acceleration_lower, robot.acceleration_upper)
    toppra.AddFrameTranslationalSpeedLimit(frame, speed)
    far = np.concatenate([np.full(3, 1e6), most])
    toppra.AddFrameAccelerationLimit(frame, -far, far)
    found = toppra.SolvePathParameterization(0.0, 0.0)
    return found and found.end_time()
