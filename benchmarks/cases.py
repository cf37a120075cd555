# SPDX-License-Identifier: MIT
"""Cells and motions that several benchmarks ask about: the shipped ones at any number of samples, one arm, rings."""

from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import toppra
import yaml

import mrts
from mrts.base.arrays import Array
from mrts.following.coordinated_motion import carried_by_first

DATA = Path(str(files("mrts") / "data"))
DUAL = DATA / "dual_ur5"
MOTIONS = {"planar_dual_arm": "lift.yaml", "dual_ur5": "lift_and_turn.yaml"}
WAYPOINTS = 60


def shipped(name: str, samples: int, *, velocities: bool = False) -> tuple[mrts.Cell, mrts.CoordinatedMotion]:
    """A shipped cell and its motion with another number of samples.

    Args:
        name: Of its folder.
        samples: Of the motion.
        velocities: Whether it has its velocity limits, besides those of torques and contact wrenches.
    """
    cell = mrts.load_cell(DATA / name / "cell.yaml")
    cell = cell if velocities else cell.without_velocity_limits()
    description = yaml.safe_load((DATA / name / MOTIONS[name]).read_text(encoding="utf-8")) | {"samples": samples}
    given = mrts.load_motion(description)
    return cell, mrts.follow_object(cell, given)


def motion_file(folder: Path, samples: int) -> Path:
    """The dual cell's shipped motion with another number of samples, as a file."""
    description = yaml.safe_load((DUAL / MOTIONS["dual_ur5"]).read_text(encoding="utf-8")) | {"samples": samples}
    path = folder / f"motion{samples}.yaml"
    path.write_text(yaml.safe_dump(description), encoding="utf-8")
    return path


def one_arm(folder: Path) -> mrts.Cell:
    """The left arm of the dual cell with the box, torque limits only."""
    description = yaml.safe_load((DUAL / "cell.yaml").read_text(encoding="utf-8"))
    left = description["robots"][0] | {"urdf": str(DUAL / description["robots"][0]["urdf"])}
    path = folder / "one_arm.yaml"
    path.write_text(yaml.safe_dump(description | {"name": "one_ur5", "robots": [left]}), encoding="utf-8")
    return mrts.load_cell(path).without_wrench_limits().without_velocity_limits()


def model_with_box(cell: mrts.Cell) -> Any:
    """Pinocchio's model of that arm with the box welded to its hand, in base axes."""
    robot = cell.robots[0]
    model = pin.buildModelFromUrdf(str(DUAL / "ur5_class_arm.urdf"))
    model.gravity.linear = robot.T_world_base.R.T @ cell.gravity
    frame = model.frames[model.getFrameId("tool0")]
    tip_object = pin.SE3(robot.T_object_tip.R, robot.T_object_tip.p).inverse()
    box = pin.Inertia(cell.mass, np.zeros(3), cell.inertia)
    model.appendBodyToJoint(frame.parentJoint, box, frame.placement * tip_object)
    return model


def one_arm_path(cell: mrts.Cell) -> Any:
    """Toppra's cubic spline through joint positions of the shipped lift, over their arc length."""
    description = yaml.safe_load((DUAL / MOTIONS["dual_ur5"]).read_text(encoding="utf-8")) | {"samples": WAYPOINTS}
    q = mrts.follow_object(cell, mrts.load_motion(description)).q
    least = np.max(np.ptp(q, axis=0)) / WAYPOINTS / 4  # a spline wants waypoints that differ
    kept = q[np.concatenate([[True], np.linalg.norm(np.diff(q, axis=0), axis=1) > least])]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(kept, axis=0), axis=1))])
    return toppra.SplineInterpolator(way, kept)


def along(cell: mrts.Cell, path: Any, points: int) -> mrts.CoordinatedMotion:
    """The motion of one arm along such a path, its parameter for time, at evenly spaced points."""
    grid = np.linspace(*path.path_interval, points)
    return carried_by_first(cell, grid, path(grid), path(grid, 1), path(grid, 2))


def duration(grid: Array, x: Array) -> float:
    """Of a profile of speeds squared [s]."""
    speed = np.sqrt(np.maximum(x, 0.0))
    return float(np.sum(2 * np.diff(grid) / (speed[1:] + speed[:-1])))


def ring(folder: Path, arms: int) -> mrts.Cell:
    """The left arm of the dual cell, `arms` times around the object."""
    description = yaml.safe_load((DUAL / "cell.yaml").read_text(encoding="utf-8"))
    left = description["robots"][0] | {"urdf": str(DUAL / description["robots"][0]["urdf"])}
    centre = np.array([0.0, 0.1, 0.0])
    robots = []
    for index in range(arms):
        turn = pin.rpy.rpyToMatrix(0.0, 0.0, 2 * np.pi * index / arms)
        base = turn @ (np.array(left["base"]["xyz"]) - centre) + centre
        grasp = turn @ pin.rpy.rpyToMatrix(*map(float, left["grasp"]["rpy"]))
        rpy = pin.rpy.matrixToRpy(grasp).tolist()
        robots.append(left | {
            "name": f"arm{index}",
            "base": {"xyz": base.tolist(), "rpy": [0, 0, 2 * np.pi * index / arms]},
            "grasp": {"xyz": (turn @ np.array(left["grasp"]["xyz"])).tolist(), "rpy": rpy},
        })  # fmt: skip
    path = folder / f"ring{arms}.yaml"
    path.write_text(yaml.safe_dump(description | {"name": f"ring{arms}", "robots": robots}), encoding="utf-8")
    cell = mrts.load_cell(path)
    # one gripper cannot hold the box within the limits of two
    return cell if arms > 1 else cell.without_wrench_limits()


def straight_up(start: mrts.ObjectMotion, samples: int = 101) -> mrts.ObjectMotion:
    """Straight up by 50 mm from the start of a motion."""
    description = {"duration": 0.5, "samples": samples, "profile": "quintic"}
    x, y, z = start.position[0].tolist()
    ends = {"start": {"xyz": [x, y, z]}, "end": {"xyz": [x, y, z + 0.05]}}
    return mrts.load_motion(description | ends)


def stretched(motion: mrts.CoordinatedMotion, samples: int) -> mrts.CoordinatedMotion:
    """The same motion at more samples, each field interpolated: for timing, where an error of closure is no harm."""
    time_now = np.linspace(0, motion.object.time[-1], samples)

    def fields(values: Array) -> Array:
        flat = values.reshape(len(values), -1)
        columns = [np.interp(time_now, motion.object.time, column) for column in flat.T]
        return np.column_stack(columns).reshape(samples, *values.shape[1:])

    given = motion.object
    moved = object.__new__(mrts.ObjectMotion)
    for name in ("position", "rotation", "twist", "acceleration"):
        object.__setattr__(moved, name, fields(getattr(given, name)))
    object.__setattr__(moved, "time", time_now)
    return replace(motion, object=moved, q=fields(motion.q), dq=fields(motion.dq), ddq=fields(motion.ddq))
