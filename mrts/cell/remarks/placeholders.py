# SPDX-License-Identifier: MIT
"""Effort limits of a URDF that say nothing of the motors: the same large number on every joint of an arm."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mrts.base.remark import EFFORT_PLACEHOLDERS, Remark
from mrts.cell.motors.joint_source import JointSource

if TYPE_CHECKING:
    from mrts.cell.cell import Cell
    from mrts.cell.robot import Robot

FEWEST_JOINTS = 3
"""Turning joints of an arm from which on equal efforts are no accident: of two, motors often are alike."""

ANY_JOINT = 1000.0
"""Effort that no arm has in each of its joints, the last included [N m]: only hips and first axes of heavy arms do."""

LARGE = 50.0
"""Effort that no small arm has any more [N m]: those of hobby servos and direct drives, whose motors may all be alike,
stay below."""

UNLIKE = 50.0
"""Times by which what the first joint holds at full stretch exceeds what the last does, from which on nobody puts the
same motor into both. Legs of walking robots, with one motor for all joints, have up to 25."""


def placeholder_efforts(cell: "Cell", joints: Sequence[JointSource]) -> dict[str, float]:
    """Names of the arms whose efforts look like placeholders, and the effort [N m]."""
    found = {}
    for robot in cell.robots:
        own = [joint for joint in joints if joint.robot == robot.name]
        efforts = [joint.torque[1] for joint in own if joint.unit == "rad"]
        if own[0].torque_from != "URDF" or len(efforts) < FEWEST_JOINTS or len({*efforts}) > 1:
            continue
        if efforts[0] >= ANY_JOINT or (efforts[0] >= LARGE and _share_of_load(robot, own) > UNLIKE):
            found[robot.name] = efforts[0]
    return found


def _share_of_load(robot: "Robot", joints: Sequence[JointSource]) -> float:
    """What the first joint of an arm holds at full stretch, as a multiple of what the last one does."""
    corners = np.concatenate([robot.points, robot.T_base_tip.p[None]])
    lengths = np.sqrt(np.sum(np.diff(corners, axis=0) ** 2, axis=1))
    first, last = sum(joint.carried_mass for joint in joints) * float(np.sum(lengths)), joints[-1].carried_mass
    least = last * float(lengths[-1])
    return first / least if least > 0 else np.inf if first > 0 else 0.0


def effort_remarks(placeholders: dict[str, float]) -> Iterator[Remark]:
    """That the efforts of some arms look like placeholders."""
    if placeholders:
        said = "; ".join(f"{value:g} N m on every joint of {name}" for name, value in placeholders.items())
        yield Remark(
            EFFORT_PLACEHOLDERS,
            f"the effort limits of the URDF look like placeholders: {said}. c² is as good as they are: give "
            "the data sheet's as 'torque' in the cell file.",
        )
