# SPDX-License-Identifier: MIT
"""Whether given joints hold every grasp on the object: positions, velocities and accelerations."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from mrts.cell import Cell
from mrts.errors import MotionError
from mrts.grasp_tracking import tip_rates
from mrts.object_motion import ObjectMotion
from mrts.rigid_transform import Array
from mrts.robot import Robot

GIVEN_CLOSURE = 1e-4
"""Largest gap between tip and grasp of joint motion that is given [m, rad]: tables carry few digits."""

GIVEN_SLIP = 1e-2
"""Largest slip of a tip on its grasp, relative to the largest velocity or acceleration: derivatives carry fewer."""

REST_SLIP = 1e-9
"""Slip of an object at rest that is rounding [m/s, rad/s and per s]."""


@dataclass(frozen=True)
class TipMotion:
    """Pose of one tip in the world, and its velocity and acceleration in base axes and cell components."""

    position: Array
    rotation: Array
    velocity: Array
    acceleration: Array


def tip_motions(cell: Cell, q: Array, dq: Array, ddq: Array) -> list[TipMotion]:
    """Motion of every tip from the joints' motion, each Shape (N, m)."""
    samples, robots = len(q), len(cell.robots)
    poses = cell.functions("kinematics", samples, {"q": q})
    bias = cell.functions("bias_acceleration", samples, {"q": q, "dq": dq})["bias_acceleration"]
    bias = bias.reshape(samples, len(cell.wrench_components), robots)
    positions = poses["position"].reshape(samples, 3, robots)
    tips = []
    for index, joints in enumerate(cell.joint_slices.values()):
        J = poses["jacobian"][:, :, joints]
        tips.append(
            TipMotion(
                positions[:, :, index],
                poses["rotation"][:, :, 3 * index : 3 * index + 3],
                np.einsum("nwj,nj->nw", J, dq[:, joints]),
                np.einsum("nwj,nj->nw", J, ddq[:, joints]) + bias[:, :, index],
            )
        )
    return tips


def in_world(cell: Cell, robot: Robot, rate: Array) -> tuple[Array, Array]:
    """Linear and angular part of a tip's rate, base axes and cell components, Shape (N, w), in the world."""
    full = np.zeros((len(rate), 6))
    full[:, cell.wrench_rows] = rate
    R = robot.T_world_base.R
    return full[:, :3] @ R.T, full[:, 3:] @ R.T


def check_closure(cell: Cell, given: ObjectMotion, q: Array, dq: Array, ddq: Array, where: str) -> None:
    """Check that the joints hold every grasp on the object: positions, velocities and accelerations.

    Args:
        cell: The cell.
        given: Motion of the object.
        q: Joint positions, Shape (N, m) [rad or m].
        dq: Joint velocities, likewise.
        ddq: Joint accelerations, likewise.
        where: What gave it, for the message.

    Raises:
        MotionError: Names the worst robot, sample and gap.
    """
    for robot, tip in zip(cell.robots, tip_motions(cell, q, dq, ddq), strict=True):
        gap = np.linalg.norm(tip.position - given.position - given.rotation @ robot.T_object_tip.p, axis=1)
        off = given.rotation @ robot.T_object_tip.R @ tip.rotation.transpose(0, 2, 1)
        turn = np.atleast_1d(Rotation.from_matrix(off).magnitude())
        worst = int(np.argmax(np.maximum(gap, turn)))
        if max(gap[worst], turn[worst]) > GIVEN_CLOSURE:
            raise MotionError(
                f"{where}: the joints do not close the chain. The tip of '{robot.name}' is off its grasp by "
                f"{gap[worst]:.3g} m and {turn[worst]:.3g} rad at sample {worst} (t = {given.time[worst]:.6g} s), the "
                f"worst; {GIVEN_CLOSURE:g} is allowed. Check the joint positions, the bases and the grasps."
            )
        velocity, acceleration = tip_rates(cell, robot, given)
        compared = (("velocities", tip.velocity, velocity), ("accelerations", tip.acceleration, acceleration))
        for what, ours, expected in compared:
            size = max(float(np.max(np.abs(expected))), float(np.max(np.abs(ours))))
            slip = np.max(np.abs(ours - expected), axis=1)
            worst = int(np.argmax(slip))
            if slip[worst] > max(GIVEN_SLIP * size, REST_SLIP):
                raise MotionError(
                    f"{where}: the joint {what} do not fit the object's: at sample {worst} (t = "
                    f"{given.time[worst]:.6g} s) the tip of '{robot.name}' slips on its grasp by {slip[worst]:.3g} "
                    f"(m, rad per s or s²); the largest is {size:.3g}. Check the {what}."
                )
