"""All branches of a six-joint arm by subproblem decomposition (the package eaik)."""

import numpy as np
from eaik.IK_HP import HPRobot


def six_joint_branches(robot, motion):
    """Joint positions that hold the grasp at t = 0, Shape (count, 6); some may be least-squares only."""
    corners = np.concatenate([np.zeros((1, 3)), robot.points, robot.T_base_tip.p[None]])
    solver = HPRobot(robot.axes, np.diff(corners, axis=0))
    assert solver.hasKnownDecomposition()
    base, pose = robot.T_world_base, np.eye(4)
    # the package counts rotations from the tip's own at joint positions zero
    pose[:3, :3] = base.R.T @ motion.rotation[0] @ robot.T_object_tip.R @ robot.T_base_tip.R.T
    pose[:3, 3] = base.R.T @ (motion.position[0] + motion.rotation[0] @ robot.T_object_tip.p - base.p)
    return np.asarray(solver.IK(pose).Q, dtype=np.float64).reshape(-1, 6)
