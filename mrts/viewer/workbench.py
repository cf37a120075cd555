# SPDX-License-Identifier: MIT
"""The workbench: choices, and answers to the newest of them, found beside the caller's work.

One thread finds them, one at a time; a newer question ends work on an older one. An answer comes once more with what
becomes of it in closed loop, where that is asked, and with how near bodies come to each other, unless something newer
was asked meanwhile.
"""

from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from queue import SimpleQueue

from mrts.base.errors import MotionError, MrtsError, Progress, Remark
from mrts.collisions.clearance import Clearance, clearance_remarks
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.simulation.simulate import Simulation, simulate
from mrts.viewer.choices import Choices, Given
from mrts.viewer.player_state import HeldPoses, PlayerState, held_poses, play, still_motion


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
