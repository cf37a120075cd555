# SPDX-License-Identifier: MIT
"""Where the parts of a cell are in space, for drawing: arms as lines through their joints, the object as a box."""

import numpy as np

from mrts.base.arrays import Array
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.collisions.bodies import body_poses

THINNEST = 0.05
"""Least side of a drawn object, as a share of its longest: a planar object may have no thickness."""

SMALLEST = 1e-3
"""What counts as the longest side of an object whose inertia gives it none [m]."""


SAME_PLACE = 1e-3
"""Bases of two arms that are nearer are one: the torso of one machine [m]."""


def shares_base(cell: Cell, robot: Robot) -> bool:
    """Whether another arm stands where this one does, on the same machine."""
    bases = [other.T_world_base.p for other in cell.robots if other is not robot]
    return any(float(np.linalg.norm(base - robot.T_world_base.p)) < SAME_PLACE for base in bases)


def name_place(cell: Cell, robot: Robot) -> Array:
    """Where an arm's name stands, Shape (3,) [m]: at its base, or at its first joint where another has that too."""
    base = robot.T_world_base
    return base.p + base.R @ robot.points[0] if shares_base(cell, robot) else base.p


def perpendicular(direction: Array) -> Array:
    """A unit vector at right angles to a direction, Shape (3,)."""
    across = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    return np.asarray(across / np.linalg.norm(across))


def tip_at_posture(robot: Robot) -> RigidTransform:
    """The tip in the world, with the arm at its posture."""
    R, p = body_poses(robot, robot.posture[None])
    return RigidTransform(R[0, -1], p[0, -1]) @ robot.T_base_tip


def joint_points(robot: Robot, q: Array) -> Array:
    """The arm at q, Shape (N, n_i): its base, a point on each joint axis, its tip, Shape (N, n_i + 2, 3) [m]."""
    return points_on_bodies(robot, *body_poses(robot, q))


def points_on_bodies(robot: Robot, R: Array, p: Array) -> Array:
    """As `joint_points`, of bodies at R, Shape (…, n_i + 1, 3, 3), and p, Shape (…, n_i + 1, 3) [m]."""
    # a joint's point moves with the body that it carries
    points = p + np.einsum("...bij,bj->...bi", R, np.concatenate([np.zeros((1, 3)), robot.points]))
    tip = p[..., -1:, :] + np.einsum("...bij,j->...bi", R[..., -1:, :, :], robot.T_base_tip.p)
    return np.concatenate([points, tip], axis=-2)


def object_box(cell: Cell) -> Array:
    """Sides of the uniform box along the object's axes with about its mass and inertia, Shape (3,) [m]."""
    diagonal = np.diag(cell.inertia)
    squares = 6 / cell.mass * (np.sum(diagonal) - 2 * diagonal)
    sides: Array = np.sqrt(np.maximum(squares, 0))
    return np.maximum(sides, THINNEST * max(float(np.max(sides)), SMALLEST))


def contact_forces(cell: Cell, position: Array, rotation: Array, wrench: Array) -> tuple[Array, Array, Array]:
    """The contact wrenches of a cell at a moment, or along a motion, in the world.

    Args:
        cell: The cell.
        position: Of the object, Shape (…, 3) [m].
        rotation: Of the object in the world, Shape (…, 3, 3).
        wrench: Of all robots, each in its base axes and the cell's components, Shape (…, n w) [N, N m].

    Returns:
        Where each acts [m], forces [N] and moments [N m] on the object, Shape (…, n, 3) each.
    """
    robots = cell.robots
    six = np.zeros((*wrench.shape[:-1], len(robots), 6))
    six[..., cell.wrench_rows] = wrench.reshape(*six.shape[:-1], -1)
    bases = np.array([robot.T_world_base.R for robot in robots])
    tips = np.array([robot.T_object_tip.p for robot in robots])
    force, moment = (np.einsum("rij,...rj->...ri", bases, part) for part in (six[..., :3], six[..., 3:]))
    return position[..., None, :] + np.einsum("...ij,rj->...ri", rotation, tips), force, moment
