# SPDX-License-Identifier: MIT
"""Where the parts of a cell are in space, for drawing: arms as lines through their joints, the object as a box."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.base.rigid_transform import rotations_from_vectors
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot

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
    """Where the name of an arm stands in the world: at its base, or at its first joint where another has that too.

    Returns:
        Shape (3,) [m].
    """
    base = robot.T_world_base
    return base.p + base.R @ robot.points[0] if shares_base(cell, robot) else base.p


def perpendicular(direction: Array) -> Array:
    """A unit vector at right angles to a direction, Shape (3,)."""
    across = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    return np.asarray(across / np.linalg.norm(across))


def body_poses(robot: Robot, q: Array) -> tuple[Array, Array]:
    """What takes each body of the arm from where it is in base axes with every joint at zero to the world.

    Body 0 is the base, body k is moved by the first k joints.

    Args:
        robot: The arm.
        q: Joint positions, Shape (N, n_i) [rad or m].

    Returns:
        R, Shape (N, n_i + 1, 3, 3), and p, Shape (N, n_i + 1, 3) [m].
    """
    R = np.broadcast_to(robot.T_world_base.R, (len(q), 3, 3))
    p = np.broadcast_to(robot.T_world_base.p, (len(q), 3))
    rotations, positions = [R], [p]
    for index, (kind, axis, point) in enumerate(zip(robot.joint_types, robot.axes, robot.points, strict=True)):
        if kind == "prismatic":
            p = p + R @ axis * q[:, index, None]
        else:
            center = p + R @ point
            R = R @ rotations_from_vectors(q[:, index, None] * axis)
            p = center - R @ point
        rotations.append(R)
        positions.append(p)
    return np.stack(rotations, axis=1), np.stack(positions, axis=1)


def joint_points(robot: Robot, q: Array) -> Array:
    """The arm as a line in the world: its base, a point on every joint's axis, its tip, Shape (N, n_i + 2, 3) [m].

    Args:
        robot: The arm.
        q: Joint positions, Shape (N, n_i) [rad or m].
    """
    return points_on_bodies(robot, *body_poses(robot, q))


def points_on_bodies(robot: Robot, R: Array, p: Array) -> Array:
    """As `joint_points`, of bodies that stand where `body_poses` has them, Shape (N, n_i + 2, 3) [m].

    Args:
        robot: The arm.
        R: Shape (N, n_i + 1, 3, 3).
        p: Shape (N, n_i + 1, 3) [m].
    """
    # a joint's point moves with the body that it carries
    own = np.concatenate([np.zeros((1, 3)), robot.points])
    points = p + np.einsum("nbij,bj->nbi", R, own)
    tip = p[:, -1] + R[:, -1] @ robot.T_base_tip.p
    return np.concatenate([points, tip[:, None]], axis=1)


def object_box(cell: Cell) -> Array:
    """Sides of the uniform box along the object's axes with about its mass and inertia, Shape (3,) [m]."""
    diagonal = np.diag(cell.inertia)
    squares = 6 / cell.mass * (np.sum(diagonal) - 2 * diagonal)
    sides: Array = np.sqrt(np.maximum(squares, 0))
    return np.maximum(sides, THINNEST * max(float(np.max(sides)), SMALLEST))


@dataclass(frozen=True)
class ContactForces:
    """Forces of one robot on the object, in the world.

    Attributes:
        point: Where it acts, Shape (N, 3) [m].
        force: Shape (N, 3) [N].
        moment: Shape (N, 3) [N m].
    """

    point: Array
    force: Array
    moment: Array


def contact_forces(cell: Cell, robot: Robot, position: Array, rotation: Array, wrench: Array) -> ContactForces:
    """A robot's contact wrench along a motion, in the world.

    Args:
        cell: The cell.
        robot: One of its arms.
        position: Of the object, Shape (N, 3) [m].
        rotation: Of the object in the world, Shape (N, 3, 3).
        wrench: In the robot's base axes and the cell's components, Shape (N, w) [N, N m].
    """
    six = np.zeros((len(wrench), 6))
    six[:, cell.wrench_rows] = wrench
    R = robot.T_world_base.R
    return ContactForces(position + rotation @ robot.T_object_tip.p, six[:, :3] @ R.T, six[:, 3:] @ R.T)
