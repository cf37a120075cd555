# SPDX-License-Identifier: MIT
"""All branches of a six-joint arm by subproblem decomposition (the package eaik, extra `ik`)."""

from importlib.util import find_spec

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.motion.object_motion import ObjectMotion

DECOMPOSABLE_JOINTS = ("revolute",) * 6


def six_joint_branches(cell: Cell, robot: Robot, motion: ObjectMotion) -> Array | None:
    """Joint positions that hold the grasp at t = 0, Shape (count, 6) [rad]; some may be least-squares only.

    The arm is handed over as axes and points of the manifest, not as a URDF.

    Args:
        cell: The cell.
        robot: The arm.
        motion: Motion of the object.

    Returns:
        None if the arm does not have six revolute joints, its geometry has no decomposition, or eaik is not installed.
    """
    if cell.plane is not None or robot.joint_types != DECOMPOSABLE_JOINTS or find_spec("eaik") is None:
        return None
    from eaik.IK_HP import HPRobot  # noqa: PLC0415 (the extra 'ik')

    corners = np.concatenate([np.zeros((1, 3)), robot.points, robot.T_base_tip.p[None]])
    solver = HPRobot(robot.axes, np.diff(corners, axis=0))
    if not solver.hasKnownDecomposition():
        return None
    base = robot.T_world_base
    pose = np.eye(4)
    # the package counts rotations from the tip's own at joint positions zero
    pose[:3, :3] = base.R.T @ motion.rotation[0] @ robot.T_object_tip.R @ robot.T_base_tip.R.T
    pose[:3, 3] = base.R.T @ (motion.position[0] + motion.rotation[0] @ robot.T_object_tip.p - base.p)
    found = np.asarray(solver.IK(pose).Q, dtype=np.float64)
    return found.reshape(-1, len(robot.joints))
