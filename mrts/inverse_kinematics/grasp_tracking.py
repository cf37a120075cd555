# SPDX-License-Identifier: MIT
"""Inverse kinematics of any arm: joint positions followed along the grasp by Newton steps.

Several tracks (one set of starting positions each) are followed at once; each robot of each track has its own outcome.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply, cross, rotated
from mrts.base.errors import MotionError
from mrts.base.rigid_transform import vectors_from_rotations
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.inverse_kinematics.joint_limits import joint_limit_failure
from mrts.inverse_kinematics.null_space import (
    FOLD,
    LIMIT_PUSH,
    SINGULAR,
    NullSpace,
    change_along,
    is_redundant,
    limit_zone,
    null_spaces,
)
from mrts.inverse_kinematics.tracking_messages import branch_lost, unreachable
from mrts.kernel.tracking import GraspTask, NewtonRule, track_path
from mrts.motion.object_motion import ObjectMotion

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

OUT_OF_REACH, SINGULAR_ARM, LOST, PAST_A_LIMIT = "out of reach", "singular", "off their path", "past a position limit"
"""Kinds of failure: the grasp is too far, J has no inverse, the joints would have to jump, or to leave their limits."""

SETTLED_PREFERENCE = 1e-8
"""Largest step left in the null space of a redundant arm [rad or m]; Newton's convergence usually leaves 1e-15."""


@dataclass(frozen=True)
class TrackingFailure:
    """Why an arm cannot follow.

    Attributes:
        kind: In a phrase that its fellows share, such as "out of reach".
        message: With robot, sample and amount.
        sample: Where tracking ended; None if it reached the last.
    """

    kind: str
    message: str
    sample: int | None


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
    failures: list[dict[str, TrackingFailure | None]]

    def require(self, track: int) -> None:
        """Raise where a robot of a track failed.

        Raises:
            MotionError: With the reason.
        """
        for failure in self.failures[track].values():
            if failure is not None:
                raise MotionError(failure.message)


def tip_rates(cell: Cell, robot: Robot, motion: ObjectMotion) -> tuple[Array, Array]:
    """Velocity and acceleration of a grasp in the robot's base axes, cell components, each Shape (N, w)."""
    r = rotated(motion.rotation, robot.T_object_tip.p)
    v, w = motion.twist[:, :3], motion.twist[:, 3:]
    a, dw = motion.acceleration[:, :3], motion.acceleration[:, 3:]
    R = robot.T_world_base.R
    rows = cell.wrench_rows
    swing = cross(w, r)
    velocity = np.concatenate([(v + swing) @ R, w @ R], axis=1)
    linear = a + cross(dw, r) + cross(w, swing)
    acceleration = np.concatenate([linear @ R, dw @ R], axis=1)
    return velocity[:, rows], acceleration[:, rows]


@dataclass
class HeldGrasps:
    """Joint positions that hold the grasps at one sample as well as T starts led to.

    Attributes:
        q: Shape (T, m) [rad or m].
        gap: Error of position, Shape (T, robots) [m].
        turn: Error of rotation, Shape (T, robots) [rad].
        drift: Step still to go in the null space, Shape (T, robots) [rad or m]; zero for an arm that has none.
    """

    q: Array
    gap: Array
    turn: Array
    drift: Array

    def reached(self) -> NDArray[np.bool_]:
        """Which arms hold their grasps, Shape (T, robots)."""
        found: NDArray[np.bool_] = np.maximum(self.gap, self.turn) <= POSE_TOLERANCE
        return found

    def settled(self) -> NDArray[np.bool_]:
        """Which of them do so at the positions that they prefer, Shape (T, robots)."""
        found: NDArray[np.bool_] = self.reached() & (self.drift <= SETTLED_PREFERENCE)
        return found


def solve_grasps(
    cell: Cell,
    motion: ObjectMotion,
    sample: int | NDArray[np.intp],
    start: Array,
    steps: int,
    reference: Array | None,
) -> HeldGrasps:
    """Joint positions that hold the grasps at one sample, by damped Newton steps (Sugihara 2011).

    Args:
        cell: The cell.
        motion: Motion of the object.
        sample: Which sample; or one for each set of positions, Shape (T,).
        start: Positions to start from, Shape (T, m) [rad or m].
        steps: Most steps to take.
        reference: Positions that redundant arms stay near, Shape (T, m); None moves them no further than needed.

    Returns:
        Positions with the smallest error met; of those without, the most settled in the null space.
    """
    q, best_q = start.copy(), start.copy()
    count, robots = len(start), len(cell.robots)
    arms = list(zip(cell.robots, cell.joint_slices.values(), strict=True))
    best = np.full((count, robots), np.inf)
    parts = np.full((count, robots, 3), np.inf)
    for _ in range(steps):
        poses = cell.functions("kinematics", count, {"q": q})
        spaces = {} if reference is None else null_spaces(cell, q, poses["jacobian"], reference)
        step = np.zeros_like(q)
        for index, (robot, joints) in enumerate(arms):
            error, gap = pose_error(cell, robot, index, motion, sample, poses)
            arm_step, drift = _newton_step(poses["jacobian"][:, :, joints], error, spaces.get(robot.name))
            size = np.max(np.abs(gap), axis=1)
            if drift is not None:
                size = np.where(size <= POSE_TOLERANCE, POSE_TOLERANCE * np.tanh(drift), size)
            better = size < best[:, index]
            best[better, index], parts[better, index, :2] = size[better], gap[better]
            parts[better, index, 2] = 0.0 if drift is None else drift[better]
            best_q[better, joints] = q[better, joints]
            longest = np.max(np.abs(arm_step), axis=1, keepdims=True)
            step[:, joints] = arm_step * np.minimum(1.0, STEP_LIMIT / np.maximum(longest, STEP_LIMIT))
        if np.max(np.abs(step)) <= SETTLED:
            break
        q += step
    return HeldGrasps(best_q, parts[:, :, 0], parts[:, :, 1], parts[:, :, 2])


def _newton_step(J: Array, error: Array, space: NullSpace | None) -> tuple[Array, Array | None]:
    """The step towards a grasp, Shape (T, n_i); of a redundant arm also the size of its part in the null space."""
    damping = 0.5 * np.sum(error**2, axis=1)[:, None, None] * np.eye(J.shape[1])
    square = J @ J.transpose(0, 2, 1) + damping
    step = apply(J.transpose(0, 2, 1), _least_squares(square, error))
    if space is None:
        return step, None
    return space.solve(step, -space.gradient)


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
    if compiled is not None:
        found = track_path(compiled, grasp_task(cell, TRACKING_STEPS), path_of(motion), start)
        if found.done == len(motion.time) and not (
            np.any(np.maximum(found.gap, found.turn) > POSE_TOLERANCE)
            or np.any(found.jump > JUMP_LIMIT)
            or not np.all(found.condition < CONDITION_LIMIT)
            or np.any(found.drift > SETTLED_PREFERENCE)
            or not np.all(found.curvature > FOLD)
        ):
            return found.q, found.dq, found.ddq
    tracks = track_grasps(cell, motion, start[None])
    tracks.require(0)
    return tracks.q[0], tracks.dq[0], tracks.ddq[0]


def path_of(motion: ObjectMotion) -> tuple[Array, ...]:
    """What the compiled tracking is told of a motion."""
    return motion.time, motion.position, motion.rotation, motion.twist, motion.acceleration


def grasp_task(cell: Cell, steps: int) -> GraspTask:
    """What the compiled tracking is told of a cell; steps: most at a sample."""
    robots = cell.robots
    return GraspTask(
        newton=NewtonRule(steps, SETTLED, STEP_LIMIT, POSE_TOLERANCE, CONDITION_LIMIT),
        components=cell.wrench_rows,
        geometry=cell.geometry,
        lower=np.concatenate([robot.position_lower for robot in robots]),
        upper=np.concatenate([robot.position_upper for robot in robots]),
        zone=np.concatenate([limit_zone(robot) for robot in robots]),
        push=LIMIT_PUSH,
    )


def track_grasps(cell: Cell, motion: ObjectMotion, start: Array) -> Tracks:
    """Follow the grasps from given positions at t = 0, keeping each branch by continuity.

    An arm with more joints than wrench components stays near its start, away from its limits
    (`mrts.inverse_kinematics.null_space`).

    Args:
        cell: The cell.
        motion: Motion of the object.
        start: Positions at t = 0 that hold the grasps, Shape (T, m) [rad or m].
    """
    count, samples = len(start), len(motion.time)
    shape = (count, samples, start.shape[1])
    tracks = Tracks(np.zeros(shape), np.zeros(shape), np.zeros(shape), [_none_failed(cell) for _ in range(count)])
    rates = [tip_rates(cell, robot, motion) for robot in cell.robots]
    tracks.q[:, 0] = start
    _rates_at(cell, motion, 0, rates, tracks)
    for k in range(1, samples):
        h = motion.time[k] - motion.time[k - 1]
        q, dq, ddq = tracks.q[:, k - 1], tracks.dq[:, k - 1], tracks.ddq[:, k - 1]
        predicted = q + h * dq + h * h / 2 * ddq
        held = solve_grasps(cell, motion, k, predicted, TRACKING_STEPS, start)
        tracks.q[:, k] = held.q
        _note_failures(cell, motion, k, tracks, predicted, held)
        _rates_at(cell, motion, k, rates, tracks)
    _name_limits_first(cell, motion, tracks)
    return tracks


def _name_limits_first(cell: Cell, motion: ObjectMotion, tracks: Tracks) -> None:
    """A redundant arm between its limits fails soon after it passed one, which is then the reason."""
    for q, failures in zip(tracks.q, tracks.failures, strict=True):
        for robot, joints in zip(cell.robots, cell.joint_slices.values(), strict=True):
            failure = failures[robot.name]
            if failure is None or not is_redundant(cell, robot):
                continue
            beyond = joint_limit_failure(robot, motion.time, q[: failure.sample, joints])
            if beyond is not None:
                failures[robot.name] = TrackingFailure(PAST_A_LIMIT, beyond, failure.sample)


def _none_failed(cell: Cell) -> dict[str, TrackingFailure | None]:
    return {robot.name: None for robot in cell.robots}


def _rates_at(cell: Cell, motion: ObjectMotion, k: int, rates: list[tuple[Array, Array]], tracks: Tracks) -> None:
    """Velocities q' and accelerations q'' of all tracks at one sample; notes singular arms."""
    count, q = len(tracks.q), tracks.q[:, k]
    J_all = cell.functions("kinematics", count, {"q": q})["jacobian"]
    spaces = null_spaces(cell, q, J_all, tracks.q[:, 0])
    inverses = {}
    for robot, joints, (velocity, _) in zip(cell.robots, cell.joint_slices.values(), rates, strict=True):
        J, space = J_all[:, :, joints], spaces.get(robot.name)
        _note_singular(motion, k, tracks, robot, np.linalg.cond(J), space)
        inverses[robot.name] = np.linalg.pinv(J, rcond=SINGULAR) if space is None else space.inverse
        along = apply(inverses[robot.name], np.broadcast_to(velocity[k], (count, len(velocity[k]))))
        tracks.dq[:, k, joints] = along if space is None else space.solve(along, np.zeros_like(along))[0]
    dq = tracks.dq[:, k]
    bias = cell.functions("bias_acceleration", count, {"q": q, "dq": dq})["bias_acceleration"]
    bias = bias.reshape(count, len(cell.wrench_components), len(cell.robots))
    changes = change_along(cell, q, dq, spaces)
    for index, (robot, joints) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
        acceleration = np.broadcast_to(rates[index][1][k], (count, len(rates[index][1][k])))
        along = apply(inverses[robot.name], acceleration - bias[:, :, index])
        space = spaces.get(robot.name)
        tracks.ddq[:, k, joints] = along if space is None else space.solve(along, changes[robot.name])[0]


def _note_singular(
    motion: ObjectMotion, k: int, tracks: Tracks, robot: Robot, condition: Array, space: NullSpace | None
) -> None:
    for track in np.flatnonzero(~(condition < CONDITION_LIMIT)):
        tracks.failures[track][robot.name] = tracks.failures[track][robot.name] or TrackingFailure(
            SINGULAR_ARM,
            f"robot '{robot.name}' is singular at sample {k} (t = {motion.time[k]:.6g} s): the condition number of "
            f"its Jacobian is {condition[track]:.3g}, the limit is {CONDITION_LIMIT:.0e}. Keep the arm away from "
            "full stretch, full fold and aligned axes: move the path, the base or the grasp.",
            k,
        )
    for track in np.flatnonzero(~(space.curvature > FOLD)) if space is not None else ():
        tracks.failures[track][robot.name] = tracks.failures[track][robot.name] or _jump(robot, motion, k)


def _note_failures(
    cell: Cell, motion: ObjectMotion, k: int, tracks: Tracks, predicted: Array, held: HeldGrasps
) -> None:
    reached, settled = held.reached(), held.settled()
    for index, (robot, joints) in enumerate(zip(cell.robots, cell.joint_slices.values(), strict=True)):
        jump = np.max(np.abs(held.q[:, joints] - predicted[:, joints]), axis=1)
        for track, failures in enumerate(tracks.failures):
            if failures[robot.name] is not None:
                continue
            if not reached[track, index]:
                message = unreachable(robot, motion.time, k, held.gap[track, index], held.turn[track, index])
                failures[robot.name] = TrackingFailure(OUT_OF_REACH, message, k)
            elif not settled[track, index]:
                failures[robot.name] = _jump(robot, motion, k)
            elif jump[track] > JUMP_LIMIT:
                failures[robot.name] = TrackingFailure(LOST, branch_lost(robot, motion.time, k, jump[track]), k)


def _jump(robot: Robot, motion: ObjectMotion, k: int) -> TrackingFailure:
    return TrackingFailure(
        LOST,
        f"robot '{robot.name}' loses its branch at sample {k} (t = {motion.time[k]:.6g} s): of all joint positions "
        "that hold the grasp, those near its start and away from its limits end there, and it would have to jump. "
        "Choose another posture, or a path that keeps nearer to the start.",
        k,
    )


def pose_error(
    cell: Cell,
    robot: Robot,
    index: int,
    motion: ObjectMotion,
    sample: int | NDArray[np.intp],
    poses: dict[str, Array],
) -> tuple[Array, Array]:
    """Error in base axes and cell components, Shape (T, w), and its sizes [m, rad], Shape (T, 2).

    Args:
        cell: The cell.
        robot: Its arm.
        index: Of the arm.
        motion: Motion of the object.
        sample: Of the motion, or one for each of T.
        poses: What "kinematics" gives at T joint positions.
    """
    R_world_tip = motion.rotation[sample] @ robot.T_object_tip.R
    p_world_tip = motion.position[sample] + motion.rotation[sample] @ robot.T_object_tip.p
    positions = poses["position"].reshape(-1, 3, len(cell.robots))
    off = p_world_tip - positions[:, :, index]
    rotations = poses["rotation"][:, :, 3 * index : 3 * index + 3]
    turned = vectors_from_rotations(R_world_tip @ rotations.transpose(0, 2, 1))
    sizes = np.column_stack([np.linalg.norm(off, axis=1), np.linalg.norm(turned, axis=1)])
    R = robot.T_world_base.R
    return np.concatenate([off @ R, turned @ R], axis=1)[:, cell.wrench_rows], sizes


def _least_squares(square: Array, rhs: Array) -> Array:
    try:
        return np.asarray(np.linalg.solve(square, rhs[:, :, None])[:, :, 0], dtype=np.float64)
    except np.linalg.LinAlgError:
        return apply(np.linalg.pinv(square), rhs)
