# SPDX-License-Identifier: MIT
"""The whole cell along the object's motion: joint positions, velocities and accelerations of every arm."""

from dataclasses import dataclass

import numpy as np

from mrts.cell import Cell, Robot
from mrts.errors import InputError, MotionError
from mrts.object_motion import ObjectMotion
from mrts.planar_inverse_kinematics import planar_joint_positions
from mrts.rigid_transform import Array

CLOSURE_TOLERANCE = 1e-9
"""Largest gap between tip and grasp [m, and entries of the rotation]; closed forms leave about 1e-15."""

CONDITION_LIMIT = 1e6
"""Condition number of a Jacobian above which an arm counts as singular: ten digits of q' are left."""


@dataclass(frozen=True)
class CoordinatedMotion:
    """N samples of a given motion of the object and the m joints that carry it.

    Attributes:
        object: Motion of the object.
        q: Joint positions of all arms in order, Shape (N, m) [rad or m].
        dq: q', Shape (N, m) [rad/s or m/s].
        ddq: q'', Shape (N, m) [rad/s² or m/s²].
    """

    object: ObjectMotion
    q: Array
    dq: Array
    ddq: Array

    def __post_init__(self) -> None:
        joints = np.shape(self.q)[-1] if np.ndim(self.q) == 2 else 0  # noqa: PLR2004 (a matrix)
        for name in ("q", "dq", "ddq"):
            value = getattr(self, name)
            if np.shape(value) != (len(self.object.time), joints) or not np.all(np.isfinite(value)):
                raise InputError(name, f"must have Shape ({len(self.object.time)}, joints) and be finite.")

    @property
    def samples(self) -> int:
        """Number of samples N."""
        return len(self.object.time)

    def inputs(self, load: Array) -> dict[str, Array]:
        """Inputs of the generated functions of a moving sample.

        Args:
            load: Load vector, Shape (7,).
        """
        return {
            "q": self.q,
            "dq": self.dq,
            "ddq": self.ddq,
            "object_rotation": self.object.rotation,
            "object_twist": self.object.twist,
            "object_acceleration": self.object.acceleration,
            "load": load,
        }


def follow_object(cell: Cell, motion: ObjectMotion) -> CoordinatedMotion:
    """Joint motion of every arm that keeps its grasp along the object's motion.

    Positions in closed form, on the branch nearest to the posture; velocities and accelerations from the
    generated J and J̇q̇, never by differencing.

    Args:
        cell: The cell; every arm must have three revolute joints in the cell's plane.
        motion: Motion of the object.

    Raises:
        InputError: If an arm has no closed-form inverse kinematics.
        MotionError: If the object leaves the plane, or an arm cannot reach or is singular; names robot and sample.
    """
    _check_in_plane(cell, motion)
    samples = len(motion.time)
    q = np.concatenate([planar_joint_positions(cell, robot, motion) for robot in cell.robots], axis=1)
    kinematics = cell.functions("kinematics", samples, {"q": q})
    J = kinematics["jacobian"]
    dq, ddq = np.empty_like(q), np.empty_like(q)
    for index, robot in enumerate(cell.robots):
        columns = cell.joint_slices[robot.name]
        _check_closure(robot, index, motion, kinematics)
        _check_condition(robot, motion, J[:, :, columns])
        dq[:, columns] = _solve(J[:, :, columns], _tip_rates(cell, robot, motion)[0])
    bias = cell.functions("bias_acceleration", samples, {"q": q, "dq": dq})["bias_acceleration"]
    bias = bias.reshape(samples, len(cell.wrench_components), len(cell.robots))
    for index, robot in enumerate(cell.robots):
        columns = cell.joint_slices[robot.name]
        acceleration = _tip_rates(cell, robot, motion)[1]
        ddq[:, columns] = _solve(J[:, :, columns], acceleration - bias[:, :, index])
    return CoordinatedMotion(motion, q, dq, ddq)


def _solve(J: Array, rate: Array) -> Array:
    return np.asarray(np.linalg.solve(J, rate[:, :, None])[:, :, 0], dtype=np.float64)


def _check_in_plane(cell: Cell, motion: ObjectMotion) -> None:
    if cell.plane is None:
        raise InputError(
            cell.name,
            "this version finds joint motions for planar cells only (key 'plane'); for a spatial cell "
            "build a CoordinatedMotion from joint positions, velocities and accelerations in Python.",
            key="plane",
        )
    normal = ({0, 1, 2} - {"xyz".index(axis) for axis in cell.plane}).pop()
    out_of_plane = max(float(np.max(np.abs(motion.twist[:, normal]))), _tilt(motion, normal))
    if out_of_plane > CLOSURE_TOLERANCE:
        raise MotionError(
            f"the object leaves the plane {cell.plane} of cell '{cell.name}': its path may move in {cell.plane} and "
            f"turn about {'xyz'[normal]} only."
        )


def _tilt(motion: ObjectMotion, normal: int) -> float:
    in_plane = [axis for axis in range(3) if axis != normal]
    return float(np.max(np.abs(motion.twist[:, [3 + axis for axis in in_plane]])))


def _tip_rates(cell: Cell, robot: Robot, motion: ObjectMotion) -> tuple[Array, Array]:
    """Velocity and acceleration of a tip in its base axes, cell components, each Shape (N, w)."""
    r = motion.rotation @ robot.T_object_tip.p
    v, w = motion.twist[:, :3], motion.twist[:, 3:]
    a, dw = motion.acceleration[:, :3], motion.acceleration[:, 3:]
    R = robot.T_world_base.R
    names = ("fx", "fy", "fz", "nx", "ny", "nz")
    rows = [names.index(component) for component in cell.wrench_components]
    velocity = np.concatenate([(v + np.cross(w, r)) @ R, w @ R], axis=1)
    linear = a + np.cross(dw, r) + np.cross(w, np.cross(w, r))
    acceleration = np.concatenate([linear @ R, dw @ R], axis=1)
    return velocity[:, rows], acceleration[:, rows]


def _check_closure(robot: Robot, index: int, motion: ObjectMotion, kinematics: dict[str, Array]) -> None:
    """Compare the generated forward kinematics with the grasp that the object asks for."""
    position = kinematics["position"].reshape(len(motion.time), 3, -1)[:, :, index]
    rotation = kinematics["rotation"][:, :, 3 * index : 3 * index + 3]
    wanted = motion.position + motion.rotation @ robot.T_object_tip.p
    gap = np.max(np.abs(position - wanted), axis=1)
    turn = np.max(np.abs(rotation - motion.rotation @ robot.T_object_tip.R), axis=(1, 2))
    worst = int(np.argmax(np.maximum(gap, turn)))
    if max(gap[worst], turn[worst]) > CLOSURE_TOLERANCE:
        raise MotionError(
            f"robot '{robot.name}' does not close the chain at sample {worst} (t = {motion.time[worst]:.6g} s): its "
            f"tip is {gap[worst]:.3g} m off its grasp (rotation matrices differ by {turn[worst]:.3g}). Check base.xyz "
            "and grasp.xyz along the plane's normal, and grasp.rpy."
        )


def _check_condition(robot: Robot, motion: ObjectMotion, J: Array) -> None:
    condition = np.linalg.cond(J)
    worst = int(np.argmax(condition))
    if not condition[worst] < CONDITION_LIMIT:
        raise MotionError(
            f"robot '{robot.name}' is singular at sample {worst} (t = {motion.time[worst]:.6g} s): the condition "
            f"number of its Jacobian is {condition[worst]:.3g}, the limit is {CONDITION_LIMIT:.0e}. Keep the arm "
            "away from full stretch and full fold: move the path, the base or the grasp."
        )
