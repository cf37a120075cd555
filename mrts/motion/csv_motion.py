# SPDX-License-Identifier: MIT
"""CSV tables of motion: the object's pose, or the joints' positions, over time."""

import csv
from array import array
from collections.abc import Iterator
from io import StringIO
from itertools import chain, islice
from pathlib import Path

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.input_file import LARGEST_NUMBER, read_text
from mrts.base.rigid_transform import rotations_from_quaternions
from mrts.motion.joint_table import JointTable, joint_waypoints
from mrts.motion.object_courses import spline_motion
from mrts.motion.object_motion import SHORTEST_STEP, ObjectMotion
from mrts.motion.rounded_samples import derivative

POSE_COLUMNS = ("px", "py", "pz", "qx", "qy", "qz", "qw")
RATE_COLUMNS = ("vx", "vy", "vz", "wx", "wy", "wz"), ("ax", "ay", "az", "alphax", "alphay", "alphaz")

MAX_SAMPLES = 1_000_000
MAX_COLUMNS = 1000
"""Position, velocity, acceleration, torque and friction of some two hundred joints."""

PASSED_OVER = "tau_friction"
"""Columns of torques that `tau` has in it."""

QUATERNION_TOLERANCE = 1e-3
"""How far from 1 a quaternion's length may be: tables carry few digits."""


def read_table(path: Path, samples: int | None) -> ObjectMotion | JointTable:
    """Read a table of motion; its columns tell of what.

    Of the object it has t, px, py, pz, qx, qy, qz, qw and maybe velocities, maybe accelerations too, in world axes. Of
    joints it has t and, for every joint, `q.ROBOT/JOINT`, and maybe `dq.…`, and with these maybe `ddq.…`; the torques
    `tau.…`, `tau_friction.…` and wrenches `F.…` that `mrts scale --csv` writes are passed over. With `q.…` alone, rows
    are waypoints; columns with no `q.` at all are t and positions of the joints that they name.

    Args:
        samples: Number of samples on the C² spline through a table without velocities; None takes its own times.

    Raises:
        InputError: If a column is missing, unknown or malformed, a value is not a finite number, the times do not
            increase, a quaternion is not of length 1, or the velocities contradict the positions.
    """
    columns = read_columns(path)
    of_object = any(name in columns for name in POSE_COLUMNS) and not any(name.startswith("q.") for name in columns)
    return _object_table(path, columns, samples) if of_object else _joint_table(path, columns, samples)


def _object_table(path: Path, columns: dict[str, Array], samples: int | None) -> ObjectMotion:
    time = row_times(path, columns)
    given = [number for number, part in enumerate(RATE_COLUMNS, 1) if not columns.keys().isdisjoint(part)]
    rates = RATE_COLUMNS[: max(given, default=0)]  # accelerations come with velocities
    wanted = (*POSE_COLUMNS, *chain(*rates))
    missing = [name for name in wanted if name not in columns]
    if missing:
        rule = f"these columns are needed too: {', '.join(missing)}. Velocities and accelerations may be left out."
        raise InputError(path, rule)
    unknown = columns.keys() - {"t", *wanted}
    if unknown:
        every = ", ".join((*POSE_COLUMNS, *chain(*RATE_COLUMNS)))
        raise InputError(path, f"unknown column '{min(unknown)}'. Columns are t, {every}.")
    pose = np.column_stack([columns[name] for name in POSE_COLUMNS])
    lengths = np.linalg.norm(pose[:, 3:], axis=1)
    row = int(np.argmax(np.abs(lengths - 1)))
    if abs(lengths[row] - 1) > QUATERNION_TOLERANCE:
        raise InputError(
            path, f"must have length 1, it has {lengths[row]:.6g}. The order is x, y, z, w.",
            key=f"row {row + 1}, quaternion", value=pose[row, 3:].tolist(),
        )  # fmt: skip
    if rates and samples is not None:
        raise InputError(path, "a table with velocities keeps its own times: leave 'samples' out.", key="samples")
    try:
        if not rates:
            at = time if samples is None else np.linspace(0.0, time[-1], samples)
            return spline_motion(time, pose[:, :3], pose[:, 3:], at)
        twist, *more = (np.column_stack([columns[name] for name in part]) for part in rates)
        acceleration = more[0] if more else derivative(time, twist)
        return ObjectMotion(time, pose[:, :3], rotations_from_quaternions(pose[:, 3:]), twist, acceleration)
    except InputError as error:
        raise InputError(path, error.rule, key=error.where) from None


def _joint_table(path: Path, columns: dict[str, Array], samples: int | None) -> JointTable:
    parts = _joint_parts(path, columns)
    if not parts["q"]:
        raise InputError(path, "holds no column q.ROBOT/JOINT.")
    if all(name.startswith("q.") for name in columns):
        return joint_waypoints(path, parts["q"], samples)
    time = row_times(path, columns)
    for below, part in (("q", "dq"), ("dq", "ddq")):
        for joint in parts[part]:
            if joint not in parts[below]:
                raise InputError(path, f"the column '{part}.{joint}' needs a column '{below}.{joint}'.")
    return JointTable(path, time, parts["q"], parts["dq"], parts["ddq"], samples=samples)


def read_joint_columns(path: Path) -> tuple[Array, dict[str, dict[str, Array]]]:
    """Read a table of joints as it is: time, Shape (N,) [s] from 0, and by q, dq, ddq, tau, F the columns of each.

    Raises:
        InputError: If a column is malformed, a value is not a finite number, or the times do not increase.
    """
    columns = read_columns(path)
    return row_times(path, columns), _joint_parts(path, columns)


def _joint_parts(path: Path, columns: dict[str, Array]) -> dict[str, dict[str, Array]]:
    parts: dict[str, dict[str, Array]] = {"q": {}, "dq": {}, "ddq": {}, "tau": {}, "F": {}}
    if not any("." in name for name in columns):
        return parts | {"q": {name: values for name, values in columns.items() if name != "t"}}
    for name, values in columns.items():
        part, _, joint = name.partition(".")
        if name == "t" or part == PASSED_OVER:
            continue
        if part not in parts or not joint:
            of_object = ", ".join(POSE_COLUMNS)
            rule = f"Columns are t, of joints q.ROBOT/JOINT, dq.…, ddq.…, tau.…, F.…, of the object {of_object}."
            raise InputError(path, f"unknown column '{name}'. {rule}")
        parts[part][joint] = values
    return parts


def read_columns(path: Path, least: int = 2) -> dict[str, Array]:
    """Read a table of numbers: each column by its name, Shape (N,), N at least `least`.

    Raises:
        InputError: If the table is malformed, or a value is not a finite number.
    """
    text = read_text(path, "table").removeprefix("\ufeff")  # the mark that spreadsheets put in front of UTF-8
    rows = _rows(path, text)
    try:
        names = _column_names(path, next(rows, None))
        values = array("d")
        for number, row in enumerate(rows, start=1):
            if len(row) != len(names):
                raise InputError(path, f"has {len(row)} values for {len(names)} columns.", key=f"row {number}")
            values.extend(map(_number, row))
    except csv.Error as error:
        raise InputError(path, f"is no CSV table: {error}.") from None
    count = len(values) // len(names)
    if count < least:
        raise InputError(path, f"holds {count} rows of values; at least {least} are needed.")
    table = np.frombuffer(values).reshape(count, len(names))
    wrong = np.argwhere(~(np.abs(table) <= LARGEST_NUMBER))
    if wrong.size:
        row, column = wrong[0].tolist()
        given = next(islice(_rows(path, text), row + 1, None))[column]
        raise InputError(path, "must be a finite number.", key=f"row {row + 1}, column {names[column]}", value=given)
    return dict(zip(names, table.T.copy(), strict=True))


def _rows(path: Path, text: str) -> Iterator[list[str]]:
    for number, row in enumerate(csv.reader(StringIO(text))):
        if number > MAX_SAMPLES:
            raise InputError(path, f"a motion has at most {MAX_SAMPLES} samples.")
        if "".join(row).strip():
            yield row


def _number(text: str) -> float:
    """NaN for what is none, such as 1_000."""
    try:
        return np.nan if "_" in text else float(text)
    except ValueError:
        return np.nan


def _column_names(path: Path, row: list[str] | None) -> list[str]:
    if row is None:
        raise InputError(path, "is empty: the first line names the columns.")
    names = [name.strip() for name in row]
    if len(names) == 1:
        raise InputError(path, "has one column; separate columns by commas.", value=names[0])
    if len(names) > MAX_COLUMNS:
        raise InputError(path, f"has {len(names)} columns; a table has at most {MAX_COLUMNS}.")
    seen: set[str] = set()
    for name in names:
        if not name:
            raise InputError(path, "a column has no name: is there a comma too many in the first line?")
        if name in seen:
            raise InputError(path, f"the column '{name}' stands twice.")
        seen.add(name)
    return names


def row_times(path: Path, columns: dict[str, Array]) -> Array:
    """The column t, Shape (N,) [s], from 0.

    Raises:
        InputError: If there is none, or the times do not increase.
    """
    if "t" not in columns:
        waypoints = "Waypoints of joints without times have columns q.JOINT alone."
        raise InputError(path, f"a column 't' in s is needed; there are {', '.join(columns)}. {waypoints}")
    time = columns["t"]
    steps = np.diff(time)
    if np.min(steps, initial=np.inf) < SHORTEST_STEP:
        row = int(np.argmax(steps < SHORTEST_STEP)) + 2
        rule = f"must be later than the row before, by {SHORTEST_STEP:g} s at least."
        raise InputError(path, rule, key=f"row {row}, column t", value=time[row - 1])
    return np.asarray(time - time[0], dtype=np.float64)
