"""Arms along their grasps in numpy, one sample and one arm after the other: a check of kernel/c/tracking."""

import numpy as np

from mrts.base.rigid_transform import vectors_from_rotations
from mrts.following import tracking as rule
from mrts.following.null_space import FOLD, LIMIT_PUSH, limit_zone
from mrts.kernel.tracking import FOLDED, FOLLOWED, LOST, OUT_OF_REACH, SINGULAR


def stretched(robot, q):
    """h(q), h'(q) and h''(q) of one arm, each Shape (n_i,)."""
    zone = limit_zone(robot)
    over = np.maximum((q - robot.position_upper) / zone + 1, 0)
    under = np.maximum((robot.position_lower - q) / zone + 1, 0)
    return (
        q + LIMIT_PUSH * (over**5 - under**5),
        1 + LIMIT_PUSH * 5 / zone * (over**4 + under**4),
        LIMIT_PUSH * 20 / zone**2 * (over**3 - under**3),
    )


class Arm:
    """One arm of a cell at given joint positions of all; `reference` is what a redundant one stays near, or None."""

    def __init__(self, cell, index, q, reference):
        self.cell, self.robot = cell, cell.robots[index]
        self.joints = cell.joint_slices[self.robot.name]
        self.w = len(cell.wrench_rows)
        self.of_wrench = slice(index * self.w, (index + 1) * self.w)
        self.q, self.index = q, index
        poses = cell.functions("kinematics", 1, {"q": q[None]})
        self.position = poses["position"].reshape(3, -1)[:, index]
        self.rotation = poses["rotation"][0][:, 3 * index : 3 * index + 3]
        self.J = poses["jacobian"][0][:, self.joints]
        self.null = np.linalg.svd(self.J)[2][self.w :].T
        self.preferring = reference is not None and self.null.size > 0
        self.folds = False
        if not self.preferring:
            return
        h, slope, self.bend = stretched(self.robot, q[self.joints])
        self.gradient = h - stretched(self.robot, reference[self.joints])[0]
        self.F = np.linalg.lstsq(self.J.T, self.gradient, rcond=None)[0]
        self.hessian = np.diag(slope) - self.stiffness(self.F)
        reduced = self.null.T @ self.hessian @ self.null
        self.folds = not np.linalg.eigvalsh((reduced + reduced.T) / 2)[0] > FOLD
        if self.folds:
            self.hessian = np.diag(slope)

    def wrench(self, F):
        whole = np.zeros(self.w * len(self.cell.robots))
        whole[self.of_wrench] = F
        return whole[None]

    def stiffness(self, F):
        inputs = {"q": self.q[None], "wrench": self.wrench(F)}
        found = self.cell.functions("geometric_stiffness", 1, inputs)["geometric_stiffness"][0]
        return found[self.joints, self.joints]

    def preferred(self, along, change):
        """x = along + N y with hessian x = change + J'(anything), and the size of y."""
        if not self.preferring:
            return along, 0.0
        reduced = self.null.T @ self.hessian @ self.null
        y = np.linalg.solve(reduced, self.null.T @ (change - self.hessian @ along))
        return along + self.null @ y, float(np.linalg.norm(y))

    def error(self, motion, k):
        """In base axes and cell components, and the errors of position and rotation."""
        grasp, R = self.robot.T_object_tip, self.robot.T_world_base.R
        off = motion.position[k] + motion.rotation[k] @ grasp.p - self.position
        turned = vectors_from_rotations((motion.rotation[k] @ grasp.R @ self.rotation.T)[None])[0]
        sizes = float(np.linalg.norm(off)), float(np.linalg.norm(turned))
        return np.concatenate([off @ R, turned @ R])[self.cell.wrench_rows], sizes

    def step(self, error):
        """A damped Newton step (Sugihara 2011), and its part in the null space."""
        square = self.J @ self.J.T + error @ error / 2 * np.eye(self.w)
        along = self.J.T @ np.linalg.lstsq(square, error, rcond=None)[0]
        return self.preferred(along, -self.gradient) if self.preferring else (along, 0.0)

    def rates(self, velocity, acceleration):
        """q' and q'' of the arm."""
        inverse = np.linalg.pinv(self.J, rcond=1e-12)
        dq = self.preferred(inverse @ velocity, np.zeros(len(self.J.T)))[0]
        every = np.zeros_like(self.q)
        every[self.joints] = dq
        inputs = {"q": self.q[None], "dq": every[None]}
        bias = self.cell.functions("bias_acceleration", 1, inputs)["bias_acceleration"].reshape(self.w, -1)
        change = None
        if self.preferring:
            inputs["wrench"] = self.wrench(self.F)
            rate = self.cell.functions("geometric_stiffness_rate", 1, inputs)["geometric_stiffness_rate"][0]
            change = rate[self.joints] + 2 * self.stiffness(inverse.T @ self.hessian @ dq) @ dq - self.bend * dq**2
        return dq, self.preferred(inverse @ (acceleration - bias[:, self.index]), change)[0]


def held(cell, index, motion, k, start, reference, steps=rule.TRACKING_STEPS):
    """Joints of all with those of one arm that come nearest to its grasp, errors, and the step still to go."""
    q, best, found = start.copy(), np.inf, None
    for _ in range(steps):
        arm = Arm(cell, index, q, reference)
        error, sizes = arm.error(motion, k)
        step, drift = arm.step(error)
        size = max(sizes)
        if arm.preferring and size <= rule.POSE_TOLERANCE:
            size = rule.POSE_TOLERANCE * np.tanh(drift)
        if size < best:
            best, found = size, (q.copy(), *sizes, drift)
        longest = np.max(np.abs(step))
        if longest <= rule.SETTLED:
            break
        q[arm.joints] += step * min(1.0, rule.STEP_LIMIT / longest)
    return found


def tracked(cell, index, motion, start):
    """q, q' and q'' of one arm, each Shape (N, n_i), from positions of all, how that ends, and at which sample."""
    joints = cell.joint_slices[cell.robots[index].name]
    q, dq, ddq = (np.zeros((len(motion.time), joints.stop - joints.start)) for _ in range(3))
    velocity, acceleration = rule.tip_rates(cell, cell.robots[index], motion)
    at = start.copy()
    for k in range(len(motion.time)):
        if k:
            h = motion.time[k] - motion.time[k - 1]
            at[joints] = predicted = q[k - 1] + h * dq[k - 1] + h * h / 2 * ddq[k - 1]
            at, gap, turn, drift = held(cell, index, motion, k, at, start)
            if max(gap, turn) > rule.POSE_TOLERANCE:
                return (q, dq, ddq), OUT_OF_REACH, k
            if drift > rule.SETTLED_PREFERENCE:
                return (q, dq, ddq), FOLDED, k
            if np.max(np.abs(at[joints] - predicted)) > rule.JUMP_LIMIT:
                return (q, dq, ddq), LOST, k
        arm = Arm(cell, index, at, start)
        if not np.linalg.cond(arm.J) < rule.CONDITION_LIMIT:
            return (q, dq, ddq), SINGULAR, k
        if arm.folds:
            return (q, dq, ddq), FOLDED, k
        q[k] = at[joints]
        dq[k], ddq[k] = arm.rates(velocity[k], acceleration[k])
    return (q, dq, ddq), FOLLOWED, len(motion.time)
