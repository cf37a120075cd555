# SPDX-License-Identifier: MIT
"""Closed-form inverse kinematics of a planar arm with three revolute joints."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import MotionError
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.inverse_kinematics.reach import ArmPlaces
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


@dataclass(frozen=True)
class PlanarBranches:
    """Both elbow branches of an arm along a motion, or along one of each of many cells.

    Attributes:
        branches: Each Shape (…, N, 3) [rad], continuous in time; where the wrist is out of reach as near as it comes.
        wrist: From the first joint, Shape (…, N, 2) [m].
        lengths: Of both links, Shape (2,) [m].
        excess: By how much the cosine of the elbow's angle is beyond ±1, Shape (…, N): out of reach.
    """

    branches: tuple[Array, Array]
    wrist: Array
    lengths: Array
    excess: Array

    def out_of_reach(self) -> NDArray[np.bool_]:
        """Whether some sample is, Shape (…)."""
        return np.asarray(np.max(self.excess, axis=-1) > REACH_TOLERANCE)

    def failure(self, robot: Robot, time: Array, which: tuple[int, ...] = ()) -> str:
        """The message for a wrist that is.

        Args:
            robot: The arm.
            time: Shape (N,) [s].
            which: Place among many; none of one.
        """
        wrist, worst = self.wrist[which], int(np.argmax(self.excess[which]))
        distance = float(np.hypot(*wrist[worst]))
        longest, shortest = float(np.sum(self.lengths)), float(abs(self.lengths[0] - self.lengths[1]))
        if distance > longest:
            why = f"its wrist would be {distance:.6g} m from joint 1 and reaches {longest:.6g} m: "
            why += f"{distance - longest:.3g} m too far"
        else:
            why = f"its wrist would be {distance:.6g} m from joint 1 and comes no nearer than {shortest:.6g} m: "
            why += f"{shortest - distance:.3g} m too near"
        return (
            f"robot '{robot.name}' cannot reach its grasp at sample {worst} (t = {time[worst]:.6g} s): {why}. Move "
            "the path, the base or the grasp."
        )


def planar_branches(cell: Cell, robot: Robot, motion: ObjectMotion) -> tuple[Array, Array]:
    """Both elbow branches along a motion, each Shape (N, 3) [rad], continuous in time.

    Args:
        cell: A planar cell.
        robot: An arm with `has_closed_form`.
        motion: Motion of the object in the cell's plane.

    Raises:
        MotionError: If a sample is out of reach; names robot, sample and distance.
    """
    base, grasp = robot.T_world_base, robot.T_object_tip
    found = branches_of_places(
        cell, robot, ArmPlaces(base.R, base.p, grasp.R, grasp.p), motion.position, motion.rotation
    )
    if found.out_of_reach():
        raise MotionError(found.failure(robot, motion.time))
    return found.branches


def branches_of_places(cell: Cell, robot: Robot, places: ArmPlaces, position: Array, rotation: Array) -> PlanarBranches:
    """Both elbow branches of an arm in its places.

    The wrist's place in the base frame fixes the triangle of the two links; the law of cosines gives the elbow.
    In-plane vectors are the plane's two coordinates in the order of its name; angles are positive from the first to
    the second.

    Args:
        cell: A planar cell.
        robot: An arm with `has_closed_form`.
        places: Its places.
        position: Of the object, Shape (…, N, 3) [m].
        rotation: Likewise, Shape (…, N, 3, 3).
    """
    first_axis, second_axis = axes = ["xyz".index(axis) for axis in cell.plane or "xy"]
    R_base, R_tip = places.base_rotation[..., None, :, :], places.tip_rotation[..., None, :, :]
    held = (rotation @ places.tip_position[..., None, :, None])[..., 0]
    p_tip = ((position + held - places.base_position[..., None, :])[..., None, :] @ R_base)[..., 0, :]
    turned = np.swapaxes(R_base, -1, -2) @ rotation @ R_tip @ robot.T_base_tip.R.T
    tip_angle = np.arctan2(turned[..., second_axis, first_axis], turned[..., first_axis, first_axis])

    corners = np.concatenate([robot.points, robot.T_base_tip.p[None]])[:, axes]
    links = np.diff(corners, axis=0)
    wrist = p_tip[..., axes] - _rotate(tip_angle, links[2]) - corners[0]
    lengths = np.hypot(links[:2, 0], links[:2, 1])
    cosine = (np.sum(wrist**2, axis=-1) - lengths @ lengths) / (2 * lengths[0] * lengths[1])

    bend = np.arccos(np.clip(cosine, -1, 1))
    link_angles = np.arctan2(links[:2, 1], links[:2, 0])
    signs = np.sign(robot.axes @ np.cross(*np.eye(3)[axes]))

    def branch(sign: float) -> Array:
        turn = sign * bend  # from link 1 to link 2
        toward = np.arctan2(wrist[..., 1], wrist[..., 0])
        inner = np.arctan2(lengths[1] * np.sin(turn), lengths[0] + lengths[1] * np.cos(turn))
        first = toward - inner - link_angles[0]
        second = first + link_angles[0] + turn - link_angles[1]
        absolute = np.stack([first, second, tip_angle], axis=-1)
        return np.unwrap(np.diff(absolute, axis=-1, prepend=0.0) * signs, axis=-2)

    return PlanarBranches((branch(-1.0), branch(1.0)), wrist, lengths, np.abs(cosine) - 1)


def _rotate(angle: Array, vector: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]], axis=-1)
