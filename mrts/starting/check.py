# SPDX-License-Identifier: MIT
"""Everything that is wrong with a cell and a motion at once, and whether each arm follows."""

import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.base.atomic_file import JsonOutput
from mrts.base.errors import (
    InputError,
    Mistakes,
    MotionError,
    Progress,
    Remark,
    Severity,
    as_path,
    check_callable,
    printable,
)
from mrts.base.formats.record import dumped
from mrts.base.words import aligned
from mrts.cell.cell import Cell, uncompiled_cell
from mrts.cell.generation import is_generated, read_without_generating
from mrts.cell.remarks import COLLISIONS_UNKNOWN, friction_sources, torque_source
from mrts.cell.robot import JOINT_HEAD, Robot
from mrts.following.clearance import Clearance, clearance_remarks
from mrts.following.coordinate import coordinate
from mrts.following.coordinated_motion import CoordinatedMotion, check_motion, follow_object
from mrts.following.tracking import branches_at_start, follow_from
from mrts.motion.joint_table import JointTable
from mrts.motion.motion_file import load_motion
from mrts.motion.object_motion import ObjectMotion

CheckStatus = Literal["fine", "impossible", "wrong-input"]
"""What came of a check: "impossible" is a motion that an arm does not follow from its posture."""

URDF_ENDINGS = (".urdf", ".xacro", ".xml")


OBJECTS = (Mapping, ObjectMotion, JointTable, CoordinatedMotion)
"""Of a motion that is no file."""

MOST_TRACKS = 16
"""Ways to hold the grasp that are followed, nearest to the posture first: an arm of six joints has no more."""

STARTS = 48
"""Random ones of an arm: ways that few of them lead to are not near any posture."""


@dataclass(frozen=True, kw_only=True)
class ArmReach:
    """Whether one arm follows the motion.

    Attributes:
        robot: Its name.
        failure: Why it does not follow from its posture; empty if it does.
        ways: Number of other ways to hold the grasp at t = 0 that were followed.
        posture: The one nearest to its own from which it follows; None where there is none, or where it is its own.
        nearest_limit: How near a joint comes to a position limit, which and when; empty if it does not follow.
    """

    robot: str
    failure: str = ""
    ways: int = 0
    posture: Array | None = None
    nearest_limit: str = ""

    @property
    def follows(self) -> bool:
        """Whether it does so from its posture."""
        return not self.failure

    def lines(self) -> Iterator[str]:
        """What came of it, for people."""
        if self.follows:
            yield f"robot '{self.robot}' follows the whole motion: {self.nearest_limit}."
            return
        yield self.failure
        if self.posture is not None:
            shown = ", ".join(f"{value:.4f}" for value in self.posture)
            yield f"  It follows from another posture: posture: [{shown}]"
        elif self.ways:
            yield f"  None of {self.ways} other ways to hold the grasp at t = 0 leads to the end."
        else:
            yield "  No posture holds its grasp at t = 0."


@dataclass(frozen=True, kw_only=True, repr=False)
class CellCheck(JsonOutput):
    """What `mrts.check` found.

    Attributes:
        cell: The cell file; the name of a cell that was given itself.
        motion: The motion's file, "motion" where it is none; None if none was given.
        mistakes: All that breaks a rule, in both files and the URDFs.
        robots: The arms, with their joints and limits; empty if something breaks a rule.
        remarks: What to know of the cell and the motion, what is taken for granted included.
        arms: Whether every arm follows the motion of an object; empty where that is not asked or not known.
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
        parts = [[line for arm in self.arms for line in arm.lines()]]
        parts.append(joint_table(self.robots) if self.robots else [])
        parts.append(["assumed:", *(f"  {remark.text}" for remark in self.assumed)] if self.assumed else [])
        if self.status == "fine" and self.cell.is_file():
            parts.append([f"next: mrts scale {shlex.join(map(str, (self.cell, self.motion or 'MOTION')))}"])
        for part in filter(None, parts):
            yield from ("", *part)

    def outcome(self) -> str:
        """What came of it, in a line."""
        if self.mistakes:
            count = len(self.mistakes)
            return f"{count} mistake{'s' if count > 1 else ''} in the files:"
        if self.status == "impossible":
            lost = [arm.robot for arm in self.arms if not arm.follows]
            who = f" {', '.join(lost)} do{'es' if len(lost) == 1 else ''} not follow it" if lost else ""
            return f"{self.cell.name}: the files are sound, but the motion is impossible{':' if who else ''}{who}"
        return f"{self.cell.name}: the files are sound{', and the arms follow the motion' * (self.motion is not None)}"

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


def check(
    cell: Cell | Path | str,
    motion: Path | str | Mapping[str, Any] | ObjectMotion | JointTable | CoordinatedMotion | None = None,
    *,
    progress: Progress = lambda _done, _total: None,
) -> CellCheck:
    """Check a cell file, its URDFs and a motion, and whether each arm follows it.

    Only the last needs a compiled library, a small one. What is wrong is found all at once and does not raise: it is
    listed in the answer.

    Args:
        cell: The cell file, or a cell, which is checked as the cell file that it writes: without limits of your own.
        motion: As in `mrts.load_motion`, or what that gives, or a motion of the whole cell; None checks the cell alone.
        progress: Told how many of how many arms are done.

    Raises:
        InputError: If an argument is none of these, the cell is a URDF or a folder of generated files, or no cell
            file can hold it.
    """
    check_callable("progress", progress)
    if isinstance(cell, Cell):
        with TemporaryDirectory() as folder:
            path = Path(folder) / "cell.yaml"
            cell.to_yaml(path)
            return replace(check(path, motion, progress=progress), cell=Path(cell.name))
    path = as_path("cell", cell)
    if path.suffix.lower() in URDF_ENDINGS:
        raise InputError(path, "is a URDF: give the cell file that names it; mrts new begins one.")
    named = None if motion is None else Path("motion") if isinstance(motion, OBJECTS) else as_path("motion", motion)
    if is_generated(path):
        raise InputError(path, "is generated; check the cell file that it was made from.")
    model, wrong = read_without_generating(path)
    mistakes = Mistakes(wrong)
    given: ObjectMotion | JointTable | CoordinatedMotion | None = None
    with mistakes.noted():
        given = load_motion(motion) if isinstance(motion, Path | str | Mapping) else motion
    found = CellCheck(cell=path, motion=named, mistakes=tuple(mistakes.found))
    if model is None:
        return found
    whole = uncompiled_cell(model, path.resolve().parent)
    found = replace(found, robots=whole.robots, remarks=whole.all_remarks)
    return found if given is None else _with_reach(found, model, whole, given, progress)


def _with_reach(
    found: CellCheck, model: Any, cell: Cell, motion: ObjectMotion | JointTable | CoordinatedMotion, progress: Progress
) -> CellCheck:
    if isinstance(motion, ObjectMotion):
        found = replace(found, remarks=(*found.remarks, *motion.remarks))
    try:
        if not isinstance(motion, ObjectMotion):
            closed = coordinate(cell, motion)
            return _with_clearance(replace(found, remarks=(*found.remarks, *closed.remarks)), cell, closed)
        check_motion(cell, motion)
    except InputError as error:
        return replace(found, mistakes=(*found.mistakes, *error.each()))
    except MotionError as error:
        return replace(found, problem=str(error))
    arms = [uncompiled_cell(alone, cell.folder or Path()) for alone in model.arms_alone()]
    reaches = []
    for number, arm in enumerate(arms):
        progress(number, len(arms))
        reaches.append(reach_of(arm, motion))
    progress(len(arms), len(arms))
    found = replace(found, arms=tuple(reaches))
    if found.status != "fine" or found.hints:  # collisions of a cell that is likely mistyped say little
        return found
    return _with_clearance(found, cell, motion)


def _with_clearance(found: CellCheck, cell: Cell, motion: ObjectMotion | CoordinatedMotion) -> CellCheck:
    """The same with the least distance between bodies in the place of the remark that it is not known."""
    near, said = clearance_remarks(cell, motion)
    others = [remark for remark in found.remarks if remark.code != COLLISIONS_UNKNOWN]
    return replace(found, clearance=near, remarks=(*others, *said))


def reach_of(arm: Cell, motion: ObjectMotion) -> ArmReach:
    """Whether an arm follows the object, and from which posture it does where it does not from its own."""
    (robot,) = arm.robots
    try:
        return ArmReach(robot=robot.name, nearest_limit=_nearest_limit(robot, follow_object(arm, motion)))
    except MotionError as error:
        failure = str(error)
    starts = branches_at_start(arm, 0, motion, STARTS)
    nearest = np.argsort(np.max(np.abs(starts - robot.posture), axis=1), kind="stable")
    starts = starts[nearest][:MOST_TRACKS]
    leads = np.flatnonzero(follow_from(arm, motion, starts).followed).tolist() if len(starts) else []
    posture = starts[leads[0]] if leads else None
    return ArmReach(robot=robot.name, failure=failure, ways=len(starts), posture=posture)


def _nearest_limit(robot: Robot, motion: CoordinatedMotion) -> str:
    room = np.minimum(motion.q - robot.position_lower, robot.position_upper - motion.q)
    sample, joint = np.unravel_index(int(np.argmin(room)), room.shape)
    if np.isinf(room[sample, joint]):
        return "no joint has a position limit"
    left, unit, time = room[sample, joint], robot.position_units[joint], motion.object.time[sample]
    return f"{left:.3g} {unit} from the limit of '{robot.joints[joint]}' at t = {time:.3g} s"


def joint_table(robots: Sequence[Robot]) -> list[str]:
    """What is known of every joint, as aligned lines."""
    rows: list[tuple[str, ...]] = [("arm", "joint", *JOINT_HEAD, "torque from", "friction", "armature")]
    for robot in robots:
        armature = ["none given" if inertia == 0 else f"{inertia:.4g}" for inertia in robot.motors.armature]
        sources = zip(friction_sources(robot), armature, strict=True)
        known = zip(robot.joint_rows(), sources, strict=True)
        rows += [(robot.name, *joint, torque_source(robot), *motor) for joint, motor in known]
    return list(aligned(rows))
