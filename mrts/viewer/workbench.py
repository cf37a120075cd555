# SPDX-License-Identifier: MIT
"""The workbench: choices with undo, and answers to the newest of them, found beside the caller's work.

One thread finds them, one at a time. An answer that takes long comes twice, coarse and then whole; a newer question
ends work on the whole one, and is answered between two configurations that are being ranked. The whole one comes once
more with how near bodies come to each other, unless something newer was asked meanwhile.
"""

from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from math import isfinite
from queue import SimpleQueue
from time import perf_counter

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array
from mrts.base.errors import InputError, MotionError, MrtsError
from mrts.base.remark import Remark
from mrts.collisions.clearance import Clearance, clearance_remarks
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion
from mrts.program.excess import BETWEEN
from mrts.scene.scene import Scene
from mrts.studies.configurations import ConfigurationStudy, rank_configurations
from mrts.viewer.choices import COARSE_SAMPLES, Choices, Given
from mrts.viewer.held_poses import HeldPoses, held_poses
from mrts.viewer.player_state import PlayerState, Profile

DEEPEST = 200
"""Choices that undo goes back."""

QUICK = 0.15
"""Where the whole answer took longer, a coarse one comes first the next time [s]: a hand on a slider waits for it."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What follows from choices.

    Attributes:
        choices: The choices.
        state: The motion at its first choice of speed, or at the speed that was asked for; None where there is none.
        held: Where arms are without a motion that can be played, or where none was given; None else.
        error: Why there is neither; None else.
        coarse: Whether it has few samples and keeps the limits at these alone; the whole answer follows.
        collisions: What `clearance_remarks` finds for the motion as it is given; None until it is looked at, at last.
    """

    choices: Choices
    state: PlayerState | None = None
    held: HeldPoses | None = None
    error: MrtsError | None = None
    coarse: bool = False
    collisions: tuple[Clearance | None, tuple[Remark, ...]] | None = None

    @property
    def scene(self) -> Scene:
        """What is drawn of it."""
        shown = self.state or self.held
        assert shown is not None  # noqa: S101 (errors are not drawn)
        return shown.scene

    @property
    def times(self) -> Array:
        """Of the samples that are drawn, Shape (k,) [s]."""
        if self.state is not None:
            return self.state.trajectory.time
        assert self.held is not None  # noqa: S101 (likewise)
        return self.held.time

    def clearance(self) -> tuple[Clearance | None, tuple[Remark, ...]]:
        """As `clearance_remarks`, at the speed that is played; nothing until it is known."""
        near, said = self.collisions or (None, ())
        if near is None or self.state is None:
            return near, said
        near = near.at_speed(self.state.trajectory.c)
        return near, near.remarks()

    @property
    def message(self) -> str:
        """Why the motion cannot be played; empty if it can, or none was given."""
        if self.held is not None:
            return self.held.message
        return "" if self.error is None else str(self.error)


def find_answer(given: Given, choices: Choices, progress: Progress, *, coarse: bool) -> Answer:
    """Find what follows from choices, at the first choice of speed.

    A coarse answer has few samples and keeps limits at these alone.
    """
    motion: ObjectMotion | JointTable | None = None
    try:
        cell, motion = choices.cell(given), choices.motion(given, COARSE_SAMPLES if coarse else None)
        if given.stands and isinstance(motion, ObjectMotion):
            return Answer(choices, held=held_poses(cell, motion))
        state = PlayerState(
            cell,
            motion,
            sharing=choices.sharing(),
            closure=given.closure,
            profile=choices.profile,
            rates=choices.torque_rate,
            between=None if coarse else BETWEEN,
            progress=progress,
        )
    except MrtsError as error:
        if isinstance(error, MotionError) and isinstance(motion, ObjectMotion):
            return Answer(choices, held=held_poses(cell, motion, str(error)))
        return Answer(choices, error=error)
    return Answer(choices, state, coarse=coarse)


_Request = tuple[Choices, float | None]
"""Choices, and the speed that they are to be played at; each by its identity."""


class Workbench:
    """Choices of one user, and the answer to the newest.

    Args:
        given: The cell and its motion as they were read.
        progress: Told how far the first answer is.

    Attributes:
        given: As given.
        choices: As they are now.
        answer: The newest that was taken.
        study: All configurations, once they are ranked.

    Raises:
        MrtsError: As `PlayerState`, where what was given has no answer.
    """

    def __init__(self, given: Given, progress: Progress = lambda _done, _total: None) -> None:
        self.given = given
        self.choices = Choices(shares=given.shares)
        self.study: ConfigurationStudy | None = None
        self._past: list[Choices] = []
        self._future: list[Choices] = []
        self._gesture = ""
        self._worker = ThreadPoolExecutor(1, "mrts workbench")
        self._jobs: list[Future[None]] = []
        self._ready: SimpleQueue[tuple[_Request | None, Answer | MrtsError | ConfigurationStudy]] = SimpleQueue()
        self._request: _Request | None = None
        self._answered: _Request | None = None
        self._taken: _Request | None = None
        self._ranking: Choices | None = None
        self._ranked = (0, 0)
        self._whole_took: dict[Profile, float] = {}
        self._known = self.answer = find_answer(given, self.choices, progress, coarse=False)
        if self.answer.error is not None:
            raise self.answer.error
        self._jobs.append(self._worker.submit(self._look_for_collisions, None, self.answer))

    @property
    def waits(self) -> bool:
        """Whether something was asked that is not answered yet, or not taken."""
        return not all(job.done() for job in self._jobs) or not self._ready.empty()

    @property
    def is_asked(self) -> bool:
        """Whether an answer to something newer is on its way than what was taken."""
        return self._taken is not self._request

    @property
    def ranked(self) -> tuple[int, int] | None:
        """How many of how many configurations are looked at; None where none are being ranked."""
        return None if self._ranking is None else self._ranked

    @property
    def fixed_configuration(self) -> str:
        """Why there are no other configurations to choose; empty if there are."""
        if self.given.stands:
            return "Configurations are ranked by how fast they can play a motion, and none was given."
        if isinstance(self.given.motion, ObjectMotion):
            return ""
        return "A table of joint motion fixes the configuration; only an object's motion leaves a choice."

    def edit(self, choices: Choices, gesture: str = "", *, speed: float | None = None) -> None:
        """Take other choices and ask for their answer.

        Args:
            choices: The choices.
            gesture: What is being moved: changes of one gesture are one step to undo. Empty is a step of its own.
            speed: To play at; None is the first choice.
        """
        if not gesture or gesture != self._gesture:
            self._past = [*self._past[1 - DEEPEST :], self.choices]
        self._gesture = gesture
        self._future.clear()
        self.choices = choices
        self.ask(speed)

    def end_gesture(self) -> None:
        """The next change is a step of its own."""
        self._gesture = ""

    def undo(self) -> None:
        """Go back to the choices before, if there are any."""
        self._go(self._past, self._future)

    def redo(self) -> None:
        """Go forward to the choices that were undone, if there are any."""
        self._go(self._future, self._past)

    def _go(self, there: list[Choices], back: list[Choices]) -> None:
        if there:
            back.append(self.choices)
            self._gesture, self.choices = "", there.pop()
            self.ask(None)

    def reset(self) -> None:
        """Choose what was given; one step to undo."""
        self.edit(Choices(shares=self.given.shares))

    def ask(self, speed: float | None) -> None:
        """Ask for the answer to the choices as they are; what was asked before and is not begun is dropped.

        Args:
            speed: To play at, the nearest on offer; None is the first choice.
        """
        self._request = (self.choices, speed)
        self._jobs.append(self._worker.submit(self._answer, self._request))

    def rank(self) -> None:
        """Ask for all configurations of the cell as it is; takes seconds, and answers come meanwhile."""
        self._ranking, self._ranked = self.choices, (0, 0)
        self._jobs.append(self._worker.submit(self._rank, self.choices))

    def stop_ranking(self) -> None:
        """Rank no further; what was ranked before stays."""
        self._ranking = None

    def configuration_labels(self) -> list[str]:
        """One a ranked configuration, such as "1: left 1, right 1, c²⁺ = 26.35"; none before they are ranked."""
        labels = []
        for rank, configuration in enumerate(self.study.ranked if self.study else (), start=1):
            branches = ", ".join(f"{branch.robot} {branch.number}" for branch in configuration.branches)
            c2, status = configuration.c2_upper, configuration.range.status.value
            labels.append(f"{rank}: {branches}, " + (f"c²⁺ = {c2:.4g}" if isfinite(c2) else status))
        return labels

    def with_configuration(self, choices: Choices, label: str) -> Choices:
        """Choices with a ranked configuration.

        Args:
            choices: The choices.
            label: Of `configuration_labels`; empty takes the one of the cell file.

        Raises:
            InputError: If there is none of that label.
        """
        if not label:
            return replace(choices, postures=None, configuration="")
        labels = self.configuration_labels()
        if self.study is None or label not in labels:
            raise InputError("configuration", "is none of those that were ranked.", value=label)
        postures = self.study.ranked[labels.index(label)].postures()
        return replace(choices, postures=postures, configuration=label)

    def take(self) -> list[Answer | MrtsError]:
        """What became ready since the last call, oldest first; configurations are kept in `study`."""
        done = [job for job in self._jobs if job.done()]
        self._jobs = [job for job in self._jobs if job not in done]
        for job in done:
            job.result()  # raises what a defect raised
        news: list[Answer | MrtsError] = []
        while not self._ready.empty():
            request, one = self._ready.get()
            if isinstance(one, ConfigurationStudy):
                self.study = one
                continue
            if isinstance(one, Answer):
                self._taken, self.answer = request, one
            news.append(one)
        return news

    def close(self) -> None:
        """Answer nothing more; what is being worked on ends by itself."""
        self._request = self._ranking = None
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _answer(self, request: _Request) -> None:
        if request is not self._request or request is self._answered:
            return
        coarse = self._whole_took.get(request[0].profile, QUICK) >= QUICK
        found = self._found(request, lambda _done, _total: None, coarse=coarse)
        self._ready.put((request, found))
        if found.coarse and request is self._request:
            with suppress(CancelledError):
                found = self._found(request, self._while_newest(request), coarse=False)
                self._ready.put((request, found))
        self._answered = request
        self._look_for_collisions(request, found)

    def _look_for_collisions(self, request: _Request | None, found: Answer) -> None:
        if found.state is None or found.coarse or found.collisions is not None or request is not self._request:
            return
        result = found.state.result
        with suppress(CancelledError):
            looked = clearance_remarks(result.cell, result.motion, self._while_newest(request))
            self._known = replace(self._known, collisions=looked)
            self._ready.put((request, replace(found, collisions=looked)))

    def _while_newest(self, request: _Request | None) -> Progress:
        """What ends work on a request once there is a newer one."""

        def progress(_done: int, _total: int) -> None:
            if request is not self._request:
                raise CancelledError

        return progress

    def _found(self, request: _Request, progress: Progress, *, coarse: bool) -> Answer:
        known, (choices, speed) = self._known, request
        if known.state is None or known.choices is not choices or (known.coarse and not coarse):
            begin = perf_counter()
            known = self._known = find_answer(self.given, choices, progress, coarse=coarse)
            if known.state is None:
                return known
            if not coarse:
                self._whole_took[choices.profile] = perf_counter() - begin
        speeds = known.state.speeds
        c = speeds.start if speed is None else min(max(speed, speeds.lower), speeds.upper)
        if speeds.c2(c) == known.state.trajectory.c2:
            return known
        try:
            return replace(known, state=known.state.at_speed(c))
        except MrtsError as error:
            return Answer(choices, error=error)

    def _rank(self, choices: Choices) -> None:
        def progress(done: int, total: int) -> None:
            while (request := self._request) is not None and request is not self._answered:
                self._answer(request)
            if self._ranking is not choices:
                raise CancelledError
            self._ranked = done, total

        try:
            motion, cell = choices.motion(self.given), choices.cell(self.given)
            if not isinstance(motion, ObjectMotion):
                raise InputError("configuration", self.fixed_configuration)
            study = rank_configurations(cell, motion, sharing=choices.sharing(), progress=progress)
            self._ready.put((None, study))
        except MrtsError as error:
            self._ready.put((None, error))
        except CancelledError:
            pass
        finally:
            if self._ranking is choices:
                self._ranking = None
