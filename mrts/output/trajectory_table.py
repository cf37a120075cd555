# SPDX-License-Identifier: MIT
"""The scaled trajectory as a table: one row a sample, and one before and after that hold still; docs/cell_file.md."""

import csv
import io
from pathlib import Path

import numpy as np

from mrts.base.arrays import Array
from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import InputError, as_path, check_type
from mrts.motion.rows_at_rest import holding_step
from mrts.scaling.scale import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory


def played_rows(done: ScaledTrajectory) -> dict[str, Array]:
    """What a controller plays: the samples, with a row at rest before and after where it would push else.

    Returns:
        R rows each: "t" from 0 [s]; "q", "dq", "ddq" and "tau" of all joints, where there is friction "tau_friction",
        the part of the torque that overcomes it, none at rest; "F" of all wrenches.
    """
    rows = {"t": done.time, "q": done.q, "dq": done.dq, "ddq": done.ddq, "tau": done.torque}
    rows |= {"tau_friction": done.friction} if done.has_friction else {}
    rows["F"] = done.wrench
    held = done.holding
    if held is None or not any(held.ends):
        return rows
    before, after = map(int, held.ends)
    step = holding_step(done.time) if held.rate is None else 1 / held.rate
    rows["t"] = done.time + step * before
    ends = {name: np.zeros((2, *values.shape[1:])) for name, values in rows.items()}
    ends |= {"t": np.array([0.0, rows["t"][-1] + step]), "q": done.q[[0, -1]], "tau": held.torque, "F": held.wrench}
    played = {name: np.concatenate([ends[name][:before], of, ends[name][2 - after :]]) for name, of in rows.items()}
    return played if held.rate is None else played | {"t": np.arange(len(played["t"])) / held.rate}


def trajectory_to_write(result: ScalingResult) -> ScaledTrajectory:
    """The trajectory of a result."""
    check_type("result", result, ScalingResult)
    if result.trajectory is None:
        raise InputError("trajectory", "there is none to write: no c² was chosen.", value=result.status.value)
    return result.trajectory


def trajectory_columns(result: ScalingResult) -> dict[str, Array]:
    """Columns t, then q.ROBOT/JOINT, dq., ddq. and tau. of every joint, then F.ROBOT/COMPONENT, each Shape (R,).

    Where motors have friction, tau_friction. of every joint follows tau.: the part of it that overcomes friction.

    Raises:
        InputError: If there is none.
    """
    rows = played_rows(trajectory_to_write(result))
    wrenches = [f"{robot.name}/{part}" for robot in result.cell.robots for part in result.cell.wrench_components]
    columns = {"t": rows.pop("t")}
    for kind, values in rows.items():
        names = wrenches if kind == "F" else result.cell.joint_names
        columns |= {f"{kind}.{name}": column for name, column in zip(names, values.T, strict=True)}
    return columns


def trajectory_csv(result: ScalingResult) -> str:
    """The `trajectory_columns` at the chosen speed, one row a sample."""
    columns = trajectory_columns(result)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([repr(value) for value in row] for row in np.column_stack(list(columns.values())).tolist())
    return text.getvalue()


def write_trajectory_csv(result: ScalingResult, path: Path | str) -> None:
    """Write `trajectory_csv` to a file, whole or not at all.

    Raises:
        InputError: If there is no trajectory, or the file cannot be written.
    """
    write_text_atomically(as_path("path", path), trajectory_csv(result))
