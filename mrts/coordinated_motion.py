# SPDX-License-Identifier: MIT
"""The whole cell along the object's motion: joint positions, velocities and accelerations of every arm."""

from dataclasses import dataclass

import numpy as np

from mrts.cell import Cell, Robot
from mrts.errors import InputError, MotionError
from mrts.grasp_tracking import POSE_TOLERANCE, STARTING_STEPS, Tracks, solve_grasps, track_grasps, unreachable
from mrts.object_motion import ObjectMotion
from mrts.planar_inverse_kinematics import has_closed_form, planar_branches
from mrts.rigid_transform import Array

PLANE_TOLERANCE = 1e-9
"""Largest velocity and turning rate out of the plane of a planar cell [m/s, rad/s]: rounding of the input."""

LIMIT_TOLERANCE = 1e-9
"""How far a joint may pass its position limit [rad or m]: rounding."""


@dataclass(frozen=True)
class CoordinatedMotion:
    """N samples of a given motion of the object and the m joints that carry it.

    Attributes:
        object: Motion of the object.
        q: Joint positions of all arms in order, Shape (N, m) [rad or m].
        dq: q', Shape (N, m) [rad/s or m/s].
        ddq: q'', Shape (N, m) [rad/s² or m/s²].
    """

    object: ObjectMotion
    q: Array
    dq: Array
    ddq: Array

    def __post_init__(self) -> None:
        joints = np.shape(self.q)[-1] if np.ndim(self.q) == 2 else 0  # noqa: PLR2004 (a matrix)
        for name in ("q", "dq", "ddq"):
            value = getattr(self, name)
            if np.shape(value) != (len(self.object.time), joints) or not np.all(np.isfinite(value)):
                raise InputError(name, f"must have Shape ({len(self.object.time)}, joints) and be finite.")

    @property
    def samples(self) -> int:
        """Number of samples N."""
        return len(self.object.time)

    def inputs(self, load: Array) -> dict[str, Array]:
        """Inputs of the generated functions of a moving sample.

        Args:
            load: Load vector, Shape (7,).
        """
        return {
            "q": self.q,
            "dq": self.dq,
            "ddq": self.ddq,
            "object_rotation": self.object.rotation,
            "object_twist": self.object.twist,
            "object_acceleration": self.object.acceleration,
            "load": load,
        }


def follow_object(cell: Cell, motion: ObjectMotion) -> CoordinatedMotion:
    """Joint motion of every arm that keeps its grasp along the object's motion.

    At t = 0 the joints are solved near each robot's posture, which so selects the branch; a redundant arm takes the
    positions nearest to it. From there the branch is kept by continuity. Velocities and accelerations come from the
    generated J and J̇q̇, never from differences; a redundant arm moves with the least joint velocity.

    Args:
        cell: The cell.
        motion: Motion of the object.

    Raises:
        InputError: If an arm has too few joints to follow.
        MotionError: If the object leaves the plane of a planar cell, or an arm cannot reach, is singular, loses its
            branch or passes a joint limit; names robot, joint and sample.
    """
    check_motion(cell, motion)
    tracks = track_grasps(cell, motion, starting_positions(cell, motion)[None])
    tracks.require(0)
    check_joint_limits(cell, motion, tracks, 0)
    return CoordinatedMotion(motion, tracks.q[0], tracks.dq[0], tracks.ddq[0])


def check_motion(cell: Cell, motion: ObjectMotion) -> None:
    """Check what does not depend on the joints: the plane of a planar cell, enough joints.

    Raises:
        InputError: If an arm has fewer joints than wrench components.
        MotionError: If the object leaves the plane.
    """
    for robot in cell.robots:
        if len(robot.joints) < len(cell.wrench_components):
            raise InputError(
                cell.name,
                f"it has {len(robot.joints)} moving joints, but holding the object takes "
                f"{len(cell.wrench_components)}: it could not follow any motion.",
                key=f"robot '{robot.name}'",
            )
    if cell.plane is None:
        return
    normal = ({0, 1, 2} - {"xyz".index(axis) for axis in cell.plane}).pop()
    tilting = [3 + axis for axis in range(3) if axis != normal]
    if np.max(np.abs(motion.twist[:, [normal, *tilting]])) > PLANE_TOLERANCE:
        raise MotionError(
            f"the object leaves the plane {cell.plane} of cell '{cell.name}': its path may move in {cell.plane} and "
            f"turn about {'xyz'[normal]} only."
        )


def starting_positions(cell: Cell, motion: ObjectMotion) -> Array:
    """Joint positions that hold the grasps at t = 0 near the robots' postures, Shape (m,) [rad or m].

    Raises:
        MotionError: If an arm cannot reach from its posture.
    """
    posture = np.concatenate([robot.posture for robot in cell.robots])
    start = posture.copy()
    for robot, joints in zip(cell.robots, cell.joint_slices.values(), strict=True):
        if has_closed_form(cell, robot):
            near = [nearest_turns(robot, branch[0]) for branch in planar_branches(cell, robot, motion)]
            start[joints] = min(near, key=lambda q: float(np.max(np.abs(q - robot.posture))))
    found, gap, turn = solve_grasps(cell, motion, 0, start[None], STARTING_STEPS, posture[None])
    for index, robot in enumerate(cell.robots):
        if max(gap[0, index], turn[0, index]) > POSE_TOLERANCE:
            raise MotionError(unreachable(robot, motion, 0, gap[0, index], turn[0, index]))
    return found[0]


def nearest_turns(robot: Robot, q: Array) -> Array:
    """The same joint positions with whole turns added to come nearest to the posture, Shape (n_i,) [rad or m]."""
    turns = np.array([kind == "revolute" for kind in robot.joint_types])
    away = q - robot.posture
    return np.where(turns, robot.posture + (away + np.pi) % (2 * np.pi) - np.pi, q)


def joint_limit_failure(cell: Cell, motion: ObjectMotion, tracks: Tracks, track: int, robot: Robot) -> str | None:
    """The message for a joint that passes its position limit, None if none does."""
    q = tracks.q[track][:, cell.joint_slices[robot.name]]
    beyond = np.maximum(robot.position_lower - q, q - robot.position_upper)
    sample, joint = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
    if beyond[sample, joint] <= LIMIT_TOLERANCE:
        return None
    return (
        f"robot '{robot.name}' passes a position limit at sample {sample} (t = {motion.time[sample]:.6g} s): joint "
        f"'{robot.joints[joint]}' would be at {q[sample, joint]:.6g}, its limits are [{robot.position_lower[joint]:g}, "
        f"{robot.position_upper[joint]:g}]. Choose another posture, path, base or grasp."
    )


def check_joint_limits(cell: Cell, motion: ObjectMotion, tracks: Tracks, track: int) -> None:
    """Check the position limits of all joints of a track.

    Raises:
        MotionError: Names robot, joint, sample, value and limits.
    """
    for robot in cell.robots:
        failure = joint_limit_failure(cell, motion, tracks, track, robot)
        if failure:
            raise MotionError(failure)
