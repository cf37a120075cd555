# SPDX-License-Identifier: MIT
"""Many variants of one cell solved at once, in native calls: start poses, joints, ranges of c²."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import MrtsError
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.base.rigid_transform import rotations_from_rpy, rpy_from_rotation
from mrts.cell.cell import Cell
from mrts.cell.number_paths import Keys
from mrts.following.coordinated_motion import CoordinatedMotion, leaves_plane
from mrts.following.tracking import TrackedVariants, track_variants
from mrts.kernel.programs import INFEASIBLE, OPTIMAL
from mrts.kernel.tracking import PATH, REFUSED
from mrts.kernel.variants import variant_ranges
from mrts.limits import limit_rows
from mrts.limits.cell_limits import torque_limits, velocity_limits, wrench_limits
from mrts.limits.rows import ActiveRow, kernel_limits
from mrts.motion.object_courses import geodesic_rates
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.velocity_profile import PROFILES
from mrts.program.motion_rows import binds, largest_square, side_share
from mrts.program.range_status import RangeStatus
from mrts.program.sample_ranges import POINT_TOLERANCE
from mrts.scaling.range import RangeEnd, contradiction
from mrts.studies.study import Study, StudyQuestion
from mrts.studies.variant_rows import UNREACHABLE, Columns, Row, columns_of, ends_row, solved_row

BLOCK_BYTES = 8_000_000
"""Of the arrays of the variants that one native call solves: small enough to stay near the processor."""

RATES = ("twist", "acceleration")
"""Of the object."""

KEPT = 4
"""Studies whose cells are kept ready."""

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
    """Which inertias are surely those of a body (`mrts.cell.cell_file.inertia_problem`), Shape (V,)."""
    moments = np.linalg.eigvalsh(inertia)
    symmetric = np.all(inertia == inertia.transpose(0, 2, 1), axis=(1, 2))
    sound: NDArray[np.bool_] = symmetric & (moments[:, 0] > NEAR_A_RULE * moments[:, 2])
    return sound & (moments[:, 2] <= (moments[:, 0] + moments[:, 1]) * (1 + NEAR_A_RULE))


@lru_cache(maxsize=KEPT)
def batch_for(study: Study) -> "VariantBatch | None":
    """What solves the variants of a study at once; None where they take more than that.

    Covered are ranges of a constant factor at the samples, for a known load and a free distribution of it, on a path
    from pose to pose or one that does not vary, with varied poses, gravity, object, postures, duration, and limits of
    torques, wrenches and the object's velocity; of two arms or more whose motors are ideal, without limits of points
    and things on the object. Arms of a planar cell, and hands with contacts that are limited in axes of the tip, must
    not turn.
    """
    question = study.question
    asked = question == StudyQuestion(load=question.load, reserve=question.reserve)
    if not asked or study.limits:
        return None
    here = study.at_hand()
    try:
        cell, motion = here.cell_of(here.cell), here.motion_of(here.motion)
    except MrtsError:  # of the study's own numbers, which it may vary
        return None
    known = question.load == "nominal" or (question.load == "auto" and cell.load_box is None)
    entries = varied_entries(study, cell)
    if not known or entries is None or len(cell.robots) == 1 or not _covers(cell, entries):
        return None
    return VariantBatch(here, cell, motion, entries) if isinstance(motion, ObjectMotion) else None


def _covers(cell: Cell, entries: Sequence[Entry]) -> bool:
    names = {entry.name for entry in entries}
    motors = [robot.motors for robot in cell.robots]
    curves = [curve for each in motors for curve in each.torque_speed if curve is not None]
    ideal = not curves and not any(each.has_effect for each in motors)
    turned_in_tip = "grasp_rpy" in names and any(of.frame == "tip" for robot in cell.robots for of in robot.contacts)
    bounds = [(robot.wrench_lower, robot.wrench_upper) for robot in cell.robots]
    free = np.concatenate([np.isinf(lower) & np.isinf(upper) for lower, upper in bounds])
    limited = {entry.index[0] for entry in entries if entry.name.startswith("wrench")}
    has_rows = not np.any(free[list(limited)])  # a limit on what the cell leaves free is a row more than it has
    may_tilt = cell.plane is not None and not names.isdisjoint({"base_rpy", "grasp_rpy"})
    of_points = cell.object_points or cell.carried or any(robot.point_limits for robot in cell.robots)
    return ideal and not of_points and has_rows and not turned_in_tip and not may_tilt


class VariantBatch:
    """Variants of an unvaried cell and motion, in which entries differ, solved at once."""

    def __init__(self, study: Study, cell: Cell, motion: ObjectMotion, entries: Sequence[Entry]) -> None:
        self._study, self._cell, self._motion, self._entries = study, cell, motion, entries
        self._reserve = cell.reserve if study.question.reserve is None else study.question.reserve
        self._base = base_numbers(study, cell)
        m = len(cell.joint_names)
        still = np.zeros((len(motion.time), m))
        at_rest = CoordinatedMotion(motion, still, still, still)
        given = limit_rows(cell.with_reserve(0.0), at_rest)
        alone = {"velocity", "acceleration"}  # these bound c² by themselves
        self.rows = given.only(np.array([name.kind not in alone for name in given.names], dtype=bool))
        self._caps = velocity_limits(replace(cell, enforces_velocity_limits=True), at_rest).names
        self._accelerations = np.concatenate(
            [[robot.acceleration_lower, robot.acceleration_upper] for robot in cell.robots], axis=1
        )
        self._caps += tuple(replace(name, kind="acceleration", unit=f"{name.unit}²") for name in self._caps)
        every = {"torque": torque_limits(cell, at_rest).names, "wrench": wrench_limits(cell, at_rest).names}
        self._places = {}  # of rows in `rows`, and in the arrays of all limits
        for kind, names in every.items():
            rows = [row for row, name in enumerate(self.rows.names) if name.kind == kind]
            self._places[kind] = rows, [names.index(self.rows.names[row]) for row in rows]
        self._sparse, matrix = kernel_limits(cell, self.rows), self.rows.matrix
        self._values = matrix[np.nonzero(matrix)]
        self._varied = {entry.name for entry in entries}
        each = len(motion.time) * (3 * m + (0 if self._varied.isdisjoint(PATH_ENDS) else 25)) * 8
        self.block = max(1, BLOCK_BYTES // each)

    def solve(self, points: Array, first: int) -> Columns:
        """The rows of variants at points, Shape (V, P), from a first number, as `solve_variants` gives them."""
        rows: list[Row] = []
        for start in range(0, len(points), self.block):
            part = points[start : start + self.block]
            with np.errstate(all="ignore"):  # of numbers that break a rule, which are left to `solved_row`
                settled = self._rows(*self._answers(variant_numbers(self._base, self._entries, part), len(part)))
            rows += [
                solved_row(self._study, point) if row is None else row for point, row in zip(part, settled, strict=True)
            ]
        return columns_of(self._study, points, first, rows)

    def _answers(
        self, numbers: Mapping[str, Array], count: int
    ) -> tuple[dict[str, Array], TrackedVariants, NDArray[np.void]]:
        """What the native calls take, by name, with V or 1 first, and what they give."""
        refused = np.broadcast_to(doubtful(numbers, self._varied), (count,)).copy()
        geometry, path = geometries(numbers, self._varied, self._cell), self._path(numbers, refused)
        if self._cell.plane is not None:
            refused |= leaves_plane(self._cell, path["twist"])
        tracked = track_variants(self._cell, path, geometry, numbers["posture"], refused)
        joints = tracked.q, tracked.dq, tracked.ddq
        given = {**path, "geometry": geometry, "load": load_vectors(numbers), **self._limits(numbers)}
        given["cap_share"] = self._cap_shares(given, tracked)
        asked = given | {"most": largest_square(given["cap_share"])}
        found = variant_ranges(self._cell.library, joints, ~tracked.followed, self._sparse, asked)
        return given, tracked, found

    def _cap_shares(self, given: Mapping[str, Array], tracked: TrackedVariants) -> Array:
        """What velocities and accelerations are of their limits in ṙ² at ṙ = 1, Shape (V, N, 2 m + 4)."""
        shape = (*tracked.q.shape[:2], 2)
        sizes = [np.linalg.norm(given[name].reshape(*given[name].shape[:2], 2, 3), axis=3) for name in RATES]
        speeds, accelerations = (np.broadcast_to(size, shape) for size in sizes)
        velocity = np.concatenate([np.abs(tracked.dq), speeds], axis=2) / given["velocity"][:, None]
        least = 1 - self._reserve
        joints = side_share(tracked.ddq, *(least * self._accelerations))
        return np.concatenate(
            [velocity**2, joints, accelerations / (least * self._cell.object_acceleration_limit)], axis=2
        )

    def _path(self, numbers: Mapping[str, Array], refused: NDArray[np.bool_]) -> dict[str, Array]:
        """The motion of the object, as `mrts.kernel.tracking.PATH` with V or 1 first; refused ones last a second."""
        if self._varied.isdisjoint(PATH_ENDS):
            return {name: getattr(self._motion, name)[None] for name in PATH}
        u = np.linspace(0.0, 1.0, len(self._motion.time))
        start, end, turned, turning, duration = (
            np.broadcast_to(numbers[name], (len(refused), *numbers[name].shape[1:]))
            for name in ("start_xyz", "end_xyz", "start_rpy", "end_rpy", "duration")
        )
        duration = np.where(refused, 1.0, duration)
        positions, rotations = np.stack([start, end], axis=1), rotations_from_rpy(np.stack([turned, turning], axis=1))
        profile = PROFILES[self._study.motion["profile"]]
        rates = geodesic_rates(positions, rotations, duration, profile(u))
        return dict(zip(PATH, (duration[:, None] * u, *rates), strict=True))

    def _limits(self, numbers: Mapping[str, Array]) -> dict[str, Array]:
        """The sides "lower" and "upper", "velocity" and "values" of V variants, as `variant_ranges` takes them."""
        sides = {"lower": self.rows.lower[None], "upper": self.rows.upper[None]}
        if not self._varied.isdisjoint(LIMITS):
            count = max(len(numbers[name]) for name in LIMITS)
            sides = {side: np.repeat(limits, count, axis=0) for side, limits in sides.items()}
            for kind, (rows, places) in self._places.items():
                for side, limits in sides.items():
                    limits[:, rows] = numbers[f"{kind}_{side}"][:, places]
        joints = self._cell.stacked("velocity_limit")
        of_object = numbers["object_velocity"]
        velocity = np.column_stack([np.repeat(joints[None], len(of_object), axis=0), of_object])
        if not self._cell.enforces_velocity_limits:
            velocity = np.full_like(velocity, np.inf)
        if self._reserve:
            pairs = zip(sides["lower"], sides["upper"], strict=True)
            shrunk = [replace(self.rows, lower=low, upper=high).shrunk(self._reserve) for low, high in pairs]
            sides = {side: np.array([getattr(rows, side) for rows in shrunk]) for side in sides}
            velocity = (1 - self._reserve) * velocity
        return {**sides, "velocity": velocity, "values": self._values[None]}

    def _rows(
        self, given: Mapping[str, Array], tracked: TrackedVariants, found: NDArray[np.void]
    ) -> Iterator[Row | None]:
        """The row of each variant, without its number and its parameters; None where it is not settled."""
        velocities = self._binding_caps(given, tracked, found)
        for variant, record in enumerate(found):
            failure, status = tracked.failure(variant), int(record["status"])
            if failure is not None:
                yield {"status": UNREACHABLE, "reason": failure.message}
            elif tracked.outcome[variant, 0]["code"] == REFUSED or status not in {INFEASIBLE, OPTIMAL}:
                yield None
            else:
                time, *sides = (given[name][variant % len(given[name])] for name in ("time", "lower", "upper"))
                bound = [self._named(record["rows"][end, : record["count"][end]], *sides) for end in (0, 1)]
                bound[1] += velocities.get(variant, [])
                yield _range_row(record, time, bound) if status == OPTIMAL else _infeasible_row(record, time, bound[0])

    def _named(self, codes: Array, lower: Array, upper: Array) -> list[ActiveRow]:
        """Rows at their limits, by codes: 1 + row at an upper, -1 - row at a lower limit."""
        rows = [(abs(code) - 1, code > 0) for code in codes.tolist()]
        sides = lower.tolist(), upper.tolist()
        return [ActiveRow.of(self.rows.names[at], *(side[at] for side in sides), at_upper=up) for at, up in rows]

    def _binding_caps(
        self, given: Mapping[str, Array], tracked: TrackedVariants, found: NDArray[np.void]
    ) -> dict[int, list[ActiveRow]]:
        """The velocities and accelerations that bound c² the most, by variant, where one does."""
        capped = np.flatnonzero(tracked.followed & (found["status"] == OPTIMAL) & (found["capped"] != 0))
        sample, m = found["sample"][capped, 1], tracked.q.shape[2]
        least, most = (1 - self._reserve) * self._accelerations
        of_object = (1 - self._reserve) * self._cell.object_acceleration_limit
        rows: dict[int, list[ActiveRow]] = {}
        for place, cap in np.argwhere(binds(given["cap_share"][capped, sample])).tolist():
            variant, joint = int(capped[place]), cap - m - 2
            upper = np.concatenate([given["velocity"][variant % len(given["velocity"])], most, of_object])[cap]
            slows = 0 <= joint < m and tracked.ddq[variant, sample[place], joint] < 0
            lower = least[joint] if slows else -upper
            row = ActiveRow.of(self._caps[cap], float(lower), float(upper), at_upper=not slows)
            rows.setdefault(variant, []).append(row)
        return rows


def _infeasible_row(record: np.void, time: Array, rows: list[ActiveRow]) -> Row:
    sample = int(record["sample"][0])
    reason = (
        f"at t = {time[sample]:.4g} s (sample {sample}) no torques carry the object at any speed: these limits "
        f"conflict: {'; '.join(map(str, rows))}. {RangeStatus.INFEASIBLE.advice}"
    )
    return {"status": RangeStatus.INFEASIBLE.value, "reason": reason}


def _range_row(record: np.void, time: Array, rows: Sequence[list[ActiveRow]]) -> Row:
    low, high = record["c2"].tolist()
    if high < low <= high * (1 + POINT_TOLERANCE):
        low = high
    samples = record["sample"].tolist()
    lower, upper = (
        RangeEnd(c2, sample, float(time[sample]), tuple(bound)) if limited else RangeEnd(c2, None, None)
        for c2, limited, sample, bound in zip((low, high), (low > 0, np.isfinite(high)), samples, rows, strict=True)
    )
    if low > high:
        reason = f"{contradiction(lower, upper)} {RangeStatus.EMPTY.advice}"
        return {"status": RangeStatus.EMPTY.value, "reason": reason}
    row = ends_row(lower, upper, float(time[-1]))
    if np.isinf(high):
        return row | {"status": RangeStatus.UNBOUNDED.value, "reason": RangeStatus.UNBOUNDED.advice}
    return row | {"status": RangeStatus.FEASIBLE.value}
