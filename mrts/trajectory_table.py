# SPDX-License-Identifier: MIT
"""The scaled trajectory as a CSV table: one row a sample, units in docs/cell_file.md."""

import csv
import io
from pathlib import Path

import numpy as np

from mrts.argument_types import as_path, check_type
from mrts.atomic_file import write_text_atomically
from mrts.errors import InputError
from mrts.result import ScalingResult


def trajectory_csv(result: ScalingResult) -> str:
    """Columns t, then q.ROBOT/JOINT, dq., ddq. and tau. of every joint, then F.ROBOT/COMPONENT, at the chosen speed.

    Args:
        result: A result with a trajectory.

    Raises:
        InputError: If there is none.
    """
    check_type("result", result, ScalingResult)
    done = result.trajectory
    if done is None:
        raise InputError("trajectory", "there is none to write: no c² was chosen.", value=result.status.value)
    joints = [f"{robot.name}/{joint}" for robot in result.cell.robots for joint in robot.joints]
    wrenches = [f"{robot.name}/{part}" for robot in result.cell.robots for part in result.cell.wrench_components]
    head = ["t", *(f"{kind}.{joint}" for kind in ("q", "dq", "ddq", "tau") for joint in joints)]
    head += [f"F.{wrench}" for wrench in wrenches]
    table = np.column_stack([done.time, done.q, done.dq, done.ddq, done.torque, done.wrench])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([repr(value) for value in row] for row in table.tolist())
    return text.getvalue()


def write_trajectory_csv(result: ScalingResult, path: Path | str) -> None:
    """Write `trajectory_csv` to a file, whole or not at all.

    Raises:
        InputError: If there is no trajectory, or the file cannot be written.
    """
    write_text_atomically(as_path("path", path), trajectory_csv(result))
