# SPDX-License-Identifier: MIT
"""Closed-form inverse kinematics of a planar arm with three revolute joints."""

import numpy as np

from mrts.cell import Cell, Robot
from mrts.errors import InputError, MotionError
from mrts.object_motion import ObjectMotion
from mrts.rigid_transform import Array

REACH_TOLERANCE = 1e-12
"""Relative overshoot of |cos| of the elbow angle that is rounding and not distance."""


def planar_joint_positions(cell: Cell, robot: Robot, motion: ObjectMotion) -> Array:
    """Joint positions that hold the grasp, continuous along the motion, Shape (N, 3) [rad].

    Of the two elbow branches, the one nearest to the robot's posture at t = 0 is taken and kept.

    Args:
        cell: A planar cell.
        robot: The arm.
        motion: Motion of the object in the cell's plane.

    Raises:
        InputError: If the arm has no closed form.
        MotionError: If a sample is out of reach; names robot, sample and distance.
    """
    branches = planar_branches(cell, robot, motion)
    distance = [np.max(np.abs(_wrap(branch[0] - robot.posture))) for branch in branches]
    nearest = branches[int(np.argmin(distance))]
    start = robot.posture + _wrap(nearest[0] - robot.posture)
    positions: Array = start + (np.unwrap(nearest, axis=0) - nearest[0])
    return positions


def planar_branches(cell: Cell, robot: Robot, motion: ObjectMotion) -> tuple[Array, Array]:
    """Both elbow branches along a motion, each Shape (N, 3) [rad], angles not unwrapped.

    The wrist's place in the base frame fixes the triangle of the two links; the law of cosines gives the elbow.

    Raises:
        InputError: If the arm has no closed form.
        MotionError: If a sample is out of reach.
    """
    chain = robot.planar_chain
    if chain is None or cell.plane is None:
        raise InputError(
            cell.name,
            "planar inverse kinematics needs three revolute joints normal to the plane.",
            key=f"robot '{robot.name}'",
        )
    R_world_base, p_world_base = robot.T_world_base.R, robot.T_world_base.p
    axes = ["xyz".index(axis) for axis in cell.plane]
    p_tip = (motion.position + motion.rotation @ robot.T_object_tip.p - p_world_base) @ R_world_base
    R_base_tip = R_world_base.T @ motion.rotation @ robot.T_object_tip.R
    turned = R_base_tip @ np.array(chain.tip_rotation).T
    tip_angle = np.arctan2(turned[:, axes[1], axes[0]], turned[:, axes[0], axes[0]])

    links = np.array(chain.links)
    wrist = p_tip[:, axes] - _rotate(tip_angle, links[2]) - np.array(chain.anchor)
    lengths = np.hypot(links[:2, 0], links[:2, 1])
    cosine = (np.sum(wrist**2, axis=1) - lengths @ lengths) / (2 * lengths[0] * lengths[1])
    _check_reach(robot, motion, wrist, lengths, cosine)

    bend = np.arccos(np.clip(cosine, -1, 1))
    link_angles = np.arctan2(links[:2, 1], links[:2, 0])
    signs = np.array(chain.signs)
    branches = []
    for sign in (-1.0, 1.0):
        turn = sign * bend  # from link 1 to link 2
        toward = np.arctan2(wrist[:, 1], wrist[:, 0])
        inner = np.arctan2(lengths[1] * np.sin(turn), lengths[0] + lengths[1] * np.cos(turn))
        first = toward - inner - link_angles[0]
        second = first + link_angles[0] + turn - link_angles[1]
        absolute = np.column_stack([first, second, tip_angle])
        branches.append(np.diff(absolute, axis=1, prepend=0.0) * signs)
    return branches[0], branches[1]


def _check_reach(robot: Robot, motion: ObjectMotion, wrist: Array, lengths: Array, cosine: Array) -> None:
    excess = np.abs(cosine) - 1
    worst = int(np.argmax(excess))
    if excess[worst] <= REACH_TOLERANCE:
        return
    distance = float(np.hypot(*wrist[worst]))
    longest, shortest = float(np.sum(lengths)), float(abs(lengths[0] - lengths[1]))
    if distance > longest:
        why = f"its wrist would be {distance:.6g} m from joint 1 and reaches {longest:.6g} m: "
        why += f"{distance - longest:.3g} m too far"
    else:
        why = f"its wrist would be {distance:.6g} m from joint 1 and comes no nearer than {shortest:.6g} m: "
        why += f"{shortest - distance:.3g} m too near"
    raise MotionError(
        f"robot '{robot.name}' cannot reach its grasp at sample {worst} (t = {motion.time[worst]:.6g} s): {why}. Move "
        "the path, the base or the grasp."
    )


def _rotate(angle: Array, vector: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def _wrap(angle: Array) -> Array:
    wrapped: Array = (angle + np.pi) % (2 * np.pi) - np.pi
    return wrapped
