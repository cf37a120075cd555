# SPDX-License-Identifier: MIT
"""Whether an arm reaches its grasp, from the lengths of its links alone; closed form of planar arms with three joints.

The shoulder, where the second axis is nearest to the first, goes around the first axis; the wrist, where the last axis
but one is nearest to the last, goes around the last one, which the grasp holds. Between them lie links of fixed length.
Past axes that are parallel, a point keeps its place along them, and across them comes no further than the links reach.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.rigid_transform import plane_normal
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot

FEWEST_JOINTS = 4
"""Of an arm with a shoulder and a wrist."""

PARALLEL = 1e-9
"""Sine of the angle between axes below which they are parallel."""

CLEARLY = 1e-6
"""Distance that no rounding makes [m]: a grasp nearer than this to what an arm reaches is left to the search."""

REACH_TOLERANCE = 1e-12
"""Relative overshoot of |cos| of the elbow angle that is rounding and not distance."""

SHORTEST_LINK = 1e-9
"""A shorter link has no direction [m]: its joints coincide, and leave no triangle to solve."""

CLOSED_FORM_JOINTS = ("revolute", "revolute", "revolute")
"""Two links reach a point, a third turns the tip."""


@dataclass(frozen=True)
class ArmPlaces:
    """Where one arm stands and holds, in one cell or, with the same first axes throughout, in many.

    Attributes:
        base_rotation: Of the base in the world, Shape (…, 3, 3).
        base_position: Shape (…, 3) [m].
        tip_rotation: Of the tip in the object frame, Shape (…, 3, 3).
        tip_position: Shape (…, 3) [m].
    """

    base_rotation: Array
    base_position: Array
    tip_rotation: Array
    tip_position: Array


@dataclass(frozen=True)
class Reach:
    """How far an arm reaches.

    Attributes:
        shoulder: Centre of the circle that it goes around, base frame, Shape (3,) [m].
        wrist: Likewise in the tip frame.
        longest: Largest distance of the two [m].
    """

    shoulder: Array
    wrist: Array
    longest: float

    def distance(self, places: ArmPlaces, position: Array, rotation: Array) -> Array:
        """How far the wrist would be from the shoulder, Shape (…) [m].

        Args:
            position: Of the object, Shape (…, 3) [m].
        """
        held = places.tip_position + _times(places.tip_rotation, self.wrist)
        wrist = position + _times(rotation, held)
        shoulder = places.base_position + _times(places.base_rotation, self.shoulder)
        return np.asarray(np.linalg.norm(wrist - shoulder, axis=-1), dtype=np.float64)

    def beyond(self, distance: Array) -> NDArray[np.bool_]:
        """Whether the grasp is surely out of reach, as `distance`."""
        return np.asarray(distance > self.longest + CLEARLY)

    def failure(self, robot: Robot, time: Array, distance: float) -> str:
        """The message for a grasp that is out of reach at the first sample, time of Shape (N,) [s]."""
        return _failure(robot, time, 0, distance, "its shoulder", (0.0, self.longest))


def _failure(robot: Robot, time: Array, sample: int, distance: float, shoulder: str, reach: tuple[float, float]) -> str:
    shortest, longest = reach
    if distance > longest:
        why = f"and reaches {longest:.6g} m: {distance - longest:.3g} m too far"
    else:
        why = f"and comes no nearer than {shortest:.6g} m: {shortest - distance:.3g} m too near"
    return (
        f"robot '{robot.name}' cannot reach its grasp at sample {sample} (t = {time[sample]:.6g} s): its wrist would "
        f"be {distance:.6g} m from {shoulder} {why}. Move the path, the base or the grasp."
    )


def arm_reach(robot: Robot) -> Reach | None:
    """How far an arm reaches; None for one with few joints, or with prismatic ones."""
    if len(robot.joints) < FEWEST_JOINTS or set(robot.joint_types) != {"revolute"}:
        return None
    axes, points = robot.axes, robot.points
    shoulder, first = _nearest(axes[1], points[1], axes[0], points[0])
    wrist, last = _nearest(axes[-2], points[-2], axes[-1], points[-1])
    longest = float(np.linalg.norm(shoulder - first) + np.linalg.norm(wrist - last))
    at, joint, end = shoulder, 1, len(axes) - 2
    while joint < end:
        along, start, across = axes[joint], at, 0.0
        while joint + 1 < end and np.linalg.norm(np.cross(axes[joint + 1], along)) <= PARALLEL:
            across += float(np.linalg.norm(np.cross(points[joint + 1] - at, along)))
            at, joint = points[joint + 1], joint + 1
        to = wrist if joint + 1 == end else _nearest(axes[joint + 1], points[joint + 1], along, at)[0]
        across += float(np.linalg.norm(np.cross(to - at, along)))
        longest += float(np.hypot(across, (to - start) @ along))
        at, joint = to, joint + 1
    tip = robot.T_base_tip
    return Reach(first, tip.R.T @ (last - tip.p), longest)


def _nearest(axis: Array, point: Array, other: Array, through: Array) -> tuple[Array, Array]:
    """The points of two lines that are nearest to each other; of parallel ones any such pair."""
    across = np.cross(axis, other)
    square = float(across @ across)
    if square <= PARALLEL**2:
        return point, through + ((point - through) @ other) * other
    along = np.cross(through - point, other) @ across / square
    nearest = point + along * axis
    return nearest, through + ((nearest - through) @ other) * other


def _times(rotation: Array, vector: Array) -> Array:
    product: Array = (rotation @ vector[..., None])[..., 0]
    return product


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
            time: Shape (N,) [s].
            which: Place among many; none of one.
        """
        wrist, worst = self.wrist[which], int(np.argmax(self.excess[which]))
        reach = float(abs(self.lengths[0] - self.lengths[1])), float(np.sum(self.lengths))
        return _failure(robot, time, worst, float(np.hypot(*wrist[worst])), "joint 1", reach)


def planar_triangles(cell: Cell, robot: Robot, places: ArmPlaces, position: Array, rotation: Array) -> PlanarTriangles:
    """The triangle of an arm's links in its places.

    The wrist's place in the base frame fixes the triangle of the two links; the law of cosines gives the elbow.
    In-plane vectors are the plane's two coordinates in the order of its name; angles are positive from the first to
    the second.

    Args:
        position: Of the object, Shape (…, N, 3) [m].
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
