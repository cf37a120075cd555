# SPDX-License-Identifier: MIT
"""Closed-form inverse kinematics of a planar arm with three revolute joints."""

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import MotionError
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.motion.object_motion import ObjectMotion

REACH_TOLERANCE = 1e-12
"""Relative overshoot of |cos| of the elbow angle that is rounding and not distance."""

SHORTEST_LINK = 1e-9
"""A shorter link has no direction [m]: its joints coincide, and leave no triangle to solve."""

CLOSED_FORM_JOINTS = ("revolute", "revolute", "revolute")
"""Two links reach a point, a third turns the tip."""


def has_closed_form(cell: Cell, robot: Robot) -> bool:
    """Whether `planar_branches` can solve an arm: three revolute joints in a planar cell."""
    if cell.plane is None or robot.joint_types != CLOSED_FORM_JOINTS:
        return False
    # with a shorter one the arm is singular everywhere, and found to be so
    return bool(np.min(np.linalg.norm(np.diff(robot.points, axis=0), axis=1)) > SHORTEST_LINK)


def planar_branches(cell: Cell, robot: Robot, motion: ObjectMotion) -> list[Array]:
    """Both elbow branches along a motion, each Shape (N, 3) [rad], continuous in time.

    The wrist's place in the base frame fixes the triangle of the two links; the law of cosines gives the elbow.
    In-plane vectors are the plane's two coordinates in the order of its name; angles are positive from the first to
    the second.

    Args:
        cell: A planar cell.
        robot: An arm with `has_closed_form`.
        motion: Motion of the object in the cell's plane.

    Raises:
        MotionError: If a sample is out of reach; names robot, sample and distance.
    """
    R_world_base, p_world_base = robot.T_world_base.R, robot.T_world_base.p
    first_axis, second_axis = axes = ["xyz".index(axis) for axis in cell.plane or "xy"]
    p_tip = (motion.position + motion.rotation @ robot.T_object_tip.p - p_world_base) @ R_world_base
    turned = R_world_base.T @ motion.rotation @ robot.T_object_tip.R @ robot.T_base_tip.R.T
    tip_angle = np.arctan2(turned[:, second_axis, first_axis], turned[:, first_axis, first_axis])

    corners = np.concatenate([robot.points, robot.T_base_tip.p[None]])[:, axes]
    links = np.diff(corners, axis=0)
    wrist = p_tip[:, axes] - _rotate(tip_angle, links[2]) - corners[0]
    lengths = np.hypot(links[:2, 0], links[:2, 1])
    cosine = (np.sum(wrist**2, axis=1) - lengths @ lengths) / (2 * lengths[0] * lengths[1])
    _check_reach(robot, motion, wrist, lengths, cosine)

    bend = np.arccos(np.clip(cosine, -1, 1))
    link_angles = np.arctan2(links[:2, 1], links[:2, 0])
    normal = np.cross(*np.eye(3)[axes])
    signs = np.sign(robot.axes @ normal)
    branches = []
    for sign in (-1.0, 1.0):
        turn = sign * bend  # from link 1 to link 2
        toward = np.arctan2(wrist[:, 1], wrist[:, 0])
        inner = np.arctan2(lengths[1] * np.sin(turn), lengths[0] + lengths[1] * np.cos(turn))
        first = toward - inner - link_angles[0]
        second = first + link_angles[0] + turn - link_angles[1]
        absolute = np.column_stack([first, second, tip_angle])
        branches.append(np.unwrap(np.diff(absolute, axis=1, prepend=0.0) * signs, axis=0))
    return branches


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
