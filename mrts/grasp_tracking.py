# SPDX-License-Identifier: MIT
"""Inverse kinematics of any arm: joint positions followed along the grasp by Newton steps.

Several tracks (one set of starting positions each) are followed at once; each robot of each track has its own outcome.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mrts.cell import Cell
from mrts.errors import MotionError
from mrts.object_motion import ObjectMotion
from mrts.rigid_transform import Array
from mrts.robot import Robot

POSE_TOLERANCE = 1e-10
"""Largest remaining pose error [m, rad]; Newton's quadratic convergence usually leaves 1e-15."""

SETTLED = 1e-12
"""Largest joint step [rad or m] at which the iteration ends: what is left is rounding."""

CONDITION_LIMIT = 1e6
"""Condition number of a Jacobian above which an arm counts as singular: ten digits of q' are left."""

JUMP_LIMIT = 0.5
"""Largest correction of a predicted joint position [rad or m]; a larger one has changed the branch."""

STARTING_STEPS = 300
"""Steps from the posture to the grasp at t = 0; a few dozen are usual."""

TRACKING_STEPS = 30
"""Steps from the predicted positions at a sample; two or three are usual."""

STEP_LIMIT = 0.3
"""Largest joint step [rad or m], so that a far start does not leap over its branch."""

REDUNDANCY_SWEEPS = 3
"""Sweeps of the implicit fourth-order rule that integrates q' = J⁺ v of a redundant arm."""


@dataclass
class Tracks:
    """T tracks of all m joints at N samples.

    Attributes:
        q: Shape (T, N, m) [rad or m].
        dq: q', Shape (T, N, m).
        ddq: q'', Shape (T, N, m).
        failures: By track and robot: why it ended, None if it reached the last sample.
    """

    q: Array
    dq: Array
    ddq: Array
    failures: list[dict[str, str | None]]

    def require(self, track: int) -> None:
        """Raise where a robot of a track failed.

        Raises:
            MotionError: With the reason.
        """
        for failure in self.failures[track].values():
            if failure is not None:
                raise MotionError(failure)


def tip_rates(cell: Cell, robot: Robot, motion: ObjectMotion) -> tuple[Array, Array]:
    """Velocity and acceleration of a grasp in the robot's base axes, cell components, each Shape (N, w)."""
    r = motion.rotation @ robot.T_object_tip.p
    v, w = motion.twist[:, :3], motion.twist[:, 3:]
    a, dw = motion.acceleration[:, :3], motion.acceleration[:, 3:]
    R = robot.T_world_base.R
    rows = cell.wrench_rows
    velocity = np.concatenate([(v + np.cross(w, r)) @ R, w @ R], axis=1)
    linear = a + np.cross(dw, r) + np.cross(w, np.cross(w, r))
    acceleration = np.concatenate([linear @ R, dw @ R], axis=1)
    return velocity[:, rows], acceleration[:, rows]


def solve_grasps(
    cell: Cell,
    motion: ObjectMotion,
    sample: int | NDArray[np.intp],
    start: Array,
    steps: int,
    pull: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Joint positions that hold the grasps at one sample, by damped Newton steps (Sugihara 2011).

    Args:
        cell: The cell.
        motion: Motion of the object.
        sample: Which sample; or one for each set of positions, Shape (T,).
        start: Positions to start from, Shape (T, m) [rad or m].
        steps: Most steps to take.
        pull: Posture that redundant arms move towards in their null space, Shape (T, m); None moves no further than
            needed.

    Returns:
        Positions with the smallest error met, Shape (T, m), and the errors of position [m] and of rotation [rad]
        there, each Shape (T, robots).
    """
    q, best_q = start.copy(), start.copy()
    count = len(start)
    best = np.full((count, len(cell.robots)), np.inf)
    parts = np.full((count, len(cell.robots), 2), np.inf)
    for _ in range(steps):
        poses = cell.functions("kinematics", count, {"q": q})
        step = np.zeros_like(q)
        for index, (robot, joints) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
            error, gap = _pose_error(cell, robot, index, motion, sample, poses)
            size = np.max(np.abs(gap), axis=1)
            better = size < best[:, index]
            best[better, index], parts[better, index] = size[better], gap[better]
            best_q[better, joints] = q[better, joints]
            J = poses["jacobian"][:, :, joints]
            damping = 0.5 * np.sum(error**2, axis=1)[:, None, None] * np.eye(J.shape[1])
            square = J @ J.transpose(0, 2, 1) + damping
            arm_step = _apply(J.transpose(0, 2, 1), _least_squares(square, error))
            if pull is not None and J.shape[2] > J.shape[1]:
                away = pull[:, joints] - q[:, joints]
                arm_step += away - _apply(np.linalg.pinv(J), _apply(J, away))
            longest = np.max(np.abs(arm_step), axis=1, keepdims=True)
            step[:, joints] = arm_step * np.minimum(1.0, STEP_LIMIT / np.maximum(longest, STEP_LIMIT))
        if np.max(np.abs(step)) <= SETTLED:
            break
        q += step
    if pull is not None and np.all(best <= POSE_TOLERANCE):
        return q, parts[:, :, 0], parts[:, :, 1]
    return best_q, parts[:, :, 0], parts[:, :, 1]


def follow_grasps(cell: Cell, motion: ObjectMotion, start: Array) -> tuple[Array, Array, Array]:
    """Follow the grasps from one set of positions at t = 0: joint positions, velocities and accelerations.

    In the compiled library the whole path is one call; what it does not settle, `track_grasps` does and explains.

    Args:
        cell: The cell.
        motion: Motion of the object.
        start: Positions at t = 0 that hold the grasps, Shape (m,) [rad or m].

    Raises:
        MotionError: If an arm cannot follow.
    """
    compiled = cell.functions.compiled
    if compiled is not None and compiled.can_track:
        arms = [(robot.T_world_base.R, robot.T_object_tip.R, robot.T_object_tip.p) for robot in cell.robots]
        path = (motion.time, motion.position, motion.rotation, motion.twist, motion.acceleration)
        found = compiled.track(arms, cell.wrench_rows, path, start, (TRACKING_STEPS, SETTLED, STEP_LIMIT))
        if found.done == len(motion.time) and not (
            np.any(np.maximum(found.gap, found.turn) > POSE_TOLERANCE)
            or np.any(found.jump > JUMP_LIMIT)
            or not np.all(found.condition < CONDITION_LIMIT)
        ):
            return found.q, found.dq, found.ddq
    tracks = track_grasps(cell, motion, start[None])
    tracks.require(0)
    return tracks.q[0], tracks.dq[0], tracks.ddq[0]


def track_grasps(cell: Cell, motion: ObjectMotion, start: Array) -> Tracks:
    """Follow the grasps from given positions at t = 0, keeping each branch by continuity.

    An arm with more joints than wrench components moves with the least joint velocity, q' = J⁺ v.

    Args:
        cell: The cell.
        motion: Motion of the object.
        start: Positions at t = 0 that hold the grasps, Shape (T, m) [rad or m].
    """
    count, samples = len(start), len(motion.time)
    shape = (count, samples, start.shape[1])
    failures: list[dict[str, str | None]] = [{robot.name: None for robot in cell.robots} for _ in range(count)]
    tracks = Tracks(np.zeros(shape), np.zeros(shape), np.zeros(shape), failures)
    rates = [tip_rates(cell, robot, motion) for robot in cell.robots]
    tracks.q[:, 0] = start
    _rates_at(cell, motion, 0, rates, tracks)
    redundant = "jacobian_rate" in cell.functions
    for k in range(1, samples):
        h = motion.time[k] - motion.time[k - 1]
        q, dq, ddq = tracks.q[:, k - 1], tracks.dq[:, k - 1], tracks.ddq[:, k - 1]
        predicted = q + h * dq + h * h / 2 * ddq
        for sweep in range(REDUNDANCY_SWEEPS if redundant else 1):
            guess = predicted
            if sweep > 0:
                guess = q + h / 2 * (dq + tracks.dq[:, k]) + h * h / 12 * (ddq - tracks.ddq[:, k])
            found, gap, turn = solve_grasps(cell, motion, k, guess, TRACKING_STEPS)
            tracks.q[:, k] = found
            _note_failures(cell, motion, k, tracks, guess, gap, turn)
            _rates_at(cell, motion, k, rates, tracks)
    return tracks


def _rates_at(cell: Cell, motion: ObjectMotion, k: int, rates: list[tuple[Array, Array]], tracks: Tracks) -> None:
    """Velocities q' and accelerations q'' of all tracks at one sample; notes singular arms."""
    count, q = len(tracks.q), tracks.q[:, k]
    J_all = cell.functions("kinematics", count, {"q": q})["jacobian"]
    inverses = {}
    for robot, joints, (velocity, _) in zip(cell.robots, cell.joint_slices.values(), rates, strict=True):
        J = J_all[:, :, joints]
        condition = np.linalg.cond(J)
        for track in np.flatnonzero(~(condition < CONDITION_LIMIT)):
            tracks.failures[track][robot.name] = tracks.failures[track][robot.name] or (
                f"robot '{robot.name}' is singular at sample {k} (t = {motion.time[k]:.6g} s): the condition number of "
                f"its Jacobian is {condition[track]:.3g}, the limit is {CONDITION_LIMIT:.0e}. Keep the arm away from "
                "full stretch, full fold and aligned axes: move the path, the base or the grasp."
            )
        inverses[robot.name] = np.linalg.pinv(J, rcond=1 / CONDITION_LIMIT**2)
        tracks.dq[:, k, joints] = _apply(inverses[robot.name], np.broadcast_to(velocity[k], (count, len(velocity[k]))))
    dq = tracks.dq[:, k]
    bias = cell.functions("bias_acceleration", count, {"q": q, "dq": dq})["bias_acceleration"]
    bias = bias.reshape(count, len(cell.wrench_components), len(cell.robots))
    J_rate = (
        cell.functions("jacobian_rate", count, {"q": q, "dq": dq})["jacobian_rate"]
        if "jacobian_rate" in cell.functions
        else None
    )
    for index, (robot, joints) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
        velocity, acceleration = (np.broadcast_to(rate[k], (count, len(rate[k]))) for rate in rates[index])
        J, inverse = J_all[:, :, joints], inverses[robot.name]
        ddq = _apply(inverse, acceleration - bias[:, :, index])
        if J_rate is not None and J.shape[2] > J.shape[1]:
            # derivative of J⁺ v in the null space (Golub and Pereyra 1973): (I - J⁺J) J̇ᵀ (J Jᵀ)⁻¹ v
            along = _apply(
                J_rate[:, :, joints].transpose(0, 2, 1), _apply(inverse.transpose(0, 2, 1) @ inverse, velocity)
            )
            ddq = ddq + along - _apply(inverse, _apply(J, along))
        tracks.ddq[:, k, joints] = ddq


def _note_failures(
    cell: Cell, motion: ObjectMotion, k: int, tracks: Tracks, predicted: Array, gap: Array, turn: Array
) -> None:
    for index, (robot, joints) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
        jump = np.max(np.abs(tracks.q[:, k, joints] - predicted[:, joints]), axis=1)
        for track, failures in enumerate(tracks.failures):
            if failures[robot.name] is not None:
                continue
            if max(gap[track, index], turn[track, index]) > POSE_TOLERANCE:
                failures[robot.name] = unreachable(robot, motion, k, gap[track, index], turn[track, index])
            elif jump[track] > JUMP_LIMIT:
                failures[robot.name] = (
                    f"robot '{robot.name}' loses its branch at sample {k} (t = {motion.time[k]:.6g} s): a joint is "
                    f"{jump[track]:.3g} (rad or m) from where its velocity led. Use more samples, or keep away from "
                    "the singularity near there."
                )


def unreachable(robot: Robot, motion: ObjectMotion, sample: int, gap: float, turn: float) -> str:
    """The message for a grasp out of reach: the smallest position and rotation errors met [m, rad]."""
    return (
        f"robot '{robot.name}' cannot reach its grasp at sample {sample} (t = {motion.time[sample]:.6g} s): its tip "
        f"came no nearer than {gap:.3g} m and {turn:.3g} rad. Choose another posture, from which another branch may "
        "reach it, or move the path, the base or the grasp."
    )


def _pose_error(
    cell: Cell,
    robot: Robot,
    index: int,
    motion: ObjectMotion,
    sample: int | NDArray[np.intp],
    poses: dict[str, Array],
) -> tuple[Array, Array]:
    """Error in base axes and cell components, Shape (T, w), and its sizes [m, rad], Shape (T, 2)."""
    R_world_tip = motion.rotation[sample] @ robot.T_object_tip.R
    p_world_tip = motion.position[sample] + motion.rotation[sample] @ robot.T_object_tip.p
    positions = poses["position"].reshape(-1, 3, len(cell.robots))
    off = p_world_tip - positions[:, :, index]
    rotations = poses["rotation"][:, :, 3 * index : 3 * index + 3]
    turned = Rotation.from_matrix(R_world_tip @ rotations.transpose(0, 2, 1)).as_rotvec()
    sizes = np.column_stack([np.linalg.norm(off, axis=1), np.linalg.norm(turned, axis=1)])
    R = robot.T_world_base.R
    return np.concatenate([off @ R, turned @ R], axis=1)[:, cell.wrench_rows], sizes


def _least_squares(square: Array, rhs: Array) -> Array:
    try:
        return np.asarray(np.linalg.solve(square, rhs[:, :, None])[:, :, 0], dtype=np.float64)
    except np.linalg.LinAlgError:
        return _apply(np.linalg.pinv(square), rhs)


def _apply(matrix: NDArray[np.floating[Any]], vector: Array) -> Array:
    return np.asarray(np.einsum("trk,tk->tr", matrix, vector), dtype=np.float64)
