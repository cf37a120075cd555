# SPDX-License-Identifier: MIT
"""Joint positions at t = 0, near the robots' postures."""

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import MotionError
from mrts.base.remark import Remark
from mrts.cell.cell import Cell
from mrts.cell.robot import Robot
from mrts.inverse_kinematics.grasp_tracking import (
    STARTING_STEPS,
    HeldGrasps,
    grasp_task,
    path_of,
    solve_grasps,
)
from mrts.inverse_kinematics.joint_limits import joint_limit_failure, nearest_turns, within_limits
from mrts.inverse_kinematics.planar_closed_form import has_closed_form, planar_branches
from mrts.inverse_kinematics.reach import ArmPlaces, arm_reach
from mrts.inverse_kinematics.tracking_messages import unreachable
from mrts.kernel.tracking import track_path
from mrts.motion.object_motion import ObjectMotion

FURTHER_STARTS = 40
"""Starts tried where the posture leads to nothing: an arm of six joints has up to 16 branches."""

FURTHER_STEPS = 60
"""Steps from each of them; those that take more lead nowhere."""

STARTS_TRIED = f"{1 + FURTHER_STARTS} starts were tried."

SEED = 13

SPREAD = 2.0
"""The further starts reach from the posture to this far from it in every joint, evenly [rad or m]."""


def starting_positions(cell: Cell, motion: ObjectMotion) -> tuple[Array, tuple[Remark, ...]]:
    """Joint positions that hold the grasps at t = 0 near the robots' postures, Shape (m,) [rad or m], and remarks.

    Where an arm cannot reach its grasp from its posture, or only past its limits, further starts are tried, always the
    same: the middle of its limits, and random ones farther and farther from the posture. Of what they lead to inside
    the limits the arm takes the nearest to its posture.

    Args:
        cell: The cell.
        motion: Motion of the object.

    Raises:
        MotionError: If an arm reaches its grasp from none of them.
    """
    start = np.concatenate([robot.posture for robot in cell.robots])
    reference = starting_reference(cell)
    for robot, joints in zip(cell.robots, cell.joint_slices.values(), strict=True):
        if has_closed_form(cell, robot):
            near = [nearest_turns(robot, branch[0]) for branch in planar_branches(cell, robot, motion)]
            start[joints] = min(near, key=lambda q: float(np.max(np.abs(q - robot.posture))))
    held = _hold_first(cell, motion, start) if np.array_equal(start, reference) else None
    if held is None:
        _require_reach(cell, motion)
        held = solve_grasps(cell, motion, 0, start[None], STARTING_STEPS, reference[None])
    found: Array = held.q[0].copy()
    lost = [index for index in range(len(cell.robots)) if not _holds(cell, motion, held, index)[0]]
    if lost:
        starts = np.concatenate([further_starts(robot, robot.posture) for robot in cell.robots], axis=1)
        further = solve_grasps(cell, motion, 0, starts, FURTHER_STEPS, np.tile(reference, (len(starts), 1)))
        for index in lost:
            joints = cell.joint_slices[cell.robots[index].name]
            found[joints] = _nearest(cell, motion, held, further, index)
    return found, tuple(_other_start(cell.robots[index]) for index in lost)


def _require_reach(cell: Cell, motion: ObjectMotion) -> None:
    """Refuse a grasp at t = 0 that is farther away than an arm's links reach, before anything is searched.

    Raises:
        MotionError: Names the arm and what is missing.
    """
    for robot in cell.robots:
        reach, base, grasp = arm_reach(robot), robot.T_world_base, robot.T_object_tip
        if reach is None:
            continue
        places = ArmPlaces(base.R, base.p, grasp.R, grasp.p)
        distance = reach.distance(places, motion.position[0], motion.rotation[0])
        if reach.beyond(distance):
            raise MotionError(reach.failure(robot, motion.time, float(distance)))


def _hold_first(cell: Cell, motion: ObjectMotion, start: Array) -> HeldGrasps | None:
    """`solve_grasps` at t = 0, near the start, in the compiled library; None where that settles nothing."""
    compiled = cell.functions.compiled
    if compiled is None:
        return None
    found = track_path(compiled, grasp_task(cell, STARTING_STEPS), [part[:1] for part in path_of(motion)], start)
    held = HeldGrasps(found.q, found.gap, found.turn, found.drift)
    return held if found.done and np.all(held.settled()) else None


def _other_start(robot: Robot) -> Remark:
    return Remark(
        "other-start",
        f"robot '{robot.name}' does not reach its grasp at t = 0 from its posture inside its joint limits: it starts "
        f"at the nearest positions that {FURTHER_STARTS} further starts led to.",
        0,
    )


def starting_reference(cell: Cell) -> Array:
    """The postures of all arms, moved inside their limits where they are not, Shape (m,) [rad or m]."""
    inside = [np.clip(robot.posture, robot.position_lower, robot.position_upper) for robot in cell.robots]
    return np.concatenate(inside)


def _holds(cell: Cell, motion: ObjectMotion, held: HeldGrasps, index: int) -> list[bool]:
    """Whether an arm holds its grasp inside its limits, whole turns aside, by start."""
    robot = cell.robots[index]
    q = held.q[:, cell.joint_slices[robot.name]]
    return [
        bool(reached) and joint_limit_failure(robot, motion.time, within_limits(robot, at[None])) is None
        for reached, at in zip(held.reached()[:, index], q, strict=True)
    ]


def further_starts(robot: Robot, posture: Array) -> Array:
    """Where the search goes on from, Shape (…, FURTHER_STARTS, n_i).

    Args:
        robot: The arm.
        posture: Shape (…, n_i) [rad or m].
    """
    low, high = robot.position_lower, robot.position_upper
    steps = np.linspace(0, SPREAD, FURTHER_STARTS)[:, None]
    turns = np.random.default_rng(SEED).uniform(-1, 1, (FURTHER_STARTS, len(robot.joints)))
    starts: Array = np.clip(posture[..., None, :] + steps * turns, low, high)
    limited = np.isfinite(low) & np.isfinite(high)
    starts[..., 0, limited] = (low[limited] + high[limited]) / 2
    return starts


def _nearest(cell: Cell, motion: ObjectMotion, held: HeldGrasps, further: HeldGrasps, index: int) -> Array:
    """What the further starts led to nearest to the posture of one arm.

    Raises:
        MotionError: If none holds the grasp: what is wrong with the nearest miss, and how many starts were tried.
    """
    robot = cell.robots[index]
    joints = cell.joint_slices[robot.name]
    found = zip(further.q[:, joints], _holds(cell, motion, further, index), strict=True)
    good = [within_limits(robot, nearest_turns(robot, q)[None])[0] for q, holds in found if holds]
    if good:
        return min(good, key=lambda q: float(np.max(np.abs(q - robot.posture))))
    q, gap, turn, reached = (
        np.concatenate(pair) for pair in zip(_parts(held, index), _parts(further, index), strict=True)
    )
    failure: str | None = None
    if np.any(reached):
        failure = joint_limit_failure(
            robot, motion.time, within_limits(robot, q[int(np.argmax(reached))][None, joints])
        )
    best = int(np.argmin(np.maximum(gap, turn)))
    failure = failure or unreachable(robot, motion.time, 0, float(gap[best]), float(turn[best]))
    raise MotionError(f"{failure} {STARTS_TRIED}")


def _parts(held: HeldGrasps, index: int) -> tuple[Array, Array, Array, Array]:
    return held.q, held.gap[:, index], held.turn[:, index], held.reached()[:, index].astype(float)
