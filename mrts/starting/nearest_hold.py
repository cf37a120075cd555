# SPDX-License-Identifier: MIT
"""How near a hand comes to a grasp that it cannot hold: turned as the grasp wants it, inside the joint limits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply
from mrts.base.rigid_transform import vectors_from_rotations
from mrts.cell.cell import Cell
from mrts.motion.object_motion import ObjectMotion
from mrts.starting.postures import damped_step

ROTATION_WEIGHT = 30.0
"""Metres that a radian counts as: for each metre that is missing, a hand of 1 m is off by 1 mrad."""

STEPS = 60
"""Of damped least squares; a few dozen settle."""

LEAST_DAMPING = 1e-6
"""Beside squares of Jacobians, which are about 1: far from any grasp, error alone would let it sink to nothing."""

MOST_DAMPING = 1e6
"""Steps are then a millionth of what the error asks for."""

LONGEST_STEP = 1.0
"""Of a joint [rad or m]."""

LEAST_GAIN = 1e-7
"""Share by which a step must make the error smaller for the search to go on."""


@dataclass(frozen=True)
class NearestHold:
    """The nearest that a hand comes.

    Attributes:
        q: Joint positions, Shape (n_i,) [rad or m].
        off: From the hand to where it should be, world axes, Shape (3,) [m]: what the base would have to move.
        turn: Angle that is left [rad].
    """

    q: Array
    off: Array
    turn: float

    @property
    def gap(self) -> float:
        """Distance that is left [m]."""
        return float(np.linalg.norm(self.off))


def nearest_hold(arm: Cell, motion: ObjectMotion, sample: int, starts: Array) -> NearestHold:
    """The nearest that an arm comes to its grasp at a sample, of what several starts lead to.

    Levenberg-Marquardt with weighted rotation; a joint at a limit stays there while it is pushed outward.

    Args:
        arm: A cell of one arm.
        motion: Motion of the object.
        sample: Of the motion.
        starts: Joint positions, Shape (T, n_i) [rad or m].
    """
    (robot,) = arm.robots
    weights = np.where(np.array(arm.wrench_rows) >= 3, ROTATION_WEIGHT, 1.0)  # noqa: PLR2004 (rotations)

    def errors(q: Array) -> tuple[Array, Array, Array]:
        poses = arm.functions("kinematics", len(q), {"q": q})
        error, sizes = _pose_error(arm, motion, sample, poses)
        return weights * error, weights[:, None] * poses["jacobian"], sizes

    q = np.clip(starts, robot.position_lower, robot.position_upper)
    error, J, sizes = errors(q)
    damping = np.full(len(q), 1e-2)
    for _ in range(STEPS):
        held = _pushed(q, error, J, robot.position_lower, robot.position_upper)
        step = damped_step(error, np.where(held[:, None, :], 0.0, J), damping, LONGEST_STEP)
        tried = np.clip(q + step, robot.position_lower, robot.position_upper)
        new, J_new, new_sizes = errors(tried)
        before, after = np.sum(error**2, axis=1), np.sum(new**2, axis=1)
        better = after < before
        damping = np.clip(np.where(better, damping / 3, damping * 4), LEAST_DAMPING, MOST_DAMPING)
        gains = bool(np.any(before - after > LEAST_GAIN * before))
        for ours, theirs in ((q, tried), (error, new), (J, J_new), (sizes, new_sizes)):
            ours[better] = theirs[better]
        if not gains and np.all(better | (damping > 1)):
            break
    best = int(np.argmin(sizes[:, 0] + ROTATION_WEIGHT * sizes[:, 1]))
    off = np.zeros(6)
    off[arm.wrench_rows] = error[best] / weights
    return NearestHold(q[best], robot.T_world_base.R @ off[:3], float(sizes[best, 1]))


def _pose_error(arm: Cell, motion: ObjectMotion, sample: int, poses: dict[str, Array]) -> tuple[Array, Array]:
    """Error in base axes and cell components, Shape (T, w), and its sizes [m, rad], Shape (T, 2)."""
    (robot,) = arm.robots
    grasp, R = robot.T_object_tip, robot.T_world_base.R
    off = motion.position[sample] + motion.rotation[sample] @ grasp.p - poses["position"]
    turned = vectors_from_rotations(motion.rotation[sample] @ grasp.R @ poses["rotation"].transpose(0, 2, 1))
    sizes = np.column_stack([np.linalg.norm(off, axis=1), np.linalg.norm(turned, axis=1)])
    return np.concatenate([off @ R, turned @ R], axis=1)[:, arm.wrench_rows], sizes


def _pushed(q: Array, error: Array, J: Array, low: Array, high: Array) -> NDArray[np.bool_]:
    """Joints that stand at a limit and are pushed beyond it, Shape (T, n_i)."""
    towards = apply(J.transpose(0, 2, 1), error)
    return ((q <= low) & (towards < 0)) | ((q >= high) & (towards > 0))
