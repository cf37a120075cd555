# SPDX-License-Identifier: MIT
"""The numbers of many variants of a cell and a motion as arrays: what their files say, put together for all at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.base.rigid_transform import rotations_from_rpy, rpy_from_rotation
from mrts.cell.cell import Cell
from mrts.cell.number_paths import Keys
from mrts.cell.robot import Robot
from mrts.studies.parameters import Target
from mrts.studies.study import Study

LARGEST, LARGEST_ANGLE = 1e6, 1e3
"""Numbers [m, kg, N, N m, s] and angles [rad] beyond these are left to the rules of the files."""

SMALLEST = 1e-6
"""The same for masses, durations and speeds below it [kg, s, m/s, rad/s]."""

NEAR_A_RULE = 1e-10
"""A number this close to what a rule of the files refuses is left to it: a share, or the entry of a rotation."""

LIMITS = ("torque_lower", "torque_upper", "wrench_lower", "wrench_upper")
"""Limits of all joints, Shape (V, m), and of all wrenches, Shape (V, n w)."""

POSES = ("base_xyz", "base_rpy", "grasp_xyz", "grasp_rpy")
"""Of all robots, Shape (V, n, 3)."""

PATH_ENDS = ("start_xyz", "start_rpy", "end_xyz", "end_rpy", "duration")
"""Of a motion from pose to pose, Shape (V, 3), and (V,)."""


@dataclass(frozen=True)
class Entry:
    """A place in an array that a parameter sets.

    Attributes:
        column: Of the parameter.
        name: Of the array.
        index: In it, after V.
        factor: What a unit of the parameter adds.
        offset: What stands there at zero.
    """

    column: int
    name: str
    index: tuple[int, ...]
    factor: float
    offset: float


def varied_entries(study: Study, cell: Cell) -> tuple[Entry, ...] | None:
    """The places that the parameters of a study set; None where one sets what has no array here."""
    targets = [(target, column) for column, each in enumerate(study.parameters) for target in each.targets]
    entries = [target_entries(target, column, study, cell) for target, column in targets]
    return tuple(entry for places in entries for entry in places) if all(entries) else None


def target_entries(target: Target, column: int, study: Study, cell: Cell) -> list[Entry]:
    """The places that a target of a parameter sets; none where it has no array here."""
    places = _places(target.keys, study, cell)
    return [Entry(column, name, index, sign * target.factor, sign * target.offset) for name, index, sign in places]


def _places(keys: Keys, study: Study, cell: Cell) -> list[tuple[str, tuple[int, ...], float]]:
    """Arrays, indices and signs that a number of the files stands for; none where it has no array."""
    found: tuple[str, tuple[int, ...]] | None = None
    match keys:
        case ("cell", "robots", int(robot), "posture" | "torque" | "wrench", *_):
            return _places_of_limits(keys[3:], cell, robot)
        case ("cell", "robots", int(robot), "base" | "grasp" as frame, "xyz" | "rpy" as part, int(axis)):
            looks = frame == "grasp" and _looks(study.cell["robots"][robot])  # then each number turns the tip
            found = None if looks else (f"{frame}_{part}", (robot, axis))
        case ("cell", "gravity", int(axis)):
            found = "gravity", (axis,)
        case ("cell", "object", "mass") if study.cell["object"].get("inertia") is not None:
            found = "mass", ()
        case ("cell", "object", "inertia", int(axis)):
            found = "inertia", (axis, axis)
        case ("cell", "object", "inertia", int(row), int(column)):
            found = "inertia", (row, column)
        case ("cell", "object", "velocity", "linear" | "angular" as part):
            found = "object_velocity", (("linear", "angular").index(part),)
        case ("motion", "start" | "end" as pose, "xyz" | "rpy" as part, int(axis)) if "waypoints" not in study.motion:
            found = f"{pose}_{part}", (axis,)
        case ("motion", "duration") if "waypoints" not in study.motion:
            found = "duration", ()
    return [] if found is None else [(*found, 1.0)]


def _places_of_limits(rest: Sequence[str | int], cell: Cell, robot: int) -> list[tuple[str, tuple[int, ...], float]]:
    """The same of a robot's posture and limits; a torque limit without sides is both."""
    name = cell.robots[robot].name
    joint, component = cell.joint_slices[name].start, cell.wrench_slices[name].start
    match rest:
        case ("posture", int(place)):
            return [("posture", (joint + place,), 1.0)]
        case ("torque", int(place)):
            return [("torque_upper", (joint + place,), 1.0), ("torque_lower", (joint + place,), -1.0)]
        case ("torque", "lower" | "upper" as side, int(place)):
            return [(f"torque_{side}", (joint + place,), 1.0)]
        case ("wrench", "lower" | "upper" as side, int(place)):
            return [(f"wrench_{side}", (component + place,), 1.0)]
    return []


def base_numbers(study: Study, cell: Cell) -> dict[str, Array]:
    """The arrays of a study's own cell and motion, each with a first axis of one variant."""
    robots = cell.robots
    numbers = {
        "gravity": cell.gravity,
        "mass": np.float64(cell.mass),
        "inertia": cell.inertia,
        "object_velocity": cell.object_velocity_limit,
        "posture": np.concatenate([robot.posture for robot in robots]),
    }
    numbers |= {name: np.concatenate([getattr(robot, name) for robot in robots]) for name in LIMITS}
    for frame in ("base", "grasp"):
        poses = [robot.get(frame) or {} for robot in study.cell["robots"]]
        if frame == "grasp":
            placed = zip(poses, study.cell["robots"], robots, strict=True)
            poses = [_with_angles(pose, ours) if _looks(robot) else pose for pose, robot, ours in placed]
        numbers |= {f"{frame}_{part}": _triples(poses, part) for part in ("xyz", "rpy")}
    if "duration" in study.motion and "waypoints" not in study.motion:
        numbers["duration"] = np.float64(study.motion["duration"])
        for pose in ("start", "end"):
            numbers |= {f"{pose}_{part}": _triples([study.motion.get(pose) or {}], part)[0] for part in ("xyz", "rpy")}
    return {name: np.array(value, dtype=np.float64)[None] for name, value in numbers.items()}


def _looks(robot: Mapping[str, Any]) -> bool:
    return (robot.get("grasp") or {}).get("look_at") is not None


def _with_angles(pose: Mapping[str, Any], robot: Robot) -> dict[str, Any]:
    return {"xyz": pose.get("xyz"), "rpy": rpy_from_rotation(robot.T_object_tip.R)}


def _triples(poses: Sequence[Mapping[str, Any]], part: str) -> Array:
    return np.array([pose.get(part) or [0.0, 0.0, 0.0] for pose in poses], dtype=np.float64)


class VariantNumbers:
    """The arrays of V variants by name, each with V first, or 1 where all share one.

    Args:
        base: As from `base_numbers`.
        entries: What is varied of them.
        points: Values of the parameters, Shape (V, P).

    Attributes:
        count: V.
        varied: Names of the arrays that differ.
    """

    def __init__(self, base: Mapping[str, Array], entries: Sequence[Entry], points: Array) -> None:
        self.count, self.varied = len(points), frozenset(entry.name for entry in entries)
        self._arrays = dict(base)
        for name in self.varied:
            self._arrays[name] = np.repeat(base[name], self.count, axis=0)
        for entry in entries:
            number = entry.offset + entry.factor * points[:, entry.column]
            of_all: tuple[slice | int, ...] = (slice(None), *entry.index)
            self._arrays[entry.name][of_all] = number

    def __getitem__(self, name: str) -> Array:
        return self._arrays[name]

    def any_of(self, names: Sequence[str]) -> bool:
        """Whether one of these arrays differs between variants."""
        return not self.varied.isdisjoint(names)

    def geometry(self, cell: Cell) -> Array:
        """As `Cell.geometry`, Shape (V, 3 + 24 n + h)."""
        if not self.any_of(("gravity", *POSES)):
            return cell.geometry[None]
        V, robots = self.count, len(cell.robots)
        whole = np.repeat(cell.geometry[None], V, axis=0)
        whole[:, :GRAVITY_SIZE] = self["gravity"]
        arms = whole[:, GRAVITY_SIZE : GRAVITY_SIZE + ROBOT_SIZE * robots].reshape(V, robots, 2, ROBOT_SIZE // 2)
        for place, frame in enumerate(("base", "grasp")):
            rotation, position = rotations_from_rpy(self[f"{frame}_rpy"]), self[f"{frame}_xyz"]
            arms[:, :, place, :9] = rotation.reshape(*rotation.shape[:2], 9)
            arms[:, :, place, 9:] = position
        whole[:, GRAVITY_SIZE : GRAVITY_SIZE + ROBOT_SIZE * robots] = arms.reshape(V, -1)
        return whole

    def loads(self) -> Array:
        """Load vectors (`mrts.base.manifest.LOAD_ENTRIES`), Shape (V, 10)."""
        mass, inertia = self["mass"], self["inertia"]
        places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        moments = [inertia[:, row, column] for row, column in places]
        return np.stack(np.broadcast_arrays(mass, *[np.zeros(1)] * 3, *moments), axis=1)

    def doubtful(self) -> NDArray[np.bool_]:
        """Variants that a rule of the cell file or the motion file may refuse, Shape (V,)."""
        return np.broadcast_to(self._breaks_a_rule(), (self.count,)).copy()

    def _breaks_a_rule(self) -> NDArray[np.bool_]:
        doubt = np.zeros(1, dtype=bool)
        for name in self.varied:
            values = self[name].reshape(len(self[name]), -1)
            largest = LARGEST_ANGLE if name.endswith(("rpy", "posture")) else LARGEST
            bounded = values[:, np.isfinite(values[0])] if name in {*LIMITS, "object_velocity"} else values
            doubt = doubt | ~np.all(np.abs(bounded) <= largest, axis=1)
        for name in {"mass", "duration", "object_velocity"} & self.varied:
            doubt = doubt | ~np.all(self[name].reshape(self.count, -1) >= SMALLEST, axis=1)
        if self.any_of(LIMITS):
            low, high = self["torque_lower"], self["torque_upper"]
            doubt = doubt | ~np.all(low < high, axis=1) | ~np.all(self["wrench_lower"] <= self["wrench_upper"], axis=1)
        if "inertia" in self.varied:
            doubt = doubt | ~_of_a_body(self["inertia"])
        return doubt


def _of_a_body(inertia: Array) -> NDArray[np.bool_]:
    """Which inertias are surely those of a body (`mrts_codegen.cell_file.inertia_problem`), Shape (V,)."""
    moments = np.linalg.eigvalsh(inertia)
    symmetric = np.all(inertia == inertia.transpose(0, 2, 1), axis=(1, 2))
    sound: NDArray[np.bool_] = symmetric & (moments[:, 0] > NEAR_A_RULE * moments[:, 2])
    return sound & (moments[:, 2] <= (moments[:, 0] + moments[:, 1]) * (1 + NEAR_A_RULE))
