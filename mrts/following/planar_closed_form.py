# SPDX-License-Identifier: MIT
"""Closed-form inverse kinematics of a planar arm with three revolute joints."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.rigid_transform import plane_normal
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.following.reach import ArmPlaces

REACH_TOLERANCE = 1e-12
"""Relative overshoot of |cos| of the elbow angle that is rounding and not distance."""

SHORTEST_LINK = 1e-9
"""A shorter link has no direction [m]: its joints coincide, and leave no triangle to solve."""

CLOSED_FORM_JOINTS = ("revolute", "revolute", "revolute")
"""Two links reach a point, a third turns the tip."""


def has_closed_form(cell: Cell, robot: Robot) -> bool:
    """Whether `planar_triangles` can solve an arm: three revolute joints in a planar cell."""
    if cell.plane is None or robot.joint_types != CLOSED_FORM_JOINTS:
        return False
    # with a shorter one the arm is singular everywhere, and found to be so
    return bool(np.min(np.linalg.norm(np.diff(robot.points, axis=0), axis=1)) > SHORTEST_LINK)


@dataclass(frozen=True)
class PlanarTriangles:
    """The triangle of an arm's two links along a motion, or along one of each of many cells.

    Attributes:
        wrist: From the first joint, Shape (…, N, 2) [m].
        tip_angle: Of the last link, Shape (…, N) [rad].
        cosine: Of the elbow's angle, Shape (…, N); beyond ±1 the wrist is out of reach.
        lengths: Of both links, Shape (2,) [m].
        link_angles: At zero, Shape (2,) [rad].
        signs: Whether each joint turns the plane's first axis to its second, 1, or back, -1, Shape (3,).
    """

    wrist: Array
    tip_angle: Array
    cosine: Array
    lengths: Array
    link_angles: Array
    signs: Array

    @property
    def excess(self) -> Array:
        """By how much the cosine is beyond ±1, Shape (…, N)."""
        return np.abs(self.cosine) - 1

    def branches(self) -> tuple[Array, Array]:
        """Both elbow branches, each Shape (…, N, 3) [rad], whole turns aside; out of reach as near as it comes."""
        bend = np.arccos(np.clip(self.cosine, -1, 1))
        toward = np.arctan2(self.wrist[..., 1], self.wrist[..., 0])

        def branch(sign: float) -> Array:
            turn = sign * bend  # from link 1 to link 2
            inner = np.arctan2(self.lengths[1] * np.sin(turn), self.lengths[0] + self.lengths[1] * np.cos(turn))
            first = toward - inner - self.link_angles[0]
            second = first + self.link_angles[0] + turn - self.link_angles[1]
            absolute = np.stack([first, second, self.tip_angle], axis=-1)
            return np.asarray(np.diff(absolute, axis=-1, prepend=0.0) * self.signs)

        return branch(-1.0), branch(1.0)

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


def planar_triangles(cell: Cell, robot: Robot, places: ArmPlaces, position: Array, rotation: Array) -> PlanarTriangles:
    """The triangle of an arm's links in its places.

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
    axes = ["xyz".index(axis) for axis in cell.plane or "xy"]
    in_plane = places.base_rotation[..., axes]
    first_axis = places.tip_rotation @ robot.T_base_tip.R[axes[0]]  # of the last link, in the object
    held = rotation @ np.stack([places.tip_position, first_axis], axis=-1)[..., None, :, :]
    p_tip = (position + held[..., 0] - places.base_position[..., None, :]) @ in_plane
    turned = held[..., 1] @ in_plane
    tip_angle = np.arctan2(turned[..., 1], turned[..., 0])

    corners = np.concatenate([robot.points, robot.T_base_tip.p[None]])[:, axes]
    links = np.diff(corners, axis=0)
    wrist = p_tip - _rotate(tip_angle, links[2]) - corners[0]
    lengths = np.hypot(links[:2, 0], links[:2, 1])
    cosine = (np.sum(wrist**2, axis=-1) - lengths @ lengths) / (2 * lengths[0] * lengths[1])
    signs = np.sign(robot.axes @ plane_normal(cell.plane or "xy"))
    return PlanarTriangles(wrist, tip_angle, cosine, lengths, np.arctan2(links[:2, 1], links[:2, 0]), signs)


def _rotate(angle: Array, vector: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]], axis=-1)
