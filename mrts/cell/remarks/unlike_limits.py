# SPDX-License-Identifier: MIT
"""Limits that differ between arms that are alike: one is mistyped in a URDF or in the cell file."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from mrts.base.remark import Remark
from mrts.cell.motors.joint_source import JointSource

if TYPE_CHECKING:
    from mrts.cell.cell import Cell
    from mrts.cell.robot import Robot

TENFOLD = 9.99
"""Ratio of two limits from which on one of them is mistyped: a decimal point that slipped, but for rounding."""

ALIKE = 1e-6
"""Share by which masses and lengths of arms that are alike may differ: their URDFs may be printed with few digits."""


@dataclass(frozen=True)
class _Unlike:
    """One limit of two joints.

    Attributes:
        joints: Of which arms.
        kind: Of limit.
        values: Of each joint.
        sources: Where each value is from.
        unit: Of the values.
    """

    joints: tuple[JointSource, JointSource]
    kind: str
    values: tuple[float, float]
    sources: tuple[str, str]
    unit: str

    @property
    def ratio(self) -> float:
        """Of the larger to the smaller."""
        return max(self.values) / min(self.values)


def unlike_limits(cell: "Cell", joints: Sequence[JointSource]) -> Iterator[Remark]:
    """The torque or velocity limits that differ most between arms that are alike, if they differ tenfold."""
    arms = [(robot, [joint for joint in joints if joint.robot == robot.name]) for robot in cell.robots]
    found = [
        unlike
        for (one, of_one), (other, of_other) in combinations(arms, 2)
        if _alike(one, other, of_one, of_other)
        for pair in zip(of_one, of_other, strict=True)
        for unlike in _limits(*pair)
        if unlike.ratio > TENFOLD
    ]
    if found:
        worst = max(found, key=lambda unlike: unlike.ratio)
        said = [
            f"{joint.joint} of robot '{joint.robot}', {value:.4g} {worst.unit} ({source}),"
            for joint, value, source in zip(worst.joints, worst.values, worst.sources, strict=True)
        ]
        yield Remark.hint(
            "limits-unlike",
            f"the {worst.kind} limits of {said[0]} and of {said[1]} differ {worst.ratio:.3g}-fold, and the two arms "
            "are alike: one of them seems to be mistyped.",
        )


def _alike(one: "Robot", other: "Robot", of_one: Sequence[JointSource], of_other: Sequence[JointSource]) -> bool:
    """Whether two arms have the same joints in the same distances, and links of the same masses."""
    if one.joint_types != other.joint_types:
        return False
    sizes = (
        [*(joint.carried_mass for joint in own), *np.linalg.norm(np.diff(robot.points, axis=0), axis=1)]
        for robot, own in ((one, of_one), (other, of_other))
    )
    return all(np.isclose(size, same, rtol=ALIKE, atol=ALIKE) for size, same in zip(*sizes, strict=True))


def _limits(one: JointSource, other: JointSource) -> Iterator[_Unlike]:
    force, speed = ("N", "m/s") if one.unit == "m" else ("N m", "rad/s")
    torques = max(map(abs, one.torque)), max(map(abs, other.torque))
    if min(torques) > 0:
        yield _Unlike((one, other), "torque", torques, (one.torque_from, other.torque_from), force)
    if one.velocity and other.velocity:
        yield _Unlike((one, other), "velocity", (one.velocity, other.velocity), ("URDF", "URDF"), speed)
