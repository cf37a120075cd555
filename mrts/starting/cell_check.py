# SPDX-License-Identifier: MIT
"""What a check found, as text and as JSON."""

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from mrts.base.atomic_file import JsonOutput
from mrts.base.errors import InputError
from mrts.base.formats.record import dumped
from mrts.base.printable import printable
from mrts.base.remark import Remark, Severity
from mrts.base.words import aligned
from mrts.cell.remarks import friction_sources, torque_source
from mrts.cell.robot import JOINT_HEAD, Robot
from mrts.collisions.clearance import Clearance
from mrts.starting.arm_reach import ArmReach

CheckStatus = Literal["fine", "impossible", "wrong-input"]
"""What came of a check: "impossible" is a motion that an arm does not follow from its posture."""

URDF_ENDINGS = (".urdf", ".xacro", ".xml")


@dataclass(frozen=True, kw_only=True, repr=False)
class CellCheck(JsonOutput):
    """What `mrts.check` found.

    Attributes:
        cell: The cell file, or the URDF; the name of a cell that was given itself.
        motion: The motion's file, "motion" where it is none; None if none was given.
        mistakes: All that breaks a rule, in both files and the URDFs.
        robots: The arms, with their joints and limits; empty if something breaks a rule.
        remarks: What to know of the cell and the motion, what is taken for granted included.
        arms: How far every arm follows the motion of an object; empty where that is not asked or not known.
        problem: Why the motion is impossible whatever the arms do, or as joints that are given; empty if it is not.
        clearance: How near bodies come to each other; None where that is not known.
    """

    cell: Path
    motion: Path | None = None
    mistakes: tuple[InputError, ...] = ()
    robots: tuple[Robot, ...] = ()
    remarks: tuple[Remark, ...] = ()
    arms: tuple[ArmReach, ...] = ()
    problem: str = ""
    clearance: Clearance | None = None

    @property
    def hints(self) -> tuple[Remark, ...]:
        """Likely mistakes among the remarks."""
        return self._of("hint")

    @property
    def warnings(self) -> tuple[Remark, ...]:
        """What to know before trusting an answer, among the remarks."""
        return self._of("warning")

    @property
    def assumed(self) -> tuple[Remark, ...]:
        """What is taken for granted, among the remarks."""
        return self._of("assumption")

    def _of(self, severity: Severity) -> tuple[Remark, ...]:
        return tuple(remark for remark in self.remarks if remark.severity == severity)

    @property
    def status(self) -> CheckStatus:
        """What came of it."""
        if self.mistakes:
            return "wrong-input"
        return "impossible" if self.problem or not all(arm.follows for arm in self.arms) else "fine"

    def __repr__(self) -> str:
        return printable("\n".join(self.lines()), lines=True)

    def lines(self) -> Iterator[str]:
        """The answer for people, the outcome first."""
        yield self.outcome()
        for number, mistake in enumerate(self.mistakes, start=1):
            yield f"  {number}. {mistake}"
        yield from map(str, (*self.hints, *self.warnings))
        if self.problem:
            yield f"  {self.problem}"
        if self.arms:
            yield ""
            for arm in self.arms:
                yield from arm.lines()
        if self.robots:
            yield ""
            yield from joint_table(self.robots)
        if self.assumed:
            yield ""
            yield "assumed:"
            yield from (f"  {remark.text}" for remark in self.assumed)
        if self.status == "fine" and self.cell.is_file():
            yield ""
            file, motion = shlex.quote(str(self.cell)), shlex.quote(str(self.motion or "MOTION"))
            yield f"next: mrts new DIR --robot {file}" if is_urdf(self.cell) else f"next: mrts scale {file} {motion}"

    def outcome(self) -> str:
        """What came of it, in a line."""
        if self.mistakes:
            count = len(self.mistakes)
            return f"{count} mistake{'s' if count > 1 else ''} in the files:"
        if self.status == "impossible":
            lost = [arm.robot for arm in self.arms if not arm.follows]
            who = f" {', '.join(lost)} do{'es' if len(lost) == 1 else ''} not follow it" if lost else ""
            return f"{self.cell.name}: the files are sound, but the motion is impossible{':' if who else ''}{who}"
        sound = "the URDF is sound" if is_urdf(self.cell) else "the files are sound"
        return f"{self.cell.name}: {sound}{', and the arms follow the motion' * (self.motion is not None)}"

    def to_json(self) -> dict[str, Any]:
        """All of it as values of JSON."""
        return {
            "status": self.status,
            "cell": str(self.cell),
            "motion": None if self.motion is None else str(self.motion),
            "mistakes": [
                {"where": each.where, "key": each.key or None, "rule": each.rule, "text": str(each)}
                for each in self.mistakes
            ],
            "hints": [remark.to_json() for remark in self.hints],
            "problem": self.problem or None,
            "arms": [dumped(arm) | {"follows": arm.follows} for arm in self.arms],
            "clearance": self.clearance and self.clearance.to_json(),
            "assumed": [remark.to_json() for remark in self.assumed],
            "warnings": [remark.to_json() for remark in self.warnings],
        }


def is_urdf(path: Path) -> bool:
    """Whether a file is a URDF, by its name."""
    return path.suffix.lower() in URDF_ENDINGS


def joint_table(robots: Sequence[Robot]) -> Iterator[str]:
    """What is known of every joint, as aligned lines."""
    rows: list[tuple[str, ...]] = [("arm", "joint", *JOINT_HEAD, "torque from", "friction", "armature")]
    for robot in robots:
        armature = ["none given" if inertia == 0 else f"{inertia:.4g}" for inertia in robot.motors.armature]
        sources = zip(friction_sources(robot), armature, strict=True)
        known = zip(robot.joint_rows(), sources, strict=True)
        rows += [(robot.name, *joint, torque_source(robot), *motor) for joint, motor in known]
    yield from aligned(rows)
