# SPDX-License-Identifier: MIT
"""What an exported library has of a cell: its load and limits as tables, and test vectors that this runtime finds."""

from collections.abc import Sequence
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, MotionError
from mrts.base.rigid_transform import rpy_from_rotation
from mrts.cell.cell import Cell
from mrts.cell.points import PointLimit
from mrts.cell.robot import EFFECTS
from mrts.following.bodies import tip_at_posture
from mrts.following.coordinate import coordinate
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits import rows_by_limit
from mrts.limits.cell_limits import curve_rows, motor_limits, velocity_limits, velocity_rows
from mrts.limits.motion_limits import STANDING, acceleration_limits, carried_limits, point_limits
from mrts.limits.rows import LimitRows, RowName, base_axes, limit_name, stack_rows
from mrts.motion.motion_file import load_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.motion.rows_at_rest import REST
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import RangeStatus, motion_ranges
from mrts.program.torque_distribution import distribute_torques, torque_weights

ON_THE_MOTION = (velocity_limits, acceleration_limits, point_limits, carried_limits)
"""Limits of the motion alone: a library computes what they bound."""

SAMPLES = 101
MASS_FACTORS = (1.0, 0.2, 3.0, 10.0, 40.0)
"""Of the nominal mass: light enough to be fast, heavy enough to be infeasible."""

LIFTS = (0.05, 0.02, 0.005)
"""Ways upward that are tried for a motion of our own [m]."""

SHARE_OF_END = 0.5
"""Torques are compared at this share of c²⁺: at the end itself the feasible set is a point, and rounding decides."""

STATUS = {RangeStatus.FEASIBLE: 0, RangeStatus.UNBOUNDED: 1, RangeStatus.INFEASIBLE: 2}
PLACES = b"CELL_START", b"CELL_INSIDE", b"CELL_END"
"""Of the exported header: how a range ends, and where in its motion a sample lies."""


def embedded_tables(cell: Cell, motion: CoordinatedMotion) -> dict[str, NDArray[Any]]:
    """Numbers and texts of a cell by their words in codegen/embedded/templates, test vectors of a motion among them.

    They have all limits, infinity where there is none: it may get one at run time. BASE and AXES are missing where no
    row is in object axes, ARMATURE and those after it where all motors are ideal, ACCELERATION_LOWER and those after it
    where only velocities limit the motion.

    Raises:
        InputError: If a limit of one's own depends on the motion: the library has tables for those that do not; or if
            the cell keeps a reserve.
    """
    if cell.reserve:
        rule = (
            "an exported library has the limits as they are given. Move its sides inward in its settings, at run time."
        )
        raise InputError("reserve", rule, value=cell.reserve)
    probes = _probe(cell, 1), _probe(cell, 2)
    first, second = (rows_by_limit(cell, probe) for probe in probes)
    pieces: list[LimitRows] = []
    line_rows = range(0)
    of_curves, joint, limits, slope = curve_rows(cell)
    is_line = np.isfinite(slope)
    for (limit, given), (_, other) in zip(first, second, strict=True):
        if limit is motor_limits:
            before = sum(len(piece.names) for piece in pieces)
            line_rows = range(before, before + np.count_nonzero(is_line))
            pieces.append(given.only(is_line))
        elif limit not in ON_THE_MOTION:
            _check_constant(limit_name(limit), given, other)
            pieces.append(given)
    rows = stack_rows(pieces)
    kept = rows.limits
    velocity = velocity_rows(cell, probes[0]).limits
    most = velocity.upper if cell.enforces_velocity_limits else np.full_like(velocity.upper, np.inf)
    row, column = np.nonzero(kept.matrix)
    tables = {
        "LOAD": cell.load,
        "LOAD_CORNERS": np.array([point.load for point in cell.load_box.corners()] if cell.load_box else [cell.load]),
        "WEIGHT": np.diag(torque_weights(None, cell)),
        "ROW_START": np.concatenate([[0], np.cumsum(np.bincount(row, minlength=len(kept.matrix)))]),
        "ROW_COLUMN": column,
        "ROW_VALUE": kept.matrix[row, column],
        "LOWER": kept.lower,
        "UPPER": kept.upper,
        "ROW_GROUP": np.array(kept.groups, dtype=np.intp),
        "VELOCITY": np.concatenate([most, limits[~is_line]]),
        **_motors(cell, joint, slope, line_rows),
    }
    if rows.object_axes is not None:
        base, axes = base_axes(cell)
        tables |= {"BASE": base.ravel(), "AXES": np.array(axes)}
    names = [*kept.names, *velocity.names, *compress(of_curves, ~is_line)]
    if cell.limits_motion:
        of_motion, more = _motions(cell)
        names, tables = names + of_motion, tables | more
    vectors = _vectors(cell, motion, with_motors="REST" in tables)
    if "REST" in tables:
        for word, name in (("REST_SPEED", "dq"), ("REST_ACCELERATION", "ddq")):
            tables[word] = tables["REST"] * np.max(np.abs(vectors["sample"][name]))
    texts = np.array(["c^2 >= 0", *map(_text, names)])
    return tables | {"ROW_TEXT": texts, "PATH_SAMPLES": np.array(motion.samples), "VECTOR_ROWS": vectors}


def _motions(cell: Cell) -> tuple[list[RowName], dict[str, NDArray[Any]]]:
    """Limits of accelerations, points and things on the object: names in the order of the C's, and their tables."""
    robots, things = cell.robots, cell.carried
    names = [RowName("acceleration", robot.name, joint) for robot in robots for joint in robot.joints]
    names += [RowName("acceleration", "object", part) for part in ("linear", "angular")]
    owners: list[tuple[str, PointLimit]] = [(robot.name, point) for robot in robots for point in robot.point_limits]
    owners += [("object", point) for point in cell.object_points]
    names += [RowName(kind, owner, str(point.name)) for owner, point in owners for kind in ("velocity", "acceleration")]
    names += [RowName("contact", "object", f"{thing.name} {what}") for thing in things for what in STANDING]
    limits = [[point.speed if cell.enforces_velocity_limits else None, point.acceleration] for _, point in owners]
    speed, acceleration = np.array([[limit or np.inf for limit in both] for both in limits]).reshape(-1, 2).T
    of_arms = [(cell.joint_slices[robot.name].start, point) for robot in robots for point in robot.point_limits]
    none = [0] * len(cell.object_points)
    places = [point.at_zero for _, point in of_arms] + [point.point for point in cell.object_points]
    unlimited = [np.inf, np.inf]
    tilt = [np.divide(thing.half_width or unlimited, thing.height or 1.0) for thing in things]
    tables = {
        "ACCELERATION_LOWER": cell.stacked("acceleration_lower"),
        "ACCELERATION_UPPER": cell.stacked("acceleration_upper"),
        "OBJECT_ACCELERATION": cell.object_acceleration_limit,
        "JOINT_AXIS": cell.stacked("axes"),
        "JOINT_POINT": cell.stacked("points"),
        "JOINT_SLIDES": np.concatenate([~robot.turns for robot in robots]),
        "POINT_FIRST": np.array([first for first, _ in of_arms] + none, dtype=np.intp),
        "POINT_JOINTS": np.array([point.joints for _, point in of_arms] + none, dtype=np.intp),
        "POINT_PLACE": np.array(places, dtype=np.float64),
        "POINT_SPEED": speed,
        "POINT_ACCELERATION": acceleration,
        "THING_AXES": np.array([thing.axes for thing in things]),
        "THING_CENTRE": np.array([thing.centre for thing in things]),
        "FRICTION": np.array([thing.friction or np.inf for thing in things]),
        "TILT": np.array(tilt),
        "GRAVITY": cell.gravity,
    }
    return names, {word: np.ravel(table) for word, table in tables.items()}


def _motors(cell: Cell, joint: NDArray[np.intp], slope: Array, line_rows: Sequence[int]) -> dict[str, NDArray[Any]]:
    """What motors add to torques and limits; nothing where all are ideal."""
    motors = [robot.motors for robot in cell.robots]
    if not (len(slope) or any(motor.has_effect for motor in motors)):
        return {}
    is_line = np.isfinite(slope)
    return {
        **{name.upper(): cell.stacked(f"motors.{name}") for name in EFFECTS},
        "LINE_ROWS": np.array(line_rows, dtype=np.intp),
        "LINE_JOINTS": joint[is_line],
        "SLOPE": slope[is_line],
        "END_JOINTS": joint[~is_line],
        "REST": np.array(REST),
    }


def _probe(cell: Cell, seed: int) -> CoordinatedMotion:
    """Two samples in which everything moves; no arm needs to be able to do that."""
    rng = np.random.default_rng(seed)
    joints = len(cell.joint_names)
    q, dq, ddq = rng.normal(size=(3, 2, joints))
    position, twist, acceleration = rng.normal(size=(2, 3)), *rng.normal(size=(2, 2, 6))
    time, still = np.array([0.0, 1.0]), np.tile(np.eye(3), (2, 1, 1))
    return CoordinatedMotion(ObjectMotion(time, position, still, twist, acceleration, checked=False), q, dq, ddq)


def _check_constant(limit: str, rows: LimitRows, again: LimitRows) -> None:
    of_speed = any(column is not None and np.any(column) for column in (rows.rate, rows.speed, rows.square))
    both = rows.limits, again.limits
    tables = [(of.torque_matrix, of.wrench_matrix, of.in_object_axes, of.lower, of.upper) for of in both]
    alike = rows.names == again.names and all(map(np.array_equal, *tables))
    if of_speed or not alike:
        raise InputError(
            f"limit '{limit}'",
            f"depends on the {'speed' if of_speed else 'motion'}, which an exported library cannot compute: it carries "
            "the limits of the cell file, and tables of limits that are constant in torques and wrenches. Export the "
            "cell without it (`Cell.with_limits`), and keep it by other means.",
        )


def _text(name: RowName) -> str:
    return f"{name.robot}/{name.element} {name.kind}" if name.robot and name.kind != "contact" else str(name)


def _vectors(cell: Cell, motion: CoordinatedMotion, *, with_motors: bool) -> NDArray[Any]:
    """`cell_vector` of all samples of a motion with the nominal load first, then with other masses."""
    count, m = motion.q.shape
    rotation = motion.object.rotation.reshape(-1, 9)
    moving = {"q": motion.q, "dq": motion.dq, "ddq": motion.ddq, "rotation": rotation}
    moving |= {"twist": motion.object.twist, "acceleration": motion.object.acceleration}
    sample = [(name, float, values.shape[1:]) for name, values in moving.items()]
    answers = [("mass", float), ("status", int), ("lower", float), ("upper", float)]
    answers += [("share_status", int), ("share_lower", float), ("share_upper", float), ("c2", float)]
    kind = [("sample", sample + [("place", "S11", ())] * with_motors), *answers, ("torque", float, (m,))]
    vectors = np.zeros((len(MASS_FACTORS), count), kind)
    for name, values in moving.items():
        vectors["sample"][name] = values
    if with_motors:
        vectors["sample"]["place"] = [PLACES[0], *PLACES[1:2] * (count - 2), PLACES[2]]
    for found, factor in zip(vectors, MASS_FACTORS, strict=True):
        heavy = cell.with_mass(cell.mass * factor)
        rows = motion_rows(heavy, motion)
        free = motion_ranges(rows)
        even = motion_ranges(motion_rows(heavy, motion, LoadSharing()))
        speeds = np.where([status is RangeStatus.FEASIBLE for status in free.status], SHARE_OF_END * free.upper, 0.0)
        speeds = np.where(speeds >= free.lower, speeds, 0.0)
        compared = np.flatnonzero(speeds > 0)
        if compared.size:
            problem = build_sample_problem(rows, samples=compared)
            x = distribute_torques(problem, speeds[compared], torque_weights(None, cell))
            found["torque"][compared] = problem.torque(x)
        found["mass"], found["c2"] = heavy.mass, speeds
        for share, ranges in (("", free), ("share_", even)):
            found[f"{share}status"] = [STATUS[status] for status in ranges.status]
            found[f"{share}lower"], found[f"{share}upper"] = ranges.lower, ranges.upper
    return vectors.ravel()


def own_motion(cell: Cell) -> CoordinatedMotion:
    """A short lift against gravity from where the first robot's posture puts the object."""
    first = cell.robots[0]
    T_world_object = tip_at_posture(first) @ first.T_object_tip.inverse()
    rpy = rpy_from_rotation(T_world_object.R)
    size = float(np.linalg.norm(cell.gravity))
    up = -cell.gravity / size if size > 0 else np.array([0.0, 1.0, 0.0])
    for lift in LIFTS:
        start, end = ({"xyz": T_world_object.p + way * up, "rpy": rpy} for way in (0.0, lift))
        motion = load_motion({"duration": 0.5, "samples": SAMPLES, "profile": "quintic", "start": start, "end": end})
        try:
            return coordinate(cell, motion)
        except MotionError:
            continue
    raise InputError(
        "--motion",
        "the test vectors need a motion, and the arms cannot lift the object from the first robot's posture. Give a "
        "motion file that this cell can follow.",
    )
