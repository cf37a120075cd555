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


ARRAYS = {
    ("cell", "gravity"): "gravity",
    ("cell", "object", "mass"): "mass",
    ("cell", "object", "inertia"): "inertia",
    ("cell", "object", "velocity", "linear"): "object_velocity",
    ("cell", "object", "velocity", "angular"): "object_velocity",
    ("cell", "robots", "posture"): "posture",
    ("motion", "duration"): "duration",
}
ARRAYS |= {("cell", "robots", *name.split("_")): name for name in (*POSES, *LIMITS)}
ARRAYS |= {("motion", *name.split("_")): name for name in PATH_ENDS[:4]}
"""Array of a number by the keys on its way."""


@dataclass(frozen=True)
class Entry:
    """A place in an array, after V, that a parameter sets to offset + factor × its value."""

    column: int
    name: str
    index: tuple[int, ...]
    factor: float
    offset: float


def varied_entries(study: Study, cell: Cell) -> tuple[Entry, ...] | None:
    """The places that the parameters of a study set; None where one sets what has no array here."""
    entries: list[Entry] = []
    for column, parameter in enumerate(study.parameters):
        for target in parameter.targets:
            places = _places(target.keys, study, cell)
            if not places:
                return None
            entries += [
                Entry(column, name, at, sign * target.factor, sign * target.offset) for name, at, sign in places
            ]
    return tuple(entries)


def _places(keys: Keys, study: Study, cell: Cell) -> list[tuple[str, tuple[int, ...], float]]:
    """Arrays, indices and signs that a number of the files stands for; none where it has no array."""
    words = tuple(key for key in keys if isinstance(key, str))
    index = tuple(key for key in keys if isinstance(key, int))
    if words == ("cell", "robots", "torque"):  # without sides it is both
        sides = (_places((*keys[:4], side, *keys[4:]), study, cell) for side in ("lower", "upper"))
        return [(name, at, sign) for (sign, ((name, at, _),)) in zip((-1.0, 1.0), sides, strict=True)]
    name = ARRAYS.get(words, "")
    looks = words[2:3] == ("grasp",) and _looks(study.cell["robots"][index[0]])  # then each number turns the tip
    along = words[0] == "motion" and "waypoints" in study.motion
    scaled = name == "mass" and study.cell["object"].get("inertia") is None  # then it is that of the shape
    if not name or looks or along or scaled:
        return []
    if name == "posture" or name in LIMITS:
        slices = cell.wrench_slices if name.startswith("wrench") else cell.joint_slices
        robot, place = index
        index = (list(slices.values())[robot].start + place,)
    elif name == "inertia" and len(index) == 1:
        index *= 2
    elif name == "object_velocity":
        index = (("linear", "angular").index(words[-1]),)
    return [(name, index, 1.0)]


def base_numbers(study: Study, cell: Cell) -> dict[str, Array]:
    """The arrays of a study's own cell and motion, each with a first axis of one variant."""
    robots = cell.robots
    numbers = {
        "gravity": cell.gravity,
        "mass": np.float64(cell.mass),
        "inertia": cell.inertia,
        "object_velocity": cell.object_velocity_limit,
        "posture": cell.posture,
    }
    numbers |= {name: np.concatenate([getattr(robot, name) for robot in robots]) for name in LIMITS}
    for frame in ("base", "grasp"):
        poses = [robot.get(frame) or {} for robot in study.cell["robots"]]
        if frame == "grasp":
            placed = zip(poses, study.cell["robots"], robots, strict=True)
            poses = [
                {"xyz": pose.get("xyz"), "rpy": rpy_from_rotation(ours.T_object_tip.R)} if _looks(robot) else pose
                for pose, robot, ours in placed
            ]
        numbers |= {f"{frame}_{part}": _triples(poses, part) for part in ("xyz", "rpy")}
    if "duration" in study.motion and "waypoints" not in study.motion:
        numbers["duration"] = np.float64(study.motion["duration"])
        for pose in ("start", "end"):
            numbers |= {f"{pose}_{part}": _triples([study.motion.get(pose) or {}], part)[0] for part in ("xyz", "rpy")}
    return {name: np.array(value, dtype=np.float64)[None] for name, value in numbers.items()}


def _looks(robot: Mapping[str, Any]) -> bool:
    return (robot.get("grasp") or {}).get("look_at") is not None


def _triples(poses: Sequence[Mapping[str, Any]], part: str) -> Array:
    return np.array([pose.get(part) or [0.0, 0.0, 0.0] for pose in poses], dtype=np.float64)


def variant_numbers(base: Mapping[str, Array], entries: Sequence[Entry], points: Array) -> dict[str, Array]:
    """The arrays of V variants at points, Shape (V, P), each with V first, or 1 where all share that of `base`."""
    varied = {entry.name for entry in entries}
    numbers = {name: np.repeat(of, len(points), axis=0) if name in varied else of for name, of in base.items()}
    for entry in entries:
        place: tuple[slice | int, ...] = (slice(None), *entry.index)
        numbers[entry.name][place] = entry.offset + entry.factor * points[:, entry.column]
    return numbers


def geometries(numbers: Mapping[str, Array], varied: set[str], cell: Cell) -> Array:
    """`Cell.geometry` of variants, Shape (V, 3 + 24 n + h), or (1, …) where all share one."""
    if not (geometric := varied & {"gravity", *POSES}):
        return cell.geometry[None]
    V, n = max(len(numbers[name]) for name in geometric), len(cell.robots)
    whole = np.repeat(cell.geometry[None], V, axis=0)
    whole[:, :GRAVITY_SIZE] = numbers["gravity"]
    arms = whole[:, GRAVITY_SIZE : GRAVITY_SIZE + ROBOT_SIZE * n].reshape(V, n, 2, ROBOT_SIZE // 2)
    for place, frame in enumerate(("base", "grasp")):
        rotation = rotations_from_rpy(numbers[f"{frame}_rpy"])
        arms[:, :, place, :9] = rotation.reshape(*rotation.shape[:2], 9)
        arms[:, :, place, 9:] = numbers[f"{frame}_xyz"]
    whole[:, GRAVITY_SIZE : GRAVITY_SIZE + ROBOT_SIZE * n] = arms.reshape(V, -1)
    return whole


def load_vectors(numbers: Mapping[str, Array]) -> Array:
    """Load vectors (`mrts.base.manifest.LOAD_ENTRIES`) of variants, Shape (V, 10)."""
    inertia = numbers["inertia"]
    moments = [inertia[:, row, column] for row, column in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    return np.stack(np.broadcast_arrays(numbers["mass"], *[np.zeros(1)] * 3, *moments), axis=1)


def doubtful(numbers: Mapping[str, Array], varied: set[str]) -> NDArray[np.bool_]:
    """Which variants a rule of the cell file or the motion file may refuse, for what is varied, Shape (V,) or (1,)."""
    doubt = np.zeros(1, dtype=bool)
    for name in varied:
        values = numbers[name].reshape(len(numbers[name]), -1)
        largest = LARGEST_ANGLE if name.endswith(("rpy", "posture")) else LARGEST
        bounded = values[:, np.isfinite(values[0])] if name in {*LIMITS, "object_velocity"} else values
        doubt = doubt | ~np.all(np.abs(bounded) <= largest, axis=1)
        if name in {"mass", "duration", "object_velocity"}:
            doubt = doubt | ~np.all(values >= SMALLEST, axis=1)
    if not varied.isdisjoint(LIMITS):
        torque_lower, torque_upper, wrench_lower, wrench_upper = (numbers[name] for name in LIMITS)
        doubt = doubt | ~np.all(torque_lower < torque_upper, axis=1) | ~np.all(wrench_lower <= wrench_upper, axis=1)
    return doubt | ~_of_a_body(numbers["inertia"]) if "inertia" in varied else doubt


def _of_a_body(inertia: Array) -> NDArray[np.bool_]:
    """Which inertias are surely those of a body (`mrts_codegen.cell_file.inertia_problem`), Shape (V,)."""
    moments = np.linalg.eigvalsh(inertia)
    symmetric = np.all(inertia == inertia.transpose(0, 2, 1), axis=(1, 2))
    sound: NDArray[np.bool_] = symmetric & (moments[:, 0] > NEAR_A_RULE * moments[:, 2])
    return sound & (moments[:, 2] <= (moments[:, 0] + moments[:, 1]) * (1 + NEAR_A_RULE))
