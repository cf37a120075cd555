# SPDX-License-Identifier: MIT
"""CSV tables of motion: the object's pose, or the joints' positions, over time."""

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from mrts.errors import InputError
from mrts.holding_rows import motion_rows
from mrts.input_file import LARGEST_NUMBER, read_text
from mrts.object_motion import ObjectMotion, check_derivatives, spline_motion
from mrts.remark import Remark
from mrts.rigid_transform import Array

POSE_COLUMNS = ("px", "py", "pz", "qx", "qy", "qz", "qw")
RATE_COLUMNS = ("vx", "vy", "vz", "wx", "wy", "wz", "ax", "ay", "az", "alphax", "alphay", "alphaz")

SHORTEST_STEP = 1e-9
"""[s]; below it squares of rates overflow."""

QUATERNION_TOLERANCE = 1e-3
"""How far from 1 a quaternion's length may be: tables carry few digits."""


@dataclass(frozen=True, repr=False)
class JointTable:
    """N samples of joint motion by column name; which joint a column is of, the cell tells.

    Attributes:
        path: The file, for messages.
        time: Shape (N,) [s], strictly increasing from 0.
        positions: Column "robot/joint" to positions, each Shape (N,) [rad or m]. A name that is no robot's may stand
            for it where one robot alone has such a joint.
        velocities: Likewise [rad/s or m/s].
        accelerations: Likewise [rad/s² or m/s²].
        remarks: What to know of how it was read.
    """

    path: Path
    time: Array
    positions: dict[str, Array]
    velocities: dict[str, Array]
    accelerations: dict[str, Array]
    remarks: tuple[Remark, ...] = ()

    def __repr__(self) -> str:
        joints = ", ".join(self.positions)
        return f"<JointTable from {self.path.name}: {len(self.time)} samples in {self.time[-1]:.4g} s of {joints}>"


def read_table(path: Path, samples: int | None) -> ObjectMotion | JointTable:
    """Read a table of either kind, told apart by its columns.

    Args:
        path: The file.
        samples: Number of samples on the C² spline through a table without velocities; None takes its own times.

    Raises:
        InputError: As `read_object_table` and `read_joint_table`, or if it looks like neither.
    """
    columns = _read_columns(path)
    if any(name.startswith("q.") for name in columns):
        return _joint_table(path, columns, samples)
    if any(name in columns for name in POSE_COLUMNS):
        return _object_table(path, columns, samples)
    raise InputError(
        path,
        f"is no table of motion: it has neither columns of the object ({', '.join(POSE_COLUMNS)}) nor of joints "
        "(q.ROBOT/JOINT).",
    )


def read_object_table(path: Path, samples: int | None) -> ObjectMotion:
    """Read a table with t, px, py, pz, qx, qy, qz, qw and, all or none, velocities and accelerations in world axes.

    Args:
        path: The file.
        samples: Number of samples on the C² spline through a table without velocities; None takes its own times.

    Raises:
        InputError: If a column is missing or unknown, a value is not a finite number, the times do not increase, a
            quaternion is not of length 1, or the velocities contradict the positions.
    """
    return _object_table(path, _read_columns(path), samples)


def _object_table(path: Path, columns: dict[str, Array], samples: int | None) -> ObjectMotion:
    time = _time(path, columns)
    rates = [name for name in RATE_COLUMNS if name in columns]
    missing = [name for name in POSE_COLUMNS if name not in columns]
    if missing:
        raise InputError(path, f"these columns are needed too: {', '.join(missing)}.")
    if rates and len(rates) < len(RATE_COLUMNS):
        lacking = ", ".join(name for name in RATE_COLUMNS if name not in columns)
        raise InputError(path, f"give all velocities and accelerations or none; these are missing: {lacking}.")
    unknown = set(columns) - {"t", *POSE_COLUMNS, *RATE_COLUMNS}
    if unknown:
        raise InputError(
            path, f"unknown column '{min(unknown)}'. Columns are t, {', '.join((*POSE_COLUMNS, *RATE_COLUMNS))}."
        )
    pose = np.column_stack([columns[name] for name in POSE_COLUMNS])
    lengths = np.linalg.norm(pose[:, 3:], axis=1)
    if np.max(np.abs(lengths - 1)) > QUATERNION_TOLERANCE:
        row = int(np.argmax(np.abs(lengths - 1)))
        raise InputError(
            path, f"must have length 1, it has {lengths[row]:.6g}. The order is x, y, z, w.",
            key=f"row {row + 1}, quaternion", value=pose[row, 3:].tolist(),
        )  # fmt: skip
    rotation = np.asarray(Rotation.from_quat(pose[:, 3:]).as_matrix(), dtype=np.float64)
    if not rates:
        at = time if samples is None else np.linspace(0.0, time[-1], samples)
        return spline_motion(time, pose[:, :3], rotation, at)
    if samples is not None:
        raise InputError(path, "a table with velocities keeps its own times: leave 'samples' out.", key="samples")
    given = np.column_stack([columns[name] for name in RATE_COLUMNS])
    try:
        return ObjectMotion(time, pose[:, :3], rotation, given[:, :6], given[:, 6:])
    except InputError as error:
        raise InputError(path, error.rule, key=error.where) from None


def read_joint_table(path: Path, samples: int | None) -> JointTable:
    """Read a table with t and, for every joint, `q.ROBOT/JOINT`, and, all or none, `dq.…` and `ddq.…`.

    The torques `tau.…` and wrenches `F.…` that `mrts scale --csv` writes are passed over.

    Args:
        path: The file.
        samples: Number of samples on the C² spline through a table without velocities; None takes its own times.

    Raises:
        InputError: If a column is malformed, a value is not a finite number, or the times do not increase.
    """
    return _joint_table(path, _read_columns(path), samples)


def _joint_table(path: Path, columns: dict[str, Array], samples: int | None) -> JointTable:
    time = _time(path, columns)
    parts: dict[str, dict[str, Array]] = {"q": {}, "dq": {}, "ddq": {}}
    for name, values in columns.items():
        part, _, joint = name.partition(".")
        if name == "t" or part in {"tau", "F"}:
            continue
        if part not in parts or not joint:
            raise InputError(path, f"unknown column '{name}'. Columns are t, q.ROBOT/JOINT, dq.…, ddq.….")
        parts[part][joint] = values
    q, dq, ddq = parts.values()
    for part in ("dq", "ddq"):
        if (dq or ddq) and set(parts[part]) != set(q):
            raise InputError(path, f"give q, dq and ddq of every joint, or q alone; '{part}' is not complete.")
    if not q:
        raise InputError(path, "holds no column q.ROBOT/JOINT.")
    return joint_motion(path, time, q, dq, ddq, samples)


def joint_motion(
    path: Path,
    time: Array,
    positions: dict[str, Array],
    velocities: dict[str, Array],
    accelerations: dict[str, Array],
    samples: int | None,
) -> JointTable:
    """Joint motion as given; where only positions are, on the C² spline through them.

    Args:
        path: Where it is from, for messages.
        time: Shape (M,) [s], strictly increasing from 0.
        positions: By joint, each Shape (M,) [rad or m].
        velocities: Likewise [rad/s or m/s]; empty if there are positions only.
        accelerations: Likewise [rad/s² or m/s²].
        samples: Number of samples on the spline; None takes the given times.

    Raises:
        InputError: If the velocities contradict the positions, or come with a number of samples.
    """
    if not velocities:
        at = time if samples is None else np.linspace(0.0, time[-1], samples)
        from scipy.interpolate import CubicSpline  # noqa: PLC0415 (slow to import, for tables without rates only)

        splines = [CubicSpline(time, values, bc_type="natural") for values in positions.values()]
        q, dq, ddq = (
            {joint: np.asarray(spline(at, order)) for joint, spline in zip(positions, splines, strict=True)}
            for order in range(3)
        )
        return JointTable(path, at, q, dq, ddq)
    if samples is not None:
        raise InputError(path, "a table with velocities keeps its own times: leave 'samples' out.", key="samples")
    kept = motion_rows(
        *(np.column_stack([part[name] for name in positions]) for part in (positions, velocities, accelerations))
    )
    time = time[kept] - time[kept][0]
    positions, velocities, accelerations = (
        {joint: values[kept] for joint, values in part.items()} for part in (positions, velocities, accelerations)
    )
    for joint, values in positions.items():
        columns = (values, velocities[joint], accelerations[joint])
        try:
            check_derivatives(joint, time, *(column[:, None] for column in columns))
        except InputError as error:
            raise InputError(path, error.rule, key=error.where) from None
    return JointTable(path, time, positions, velocities, accelerations)


def _read_columns(path: Path) -> dict[str, Array]:
    rows = _read_rows(path)
    names = _column_names(path, rows[0])
    values = np.empty((len(rows) - 1, len(names)))
    for index, row in enumerate(rows[1:]):
        if len(row) != len(names):
            raise InputError(path, f"has {len(row)} values for {len(names)} columns.", key=f"row {index + 1}")
        for column, text in enumerate(row):
            try:
                values[index, column] = float(text) if "_" not in text else np.nan
            except ValueError:
                values[index, column] = np.nan
            if not abs(values[index, column]) <= LARGEST_NUMBER:
                raise InputError(
                    path, "must be a finite number.", key=f"row {index + 1}, column {names[column]}", value=text
                )
    return {name: values[:, column].copy() for column, name in enumerate(names)}


def _read_rows(path: Path) -> list[list[str]]:
    """The line of names and at least two of values."""
    text = read_text(path, "table").removeprefix("\ufeff")  # the mark that spreadsheets put in front of UTF-8
    try:
        rows = [row for row in csv.reader(io.StringIO(text)) if row and "".join(row).strip()]
    except csv.Error as error:
        raise InputError(path, f"is no CSV table: {error}.") from None
    if not rows:
        raise InputError(path, "is empty: the first line names the columns.")
    if len(rows) < 3:  # noqa: PLR2004 (a name line and two samples)
        raise InputError(path, f"holds {len(rows) - 1} rows of values; a motion has at least 2.")
    return rows


def _column_names(path: Path, row: list[str]) -> list[str]:
    names = [name.strip() for name in row]
    if len(names) == 1:
        raise InputError(path, "has one column; separate columns by commas.", value=names[0])
    for name in names:
        if not name:
            raise InputError(path, "a column has no name: is there a comma too many in the first line?")
        if names.count(name) > 1:
            raise InputError(path, f"the column '{name}' stands twice.")
    return names


def _time(path: Path, columns: dict[str, Array]) -> Array:
    if "t" not in columns:
        raise InputError(path, f"a column 't' in s is needed; there are {', '.join(columns)}.")
    time = columns["t"]
    steps = np.diff(time)
    if np.min(steps) <= 0:
        row = int(np.argmax(steps <= 0)) + 2
        raise InputError(path, "must be later than the row before.", key=f"row {row}, column t", value=time[row - 1])
    if np.min(steps) < SHORTEST_STEP:
        row = int(np.argmin(steps)) + 2
        raise InputError(path, f"is less than {SHORTEST_STEP:g} s after the row before.", key=f"row {row}, column t")
    return np.asarray(time - time[0], dtype=np.float64)
