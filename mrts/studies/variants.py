# SPDX-License-Identifier: MIT
"""The answers of a study: one row a variant, whatever becomes of it, many at once in native calls or one by one."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, MotionError, MrtsError, check_type
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.base.rigid_transform import rotations_from_rpy
from mrts.cell.cell import Cell
from mrts.cell.cell_keys import Keys
from mrts.following.clearance import clearance
from mrts.following.coordinate import coordinate
from mrts.following.coordinated_motion import CoordinatedMotion, leaves_plane
from mrts.following.tracking import TrackedVariants, track_variants
from mrts.kernel.programs import INFEASIBLE, OPTIMAL
from mrts.kernel.tracking import PATH, REFUSED, variant_ranges
from mrts.limits import limit_rows
from mrts.limits.cell_limits import torque_limits, velocity_rows, wrench_limits
from mrts.limits.rows import ActiveRow
from mrts.motion.object_courses import PROFILES, geodesic_rates
from mrts.motion.object_motion import ObjectMotion
from mrts.program.motion_rows import binds, largest_square, side_share
from mrts.program.sample_ranges import RangeStatus, SampleRanges
from mrts.scaling.options import Options
from mrts.scaling.range import RangeEnd, ScalingRange, range_between
from mrts.scaling.scale import admissible_range
from mrts.studies.parameters import ANSWERS
from mrts.studies.study import Study, StudyQuestion
from mrts.timing.result import RetimingStatus
from mrts.timing.retime import retime

UNREACHABLE, INVALID, FAILED = "unreachable", "invalid", "failed"
"""Statuses of a variant beside those of a range: the arms cannot follow, its numbers break a rule, a solver stopped."""

LIMIT_SEPARATOR = ", "
"""Between the limits that bind together."""

Row = dict[str, Any]
Columns = dict[str, Any]
"""A column by name: an array of numbers, or a list with None where there is nothing."""

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

FRAMES, ENDS, PARTS = ("base", "grasp"), ("start", "end"), ("xyz", "rpy")

FRAME_SIZE = ROBOT_SIZE // 2
"""Numbers of the pose of a frame: nine of its rotation, three of its place."""

NONE = np.zeros(0)

NO_SAMPLES = SampleRanges(NONE, NONE, NONE, (), np.zeros((2, 0)), np.zeros((2, 0, 0), dtype=np.int32), NONE > 0)
"""Of a variant only the ends of its range are known."""


def column_types(study: Study) -> dict[str, str]:
    """Names and types ("int64", "float64", "string") of the columns of a study's table, in order."""
    types = {"variant": "int64"} | {parameter.path: "float64" for parameter in study.parameters}
    return types | ANSWERS | dict.fromkeys(["clearance"] * study.question.clearance, "float64")


def solve_variants(study: Study, first: int, last: int) -> Columns:
    """The rows of some variants of a study.

    Returns:
        By column (`column_types`), one entry a variant. A variant that cannot be solved has a status and a reason.

    Raises:
        InputError: If there are no such variants.
    """
    check_type("study", study, Study)
    points, batch = study.points(first, last), batch_for(study)
    return solve_one_by_one(study, points, first) if batch is None else batch.solve(points, first)


def solve_one_by_one(study: Study, points: Array, first: int) -> Columns:
    """The rows of variants at points, Shape (V, P), from a first number, each solved as `mrts.scale` does."""
    study = study.at_hand()
    return columns_of(study, points, first, [solved_row(study, point) for point in points])


def columns_of(study: Study, points: Array, first: int, rows: Sequence[Row]) -> Columns:
    """The rows of variants at points, Shape (V, P), from a first number as columns; rows have what is found alone."""
    columns: Columns = {"variant": np.arange(first, first + len(points))}
    columns |= {parameter.path: points[:, place] for place, parameter in enumerate(study.parameters)}
    return columns | {name: [row.get(name) for row in rows] for name in column_types(study) if name not in columns}


def _labels(end: RangeEnd) -> str:
    return LIMIT_SEPARATOR.join(dict.fromkeys(row.label for row in end.rows))


def solved_row(study: Study, point: Array) -> Row:
    """What is found of a variant, at a point of a study as from `Study.at_hand`, Shape (P,), as `mrts.scale` does."""
    try:
        return _answer(study, *study.descriptions(point))
    except MrtsError as error:
        refused = INVALID if isinstance(error, InputError) else FAILED
        status = UNREACHABLE if isinstance(error, MotionError) else refused
        return {"status": status, "reason": str(error)}
    except Exception as error:  # noqa: BLE001 (a defect in one variant must not take the others with it)
        return {"status": FAILED, "reason": f"{type(error).__name__}: {error}"}


def _answer(study: Study, keys: dict[str, Any], motion_keys: dict[str, Any]) -> Row:
    cell, motion, question = study.cell_of(keys), study.motion_of(motion_keys), study.question
    options = Options(load=question.load, between=question.between).checked(cell)
    found = admissible_range(cell, coordinate(cell, motion, None), options)[0]
    row = range_row(found.range, float(found.motion.object.time[-1]))
    if question.profile == "optimal":  # the range stays that of a constant factor
        timed = retime(cell, motion, load=question.load, between=question.between)
        unbounded = timed.status is RetimingStatus.UNBOUNDED
        status = RangeStatus.UNBOUNDED if unbounded else RangeStatus.INFEASIBLE
        row |= {"duration": timed.duration, "status": status.value, "reason": timed.explanation or timed.status.value}
        if timed.status.admits_motion:
            row |= {"status": RangeStatus.FEASIBLE.value, "reason": None}
    if question.clearance:
        near = clearance(cell, motion)
        row["clearance"] = near.distance if near.pair else None
    return row


def range_row(found: ScalingRange, given_duration: float) -> Row:
    """What the range of c² says of a variant whose given motion lasts some time [s]."""
    row: Row = {"status": found.status.value}
    if found.status is not RangeStatus.FEASIBLE:
        row["reason"] = found.explain() or found.status.advice
    lower, upper = found.lower, found.upper
    if not found.status.admits_motion:
        return row
    row["c2_lower"] = lower.c2
    if lower.c2 > 0 and lower.time is not None:
        row |= {"lower_limit": _labels(lower), "lower_time": lower.time}
    if upper.time is not None:
        row |= {"c2_upper": upper.c2, "upper_limit": _labels(upper), "upper_time": upper.time}
        row["duration"] = given_duration / math.sqrt(upper.c2) if upper.c2 > 0 else None
    return row


class Place(NamedTuple):
    """Where an array of the batch has a number of the files, with which sign, and between which values it is sound."""

    array: str
    at: tuple[int, ...]
    sign: float = 1.0
    least: float = -LARGEST
    largest: float = LARGEST


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
    if not known or len(cell.robots) == 1 or not isinstance(motion, ObjectMotion) or not _covers(cell):
        return None
    batch = VariantBatch(here, cell, motion)
    return batch if batch.covers_all else None


def _covers(cell: Cell) -> bool:
    motors = [robot.motors for robot in cell.robots]
    curves = [curve for each in motors for curve in each.torque_speed if curve is not None]
    of_points = cell.object_points or cell.carried or any(robot.point_limits for robot in cell.robots)
    return not curves and not any(each.has_effect for each in motors) and not of_points


class VariantBatch:
    """Variants of an unvaried cell and motion, in which some numbers differ, solved at once."""

    def __init__(self, study: Study, cell: Cell, motion: ObjectMotion) -> None:
        self._study, self._cell, self._motion = study, cell, motion
        m, robots, moved = len(cell.joint_names), study.cell["robots"], study.motion
        still = np.zeros((len(motion.time), m))
        at_rest = CoordinatedMotion(motion, still, still, still)
        given = limit_rows(cell.with_reserve(0.0), at_rest)
        alone = {"velocity", "acceleration"}  # these bound c² by themselves
        self.rows = given.only(np.array([name.kind not in alone for name in given.names], dtype=bool)).limits
        self._caps = velocity_rows(cell, at_rest).names
        self._caps += tuple(replace(name, kind="acceleration", unit=f"{name.unit}²") for name in self._caps)
        self._limited = {"torque": torque_limits(cell, at_rest).names, "wrench": wrench_limits(cell, at_rest).names}
        self._sparse, matrix = self.rows.in_c, self.rows.matrix
        self._values = matrix[np.nonzero(matrix)]
        rpy = [[(robot.get(frame) or {}).get("rpy") or [0.0] * 3 for frame in FRAMES] for robot in robots]
        ends = [[(moved.get(end) or {}).get(part) or [0.0] * 3 for part in PARTS] for end in ENDS]
        numbers = {
            "geometry": cell.geometry,
            "rpy": rpy,
            "load": cell.load,
            "velocity": np.append(cell.stacked("velocity_limit"), cell.object_velocity_limit),
            "posture": cell.posture,
            "lower": self.rows.lower,
            "upper": self.rows.upper,
            "ends": ends,
            "duration": moved.get("duration", 1.0),
        }
        self._base = {name: np.array(value, dtype=np.float64)[None] for name, value in numbers.items()}
        self._from_pose_to_pose = "waypoints" not in moved
        self._moves: list[tuple[Place, int, float, float]] = []  # each with parameter, factor and offset
        self.covers_all = True
        for column, parameter in enumerate(study.parameters):
            for target in parameter.targets:
                places = [*self._places(target.keys)]
                self.covers_all &= bool(places)
                self._moves += [(place, column, target.factor, target.offset) for place in places]
        places = [place for place, *_ in self._moves]
        self._varied = {place.array for place in places}
        self._turned = sorted({place.at[:2] for place in places if place.array == "rpy"})
        self._sided = sorted({place.at[0] for place in places if place.array in {"lower", "upper"}})
        self._has_inertia = any(place.array == "load" and place.at[0] > 0 for place in places)
        if self._turned:
            self._varied.add("geometry")
        self._follows_path = not self._varied.isdisjoint({"ends", "duration"})
        self.block = max(1, BLOCK_BYTES // (len(motion.time) * (3 * m + 25 * self._follows_path) * 8))

    def _places(self, keys: Keys) -> Iterator[Place]:
        """Where arrays have a number of the files; nowhere where it moves more than that."""
        match keys:
            case "cell", "gravity", int(axis):
                yield Place("geometry", (axis,))
            case "cell", "object", "mass" if self._study.cell["object"].get("inertia") is not None:  # else it moves too
                yield Place("load", (0,), least=SMALLEST)
            case "cell", "object", "inertia", int(axis):
                yield Place("load", (4 + axis,))
            case "cell", "object", "velocity", "linear" | "angular" as kind:
                yield Place("velocity", (-2 if kind == "linear" else -1,), least=SMALLEST)
            case "cell", "robots", int(robot), *of_robot:
                yield from self._of_robot(robot, *of_robot)
            case "motion", "start" | "end" as end, "xyz" | "rpy" as part, int(axis) if self._from_pose_to_pose:
                most = LARGEST if part == "xyz" else LARGEST_ANGLE
                yield Place("ends", (ENDS.index(end), PARTS.index(part), axis), 1.0, -most, most)
            case "motion", "duration" if self._from_pose_to_pose:
                yield Place("duration", (), least=SMALLEST)

    def _of_robot(self, robot: int, *keys: str | int) -> Iterator[Place]:
        cell, frame, angle = self._cell, GRAVITY_SIZE + ROBOT_SIZE * robot, LARGEST_ANGLE
        joints, wrenches = ([*slices.values()][robot].start for slices in (cell.joint_slices, cell.wrench_slices))
        in_tip = any(contact.frame == "tip" for contact in cell.robots[robot].contacts)  # rows that turn with it
        turns = {"base": cell.plane is None, "grasp": cell.plane is None and not in_tip}
        match keys:
            case "posture", int(joint):
                yield Place("posture", (joints + joint,), 1.0, -angle, angle)
            case "base" | "grasp" as name, "xyz", int(axis):
                yield Place("geometry", (frame + FRAME_SIZE * FRAMES.index(name) + 9 + axis,))
            case "base" | "grasp" as name, "rpy", int(axis) if turns[name]:
                yield Place("rpy", (robot, FRAMES.index(name), axis), 1.0, -angle, angle)
            case "torque" | "wrench" as kind, "lower" | "upper" as side, int(place):
                yield from self._of_rows(kind, side, place + (joints if kind == "torque" else wrenches))
            case "torque", int(joint):  # without sides it is both
                yield from self._of_rows("torque", "lower", joints + joint, -1.0)
                yield from self._of_rows("torque", "upper", joints + joint)

    def _of_rows(self, kind: str, side: str, at: int, sign: float = 1.0) -> Iterator[Place]:
        name = self._limited[kind][at]
        if name in self.rows.names:  # a limit on what the cell leaves free is a row more than it has
            yield Place(side, (self.rows.names.index(name),), sign)

    def solve(self, points: Array, first: int) -> Columns:
        """The rows of variants at points, Shape (V, P), from a first number, as `solve_variants` gives them."""
        rows: list[Row] = []
        for start in range(0, len(points), self.block):
            part = points[start : start + self.block]
            with np.errstate(all="ignore"):  # of numbers that break a rule, which are left to `solved_row`
                settled = self._rows(*self._answers(part))
            rows += [
                solved_row(self._study, point) if row is None else row for point, row in zip(part, settled, strict=True)
            ]
        return columns_of(self._study, points, first, rows)

    def _numbers(self, points: Array) -> tuple[dict[str, Array], NDArray[np.bool_]]:
        """The arrays of variants at points, with V or 1 first, and which a rule of the files may refuse, Shape (V,)."""
        count = len(points)
        wide = {name: count if name in self._varied else 1 for name in self._base}
        numbers = {name: np.repeat(of, wide[name], axis=0) for name, of in self._base.items()}
        refused = np.zeros(count, dtype=bool)
        for place, column, factor, offset in self._moves:
            value = place.sign * (offset + factor * points[:, column])
            refused |= ~((place.least <= value) & (value <= place.largest))
            where: tuple[slice | int, ...] = (slice(None), *place.at)
            numbers[place.array][where] = value
        refused |= ~np.all(numbers["lower"][:, self._sided] < numbers["upper"][:, self._sided], axis=1)
        if self._has_inertia:
            refused |= ~_of_a_body(numbers["load"])
        for robot, frame in self._turned:
            at = GRAVITY_SIZE + ROBOT_SIZE * robot + FRAME_SIZE * frame
            rotations = rotations_from_rpy(numbers["rpy"][:, robot, frame])
            numbers["geometry"][:, at : at + 9] = rotations.reshape(count, 9)
        return numbers, refused

    def _answers(self, points: Array) -> tuple[dict[str, Array], TrackedVariants, NDArray[np.void]]:
        """What the native calls take, by name, with V or 1 first, and what they give."""
        numbers, refused = self._numbers(points)
        path = self._path(numbers, refused)
        if self._cell.plane is not None:
            refused |= leaves_plane(self._cell, path["twist"])
        tracked = track_variants(self._cell, path, numbers["geometry"], numbers["posture"], refused)
        joints = tracked.q, tracked.dq, tracked.ddq
        given = {**numbers, **path, **self._limits(numbers), "values": self._values[None]}
        given["cap_share"] = self._cap_shares(given, tracked)
        asked = given | {"most": largest_square(given["cap_share"])}
        return given, tracked, variant_ranges(self._cell.library, joints, ~tracked.followed, self._sparse, asked)

    def _path(self, numbers: Mapping[str, Array], refused: NDArray[np.bool_]) -> dict[str, Array]:
        """The motion of the object, as `mrts.kernel.tracking.PATH` with V or 1 first; refused ones last a second."""
        if not self._follows_path:
            return {name: getattr(self._motion, name)[None] for name in PATH}
        u, count = np.linspace(0.0, 1.0, len(self._motion.time)), len(refused)
        ends = np.broadcast_to(numbers["ends"], (count, 2, 2, 3))
        duration = np.where(refused, 1.0, np.broadcast_to(numbers["duration"], count))
        (s, ds, dds), T = PROFILES[self._study.motion["profile"]](u), duration[:, None]
        rates = geodesic_rates(ends[:, :, 0], rotations_from_rpy(ends[:, :, 1]))(s, ds / T, dds / T**2)
        return dict(zip(PATH, (T * u, *rates), strict=True))

    def _limits(self, numbers: Mapping[str, Array]) -> dict[str, Array]:
        """Limits less the reserve: "lower" and "upper" of rows, and of "caps", which bound c² by themselves."""
        sides = {side: numbers[side] for side in ("lower", "upper")}
        if self._cell.reserve:
            pairs = zip(*np.broadcast_arrays(*sides.values()), strict=True)
            shrunk = [replace(self.rows, lower=low, upper=high).shrunk(self._cell.reserve) for low, high in pairs]
            sides = {side: np.array([getattr(rows, side) for rows in shrunk]) for side in sides}
        cell, velocity = self._cell, numbers["velocity"]
        if not cell.enforces_velocity_limits:
            velocity = np.full_like(velocity, np.inf)
        caps = {
            "caps_lower": (-velocity, cell.stacked("acceleration_lower"), -cell.object_acceleration_limit),
            "caps_upper": (velocity, cell.stacked("acceleration_upper"), cell.object_acceleration_limit),
        }
        for side, (speeds, of_joints, of_object) in caps.items():
            accelerations = np.tile(np.append(of_joints, of_object), (len(speeds), 1))
            sides[side] = (1 - cell.reserve) * np.column_stack([speeds, accelerations])
        return sides

    def _cap_shares(self, given: Mapping[str, Array], tracked: TrackedVariants) -> Array:
        """What velocities and accelerations are of their limits in ṙ² at ṙ = 1, Shape (V, N, 2 m + 4)."""
        shape = (*tracked.q.shape[:2], 2)
        sizes = [np.linalg.norm(given[name].reshape(*given[name].shape[:2], 2, 3), axis=3) for name in RATES]
        speeds, accelerations = (np.broadcast_to(size, shape) for size in sizes)
        least, most = (given[side][:, None] for side in ("caps_lower", "caps_upper"))
        m = tracked.q.shape[2]
        velocity = np.concatenate([np.abs(tracked.dq), speeds], axis=2) / most[..., : m + 2]
        joints = side_share(tracked.ddq, least[..., m + 2 : -2], most[..., m + 2 : -2])
        return np.concatenate([velocity**2, joints, accelerations / most[..., -2:]], axis=2)

    def _rows(
        self, given: Mapping[str, Array], tracked: TrackedVariants, found: NDArray[np.void]
    ) -> Iterator[Row | None]:
        """The row of each variant, without its number and its parameters; None where it is not settled."""
        caps = self._binding_caps(given, tracked, found)
        for variant, record in enumerate(found):
            failure, status = tracked.failure(variant), int(record["status"])
            if failure is not None:
                yield {"status": UNREACHABLE, "reason": failure.message}
            elif tracked.outcome[variant, 0]["code"] == REFUSED or status not in {INFEASIBLE, OPTIMAL}:
                yield None
            else:
                time, *sides = (given[name][variant % len(given[name])] for name in ("time", "lower", "upper"))
                bound = [self._named(record["rows"][end, : record["count"][end]], *sides) for end in (0, 1)]
                bound[1] += caps.get(variant, [])
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
        rows: dict[int, list[ActiveRow]] = {}
        for place, cap in np.argwhere(binds(given["cap_share"][capped, sample])).tolist():
            variant, joint = int(capped[place]), cap - m - 2
            lower, upper = (
                float(given[side][variant % len(given[side]), cap]) for side in ("caps_lower", "caps_upper")
            )
            slows = 0 <= joint < m and tracked.ddq[variant, sample[place], joint] < 0
            row = ActiveRow.of(self._caps[cap], lower, upper, at_upper=not slows)
            rows.setdefault(variant, []).append(row)
        return rows


def _of_a_body(load: Array) -> NDArray[np.bool_]:
    """Which loads surely have the inertia of a body (`mrts.cell.cell_file.inertia_problem`), Shape (V,)."""
    moments = np.linalg.eigvalsh(load[:, [[4, 7, 8], [7, 5, 9], [8, 9, 6]]])
    sound: NDArray[np.bool_] = moments[:, 0] > NEAR_A_RULE * moments[:, 2]
    return sound & (moments[:, 2] <= (moments[:, 0] + moments[:, 1]) * (1 + NEAR_A_RULE))


def _infeasible_row(record: np.void, time: Array, rows: list[ActiveRow]) -> Row:
    sample = int(record["sample"][0])
    reason = (
        f"at t = {time[sample]:.4g} s (sample {sample}) no torques carry the object at any speed: these limits "
        f"conflict: {'; '.join(map(str, rows))}. {RangeStatus.INFEASIBLE.advice}"
    )
    return {"status": RangeStatus.INFEASIBLE.value, "reason": reason}


def _range_row(record: np.void, time: Array, rows: Sequence[list[ActiveRow]]) -> Row:
    (low, high), samples = record["c2"].tolist(), record["sample"].tolist()
    lower, upper = (
        RangeEnd(c2, sample, float(time[sample]), tuple(bound)) if limited else RangeEnd(c2)
        for c2, limited, sample, bound in zip((low, high), (low > 0, np.isfinite(high)), samples, rows, strict=True)
    )
    return range_row(range_between(lower, upper, NO_SAMPLES), float(time[-1]))
