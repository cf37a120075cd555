# SPDX-License-Identifier: MIT
"""What holds the grasps at one sample, for CasADi: positions, velocities and accelerations of the joints."""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from mrts.base.arrays import Array
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.cell.cell import Cell


@dataclass(frozen=True)
class ObjectSymbols:
    """The object at one sample, world axes.

    Attributes:
        position: Shape (3,) [m].
        rotation: Shape (3, 3).
        twist: p' and φ', Shape (6,) [m/s, rad/s].
        acceleration: p'' and φ'', Shape (6,) [m/s², rad/s²].
    """

    position: Any
    rotation: Any
    twist: Any
    acceleration: Any

    @classmethod
    def fresh(cls) -> "ObjectSymbols":
        """Symbols of a sample."""
        return cls(ca.SX.sym("p", 3), ca.SX.sym("R", 3, 3), ca.SX.sym("twist", 6), ca.SX.sym("acceleration", 6))

    @property
    def stacked(self) -> Any:
        """All of it as one column, the rotation by columns, Shape (24,)."""
        return ca.vertcat(self.position, ca.vec(self.rotation), self.twist, self.acceleration)


@dataclass(frozen=True)
class ArmPose:
    """Base in the world and tip in the object, Shape (3, 3) and (3,) [m] each."""

    R_base: Any
    p_base: Any
    R_tip: Any
    p_tip: Any


def arm_poses(geometry: Any, robots: int) -> list[ArmPose]:
    """The poses of all arms in a geometry vector (`mrts.cell.cell.Cell.geometry`).

    Args:
        geometry: Shape (g,).
        robots: Number of arms.
    """
    poses = []
    for index in range(robots):
        entries = geometry[GRAVITY_SIZE + index * ROBOT_SIZE :][:ROBOT_SIZE]
        rotations = [ca.reshape(entries[start : start + 9], 3, 3).T for start in (0, 12)]
        poses.append(ArmPose(rotations[0], entries[9:12], rotations[1], entries[21:24]))
    return poses


def grasp_equations(
    cell: Cell, functions: dict[str, Any], joints: tuple[Any, Any, Any], carried: ObjectSymbols, geometry: Any
) -> tuple[Any, Any, Any]:
    """What is zero where every tip is at its grasp, moves with it and accelerates with it, Shape (n w,) each.

    The error of a rotation is the sine of its angle times its axis, in world axes: smooth where the angle is small,
    and its derivative at zero is the identity.

    Args:
        cell: The cell.
        functions: CasADi's functions of the cell.
        joints: q, q' and q'' of all arms, Shape (m,) each.
        carried: The object.
        geometry: Shape (g,).
    """
    q, dq, ddq = joints
    rows = cell.wrench_rows
    at = functions["kinematics"](q=q, geometry=geometry)
    bias = functions["bias_acceleration"](q=q, dq=dq, geometry=geometry)["bias_acceleration"]
    v, w = carried.twist[:3], carried.twist[3:]
    a, dw = carried.acceleration[:3], carried.acceleration[3:]
    closure, velocity, acceleration = [], [], []
    arms = arm_poses(geometry, len(cell.robots))
    for index, (arm, part) in enumerate(zip(arms, cell.joint_slices.values(), strict=True)):
        r = carried.rotation @ arm.p_tip
        turn = at["rotation"][:, 3 * index : 3 * index + 3] @ (carried.rotation @ arm.R_tip).T
        off = ca.vertcat(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]) / 2
        closure.append(ca.vertcat(at["position"][:, index] - carried.position - r, off)[rows])
        J = at["jacobian"][:, part.start : part.stop]
        linear = v + ca.cross(w, r), a + ca.cross(dw, r) + ca.cross(w, ca.cross(w, r))
        in_base = [
            ca.vertcat(arm.R_base.T @ of_point, arm.R_base.T @ turning)[rows]
            for of_point, turning in zip(linear, (w, dw), strict=True)
        ]
        velocity.append(J @ dq[part] - in_base[0])
        acceleration.append(J @ ddq[part] + bias[:, index] - in_base[1])
    return ca.vertcat(*closure), ca.vertcat(*velocity), ca.vertcat(*acceleration)


def object_columns(position: Array, rotation: Array, twist: Array, acceleration: Array) -> Array:
    """What `ObjectSymbols.stacked` is at N samples, Shape (24, N).

    Args:
        position: Shape (N, 3) [m].
        rotation: Shape (N, 3, 3).
        twist: Shape (N, 6) [m/s, rad/s].
        acceleration: Shape (N, 6) [m/s², rad/s²].
    """
    by_columns = rotation.transpose(0, 2, 1).reshape(len(rotation), 9)
    return np.concatenate([position, by_columns, twist, acceleration], axis=1).T
