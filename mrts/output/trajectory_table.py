# SPDX-License-Identifier: MIT
"""The scaled trajectory as a table: one row a sample, and one before and after that hold still; docs/cell_file.md."""

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mrts.base.argument_types import as_path, check_type
from mrts.base.arrays import Array
from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import InputError
from mrts.motion.rows_at_rest import holding_step
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory


@dataclass(frozen=True)
class PlayedRows:
    """What a controller plays, R rows: the samples, with a row at rest before and after where it would push else.

    Attributes:
        time: From 0, Shape (R,) [s].
        q: Joint positions, Shape (R, m) [rad or m].
        dq: Joint velocities, Shape (R, m).
        ddq: Joint accelerations, Shape (R, m).
        torque: What the motors give, Shape (R, m) [N m or N].
        friction: The part of it that overcomes friction, none at rest; None where no motor has friction.
        wrench: Shape (R, n w) [N, N m].
    """

    time: Array
    q: Array
    dq: Array
    ddq: Array
    torque: Array
    friction: Array | None
    wrench: Array


def played_rows(done: ScaledTrajectory) -> PlayedRows:
    """The rows of a table or a bag."""
    samples = PlayedRows(
        time=done.time,
        q=done.q,
        dq=done.dq,
        ddq=done.ddq,
        torque=done.torque,
        friction=done.friction if done.has_friction else None,
        wrench=done.wrench,
    )
    held = done.holding
    if held is None or not any(held.ends):
        return samples
    before, after = (slice(int(end)) for end in held.ends)
    step, none = holding_step(done.time), np.zeros((1, done.q.shape[1]))

    def framed(start: Array, rows: Array, end: Array) -> Array:
        return np.concatenate([start[before], rows, end[after]])

    shifted = done.time + step * held.ends[0]
    return PlayedRows(
        time=framed(np.zeros(1), shifted, shifted[-1:] + step),
        q=framed(done.q[:1], done.q, done.q[-1:]),
        dq=framed(none, done.dq, none),
        ddq=framed(none, done.ddq, none),
        torque=framed(held.torque[:1], done.torque, held.torque[1:]),
        friction=None if samples.friction is None else framed(none, samples.friction, none),
        wrench=framed(held.wrench[:1], done.wrench, held.wrench[1:]),
    )


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
    joints = result.cell.joint_names
    wrenches = [f"{robot.name}/{part}" for robot in result.cell.robots for part in result.cell.wrench_components]
    of_joints = {"q": rows.q, "dq": rows.dq, "ddq": rows.ddq, "tau": rows.torque}
    of_joints |= {} if rows.friction is None else {"tau_friction": rows.friction}
    head = ["t", *(f"{kind}.{joint}" for kind in of_joints for joint in joints)]
    head += [f"F.{wrench}" for wrench in wrenches]
    table = np.column_stack([rows.time, *of_joints.values(), rows.wrench])
    return dict(zip(head, table.T, strict=True))


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
