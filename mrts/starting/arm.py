# SPDX-License-Identifier: MIT
"""An arm before its cell: where its joints and its hand are, what gravity asks of it, with nothing compiled."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from mrts.base.arrays import Array, cross
from mrts.base.errors import InputError
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.remarks import link_lengths
from mrts.cell.robot import Robot
from mrts.following.bodies import body_poses
from mrts.scene.arm_meshes import arm_meshes

NO_LEVER = 1e-3
"""A hand nearer to its last joint than this says nothing of where it points [m]."""


@dataclass(frozen=True, eq=False)
class ArmState:
    """Arms at N sets of joint positions, base frame.

    Attributes:
        R: Of the tip, Shape (N, 3, 3).
        p: Of the tip, Shape (N, 3) [m].
        axes: Of the joints, Shape (N, n, 3).
        points: On them, Shape (N, n, 3) [m].
        jacobian: Of the tip, linear then angular, Shape (N, 6, n).
        com: Of what each joint carries up to the next, Shape (N, n, 3) [m].
    """

    R: Array
    p: Array
    axes: Array
    points: Array
    jacobian: Array
    com: Array


@dataclass(frozen=True, eq=False)
class Arm:
    """One arm and what its URDF says of it.

    Attributes:
        robot: Base and grasp are the identity, efforts that are missing are infinite.
        com: Centre of mass of what each joint carries, base frame with every joint at zero, Shape (n, 3) [m].
        path: Of the URDF.
        urdf: How a cell file names it.
        base: Of its base link in the world, where that is given.
        beyond: Links that hang from its tip.
    """

    robot: Robot
    com: Array
    path: Path
    urdf: str = ""
    base: RigidTransform | None = None
    beyond: tuple[str, ...] = ()

    @cached_property
    def reach(self) -> float:
        """Length of the chain from the first joint to the tip [m]."""
        return float(np.sum(link_lengths(self.robot)))

    @cached_property
    def approach(self) -> Array:
        """Where its hand points, a unit vector in tip axes, Shape (3,).

        The axis of the tip frame that points away from the last joint; where the two coincide, from the one before.
        """
        T = self.robot.T_base_tip
        for point in self.robot.points[::-1]:
            away = T.R.T @ (T.p - point)
            if np.linalg.norm(away) > NO_LEVER:
                axis = int(np.argmax(np.abs(away)))
                direction = np.zeros(3)
                direction[axis] = np.sign(away[axis])
                return direction
        return np.array([0.0, 0.0, 1.0])

    @cached_property
    def overhang(self) -> float:
        """How far meshes that move with the tip reach beyond the tip's origin, where the hand points [m]."""
        robot = self.robot
        try:
            meshes = arm_meshes(self.path, robot.source.base_link, robot.joints)
        except InputError:
            return 0.0
        T, last = robot.T_base_tip, len(robot.joints)
        beyond = [np.max((mesh.vertices - T.p) @ T.R @ self.approach) for body, mesh in meshes if body == last]
        return max([0.0, *map(float, beyond)])

    def at(self, q: Array) -> ArmState:
        """The arm at joint positions, Shape (N, n) [rad or m]."""
        R, p = body_poses(self.robot, q)
        axes = np.einsum("nkij,kj->nki", R[:, :-1], self.robot.axes)
        points = np.einsum("nkij,kj->nki", R[:, :-1], self.robot.points) + p[:, :-1]
        com = np.einsum("nkij,kj->nki", R[:, 1:], self.com) + p[:, 1:]
        tip = p[:, -1] + R[:, -1] @ self.robot.T_base_tip.p
        turns = self.robot.turns[:, None]
        linear = np.where(turns, cross(axes, tip[:, None] - points), axes)
        angular = np.where(turns, axes, 0.0)
        jacobian = np.concatenate([linear, angular], axis=2).transpose(0, 2, 1)
        return ArmState(R[:, -1] @ self.robot.T_base_tip.R, tip, axes, points, jacobian, com)

    def torque(self, state: ArmState, gravity: Array, force: Array) -> Array:
        """Torques that hold the arm still while its hand exerts a force on the object [N], Shape (N, n) [N m or N].

        Gravity [m/s²] and the force are in base axes, Shape (3,).
        """
        mass: Array = np.array(self.robot.source.carried_mass)
        held = np.cumsum(mass[::-1])[::-1]
        moments = np.cumsum((mass[:, None] * state.com)[:, ::-1], axis=1)[:, ::-1]  # Σ m c of all behind a joint
        arms = moments - held[:, None] * state.points
        own = np.where(
            self.robot.turns,
            np.einsum("nki,nki->nk", state.axes, cross(arms, np.broadcast_to(gravity, arms.shape))),
            (state.axes @ gravity) * held,
        )
        wrench: Array = np.einsum("nij,i->nj", state.jacobian[:, :3], force)
        return wrench - own

    def middle(self) -> Array:
        """The middle of the joint limits, 0 where there are none, Shape (n,) [rad or m]."""
        lower, upper = self.robot.position_lower, self.robot.position_upper
        both = np.isfinite(lower) & np.isfinite(upper)
        return np.where(both, (np.where(both, lower, 0) + np.where(both, upper, 0)) / 2, 0.0)
