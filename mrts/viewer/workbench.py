# SPDX-License-Identifier: MIT
"""The workbench: choices, and answers to the newest of them, found beside the caller's work.

One thread finds them, one at a time; a newer question ends work on an older one. An answer comes once more with what
becomes of it in closed loop, where that is asked, and with how near bodies come to each other, unless something newer
was asked meanwhile.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field, replace
from queue import SimpleQueue
from typing import Any, Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import MotionError, MrtsError, Progress, Remark
from mrts.base.formats.record import Pose
from mrts.base.rigid_transform import RigidTransform, rotations_from_vectors
from mrts.base.yaml_text import yaml_text
from mrts.cell.cell import Cell
from mrts.cell.cell_change import CellChange, Changed, machine_of, with_machine_at
from mrts.cell.cell_keys import cell_keys, pose_keys
from mrts.control.simulate import Simulation, simulate
from mrts.following.clearance import Clearance, clearance_remarks
from mrts.motion.joint_table import JointTable
from mrts.motion.motion_file import MotionDescription, load_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.viewer.player_state import HeldPoses, PlayerState, Profile, held_poses, play, still_motion

TORQUE_RATE = 11.0
"""Of the smooth profile, where the cell gives none: a multiple of the torque limit per second [1/s]; a Panda's."""

DECIMALS = 6
"""Of a position that was moved [m]: what is less is rounding."""


@dataclass(frozen=True, eq=False)
class Given:
    """What a workbench starts from.

    Attributes:
        cell: The cell.
        motion: Its motion; None looks at the cell, which stands with the object in the first arm's hand.
        description: Of a motion from pose to pose or through waypoints, whose ends can be moved; None of a table.
        asked: Options of `mrts.scale`.
    """

    cell: Cell
    motion: ObjectMotion | JointTable | None
    description: MotionDescription | None = None
    asked: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Place:
    """What can be moved: a base in the world, a grasp in the object's frame, or an end of the motion, no robot."""

    kind: Literal["base", "grasp", "start", "end"]
    robot: str = ""

    def __str__(self) -> str:
        return f"{self.robot} {self.kind}" if self.robot else f"{self.kind} of the motion"

    def given(self, given: Given) -> RigidTransform:
        """Its pose as it was given."""
        if not self.robot:
            described = given.description
            assert described is not None  # noqa: S101 (else it is no place)
            poses: Sequence[Pose | None] = described.waypoints or [described.start, described.end]
            pose = poses[0 if self.kind == "start" else -1]
            assert pose is not None  # noqa: S101 (a description has either)
            return pose.transform
        robot = next(robot for robot in given.cell.robots if robot.name == self.robot)
        return robot.T_world_base if self.kind == "base" else robot.T_object_tip


def places(given: Given) -> list[Place]:
    """All that can be moved: of a machine with several arms the base of the first, of a table's motion no end."""
    cell = given.cell
    bases = [Place("base", robot.name) for robot in cell.robots if machine_of(cell, robot.name)[0] == robot.name]
    grasps = [Place("grasp", robot.name) for robot in cell.robots]
    return [*bases, *grasps, *([Place("start"), Place("end")] if given.description is not None else [])]


@dataclass(frozen=True, kw_only=True)
class Choices:
    """What differs from what was given; as they are, nothing does.

    Attributes:
        mass: Of the object [kg]; None is the given one.
        limits: Share of a given limit by its name, both sides alike.
        offsets: Of places that were moved, from where they were given: shift [m], turn as a vector [rad].
        torque_rate: Of the smooth profile, for joints whose rate is not known [1/s].
        speed: That it is played at, the nearest on offer; None is the first choice.
        simulated: Whether a controller plays the motion too, as `mrts.simulate` does.
    """

    mass: float | None = None
    limits: Mapping[Changed, float] = field(default_factory=dict)
    offsets: Mapping[Place, tuple[float, ...]] = field(default_factory=dict)
    profile: Profile = "constant"
    torque_rate: float = TORQUE_RATE
    speed: float | None = None
    simulated: bool = False

    def cell(self, given: Given) -> Cell:
        """The cell as it was chosen.

        Raises:
            InputError: If a number breaks a rule of the cell.
        """
        cell = given.cell
        for (kind, robot, element), share in self.limits.items():
            cell = CellChange(kind=kind, robot=robot, element=element, step=share - 1).applied(cell)
        values: dict[str, object] = {} if self.mass is None else {"object.mass": self.mass}
        for place, pose in self.poses(given).items():
            if place.kind == "base":
                cell = with_machine_at(cell, place.robot, pose)
            elif place.kind == "grasp":
                values[f"robots.{place.robot}.grasp"] = pose
        return cell.with_values(values)

    def motion(self, given: Given) -> ObjectMotion | JointTable | None:
        """The motion as it was chosen, if there is one.

        Raises:
            InputError: If two waypoints became the same.
        """
        described = given.description
        moved: dict[str, Any] = {
            place.kind: Pose(**pose_keys(pose)) for place, pose in self.poses(given).items() if not place.robot
        }
        if described is None or not moved:
            return given.motion
        keys = {key: value for key, value in described if value is not None}
        if described.waypoints:
            start, *between, end = described.waypoints
            moved = {"waypoints": [moved.get("start", start), *between, moved.get("end", end)]}
        return load_motion(keys | moved)

    def with_limit(self, name: Changed, share: float) -> "Choices":
        """With another share of a limit."""
        others = {key: value for key, value in self.limits.items() if key != name}
        return replace(self, limits=others if share == 1 else others | {name: share})

    def with_offset(self, place: Place, offset: Array) -> "Choices":
        """With a place elsewhere, of a base with all of its machine."""
        return replace(self, offsets={**self.offsets, place: tuple(offset.tolist())})

    def offset(self, place: Place) -> Array:
        """How far a place is from where it was given, Shape (6,)."""
        return np.array(self.offsets.get(place, np.zeros(6)))

    def poses(self, given: Given) -> dict[Place, RigidTransform]:
        """Of places that were moved; positions are rounded."""
        moved = {}
        for place in self.offsets:
            start, offset = place.given(given), self.offset(place)
            turn = rotations_from_vectors(offset[None, 3:])[0]
            moved[place] = RigidTransform(turn @ start.R, np.round(start.p + offset[:3], DECIMALS))
        return moved


def changed_keys(given: Given, choices: Choices) -> list[str]:
    """What was changed: keys of the cell file as of `Cell.with_values`, and of the motion file, with their values."""
    before, after = cell_keys(given.cell), cell_keys(choices.cell(given))
    parts = [("object", before["object"], after["object"])]
    parts += [(f"robots.{new['name']}", old, new) for old, new in zip(before["robots"], after["robots"], strict=True)]
    lines = [
        f"{where}.{key}: {yaml_text(value, one_line=True)}"
        for where, old, new in parts
        for key, value in new.items()
        if value != old[key] and key != "contact"
    ]
    lines += [  # several keys of a contact say it, or none
        f"robots.{robot}.contact: {element} × {share:.4g}"
        for (kind, robot, element), share in choices.limits.items()
        if kind == "contact"
    ]
    ends = {place.kind: pose_keys(pose) for place, pose in choices.poses(given).items() if not place.robot}
    return [*lines, *(f"{end}: {yaml_text(keys, one_line=True)}" for end, keys in ends.items())]


@dataclass(frozen=True, eq=False)
class Answer:
    """What follows from choices.

    Attributes:
        choices: The choices.
        shown: The motion at its first choice of speed, or at the speed that was asked for; or where arms are without a
            motion that can be played, or where none was given; or why there is neither.
        simulation: What became of the motion in closed loop, or why that is not known; None where it was not asked.
        collisions: What `clearance_remarks` finds for the motion as it is given; None until it is looked at, at last.
    """

    choices: Choices
    shown: PlayerState | HeldPoses | MrtsError
    simulation: Simulation | MrtsError | None = None
    collisions: tuple[Clearance | None, tuple[Remark, ...]] | None = None

    @property
    def state(self) -> PlayerState | None:
        """The motion, if it can be played."""
        return self.shown if isinstance(self.shown, PlayerState) else None

    def clearance(self) -> tuple[Clearance | None, tuple[Remark, ...]]:
        """As `clearance_remarks`, at the speed that is played; nothing until it is known."""
        near, said = self.collisions or (None, ())
        if near is None or self.state is None:
            return near, said
        near = near.at_speed(self.state.trajectory.c)
        return near, near.remarks()


def find_answer(given: Given, choices: Choices, progress: Progress) -> Answer:
    """Find what follows from choices, at the first choice of speed."""
    motion: ObjectMotion | JointTable | None = None
    try:
        cell, motion = choices.cell(given), choices.motion(given)
        if motion is None:
            return Answer(choices, held_poses(cell, still_motion(given.cell)))
        profile, rates = choices.profile, choices.torque_rate
        state = play(cell, motion, profile=profile, rates=rates, progress=progress, **given.asked)
    except MrtsError as error:
        if isinstance(error, MotionError) and isinstance(motion, ObjectMotion):
            return Answer(choices, held_poses(cell, motion, str(error)))
        return Answer(choices, error)
    return Answer(choices, state)


def _simulated(state: PlayerState) -> Simulation | MrtsError:
    try:
        return simulate(state.trajectory)
    except MrtsError as error:
        return error


class Workbench:
    """Choices of one user, and the newest answer that was taken.

    Raises:
        MrtsError: As `play`, where what was given has no answer.
    """

    def __init__(self, given: Given, progress: Progress = lambda _done, _total: None) -> None:
        self.given, self.choices = given, Choices()
        self._worker = ThreadPoolExecutor(1, "mrts workbench")
        self._jobs: list[Future[None]] = []
        self._ready: SimpleQueue[Answer] = SimpleQueue()
        self._known = self.answer = find_answer(given, self.choices, progress)
        if isinstance(self.answer.shown, MrtsError):
            raise self.answer.shown
        self._jobs.append(self._worker.submit(self._look_for_collisions, self.answer))

    @property
    def waits(self) -> bool:
        """Whether something was asked that is not answered yet, or not taken."""
        return not all(job.done() for job in self._jobs) or not self._ready.empty()

    @property
    def is_asked(self) -> bool:
        """Whether an answer to something newer is on its way than what was taken."""
        return self.answer.choices is not self.choices

    def edit(self, choices: Choices) -> None:
        """Take other choices and ask for their answer; what was asked before is dropped."""
        self.choices = choices
        self._jobs.append(self._worker.submit(self._answer, choices))

    def take(self) -> list[Answer]:
        """What became ready since the last call, oldest first."""
        done = [job for job in self._jobs if job.done()]
        self._jobs = [job for job in self._jobs if job not in done]
        for job in done:
            job.result()  # raises what a defect raised
        news: list[Answer] = []
        while not self._ready.empty():
            self.answer = self._ready.get()
            news.append(self.answer)
        return news

    def close(self) -> None:
        """Answer nothing more; what is being worked on ends by itself."""
        self.choices = Choices()
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _answer(self, choices: Choices) -> None:
        with suppress(CancelledError):
            progress = self._while_newest(choices)
            progress(0, 0)
            found = self._found(choices, progress)
            self._ready.put(found)
            if found.state is not None and choices.simulated:
                found = replace(found, simulation=_simulated(found.state))
                self._ready.put(found)
            self._look_for_collisions(found)

    def _look_for_collisions(self, found: Answer) -> None:
        if found.state is None or found.collisions is not None:
            return
        result = found.state.result
        with suppress(CancelledError):
            looked = clearance_remarks(result.cell, result.motion, self._while_newest(found.choices))
            self._known = replace(self._known, collisions=looked)
            self._ready.put(replace(found, collisions=looked))

    def _while_newest(self, choices: Choices) -> Progress:
        """What ends work on choices once there are newer ones."""

        def progress(_done: int, _total: int) -> None:
            if choices is not self.choices:
                raise CancelledError

        return progress

    def _found(self, choices: Choices, progress: Progress) -> Answer:
        if replace(self._known.choices, speed=choices.speed) != choices:
            self._known = find_answer(self.given, choices, progress)
        known = replace(self._known, choices=choices)
        if known.state is None:
            return known
        speeds, c = known.state.speeds, choices.speed
        c = speeds.start if c is None else min(max(c, speeds.lower), speeds.upper)
        if speeds.c2(c) == known.state.trajectory.c2:
            return known
        try:
            return replace(known, shown=known.state.at_speed(c))
        except MrtsError as error:
            return Answer(choices, error)
