"""Motions of an object from a start to an end, and what holds of the joints that follow one."""

import numpy as np
from scipy.integrate import cumulative_simpson

import mrts
from mrts.following.coordinate import tip_rates

POSE = 1e-10


def motion(xyz, rpy=(0, 0, 0), start=(0, 0.1, 0.35), **changes):
    description = {
        "duration": 0.8,
        "samples": 201,
        "profile": "quintic",
        "start": {"xyz": list(start)},
        "end": {"xyz": list(xyz), "rpy": list(rpy)},
    }
    return mrts.load_motion(description | changes)


def assert_consistent(cell, joint_motion, tolerance=1e-6):
    """The grasps are held, J q' and J q'' + J̇q' are the object's rates, and q' and q'' are derivatives of q."""
    given = joint_motion.object
    poses = cell.functions("kinematics", joint_motion.samples, {"q": joint_motion.q})
    for index, (robot, joints) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
        tip = poses["position"].reshape(joint_motion.samples, 3, -1)[:, :, index]
        assert np.max(np.abs(tip - given.position - given.rotation @ robot.T_object_tip.p)) < POSE
        R = poses["rotation"][:, :, 3 * index : 3 * index + 3]
        assert np.max(np.abs(R - given.rotation @ robot.T_object_tip.R)) < POSE
        held = np.einsum("nwj,nj->nw", poses["jacobian"][:, :, joints], joint_motion.dq[:, joints])
        np.testing.assert_allclose(held, tip_rates(cell, robot, given)[0], atol=1e-9)
    for values, rates in ((joint_motion.q, joint_motion.dq), (joint_motion.dq, joint_motion.ddq)):
        moved = cumulative_simpson(rates, x=given.time, axis=0, initial=0)
        np.testing.assert_allclose(moved, values - values[0], atol=tolerance * (1 + np.max(np.abs(rates))))
