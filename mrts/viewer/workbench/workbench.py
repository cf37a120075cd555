# SPDX-License-Identifier: MIT
"""The workbench: choices with undo, and answers to the newest of them, found beside the caller's work."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isfinite
from threading import Condition, Thread
from time import perf_counter

from mrts.base.argument_types import Progress
from mrts.base.errors import InputError, MotionError, MrtsError
from mrts.motion.object_motion import ObjectMotion
from mrts.refinement.excess import BETWEEN
from mrts.studies.configurations import ConfigurationStudy, rank_configurations
from mrts.viewer.player_state import PlayerState
from mrts.viewer.workbench.choices import Choices, Given
from mrts.viewer.workbench.unreached import Unreached, find_unreached

DEEPEST = 200
"""Choices that undo goes back."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What follows from choices.

    Attributes:
        choices: The choices.
        state: The motion at its first choice of speed, or at the speed that was asked for; None where there is none.
        unreached: Where arms do not reach; None where they do.
        error: Why there is neither; None else.
        seconds: That it took.
        draft: Whether limits between the samples of a timing are left for the next answer.
    """

    choices: Choices
    state: PlayerState | None
    unreached: Unreached | None = None
    error: MrtsError | None = None
    seconds: float = 0.0
    draft: bool = False

    @property
    def message(self) -> str:
        """Why the motion cannot be played; empty if it can."""
        if self.unreached is not None:
            return self.unreached.message
        return "" if self.error is None else str(self.error)


_News = Answer | ConfigurationStudy | Exception


@dataclass(frozen=True, eq=False)
class _Wish:
    choices: Choices
    speed: float | None
    draft: bool


class Workbench:
    """Choices of one user, and the answer to the newest.

    Args:
        given: The cell and its motion as they were read.
        progress: Told how far the first answer is.

    Attributes:
        given: As given.
        choices: As they are now.
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
        self._wish: _Wish | None = None
        self._ready: list[_News] = []
        self._known: Answer | None = None
        self._task: Callable[[], ConfigurationStudy] | None = None
        self._at_work: _Wish | Callable[[], ConfigurationStudy] | None = None
        self._closed = False
        self._changed = Condition()
        self._progress = progress
        self._worker: Thread | None = None
        self._latest = self._answered(_Wish(self.choices, None, draft=False))
        if self._latest.error is not None:
            raise self._latest.error

    @property
    def answer(self) -> Answer:
        """The newest answer that was taken."""
        return self._latest

    @property
    def waits(self) -> bool:
        """Whether something was asked that is not answered yet, or not taken."""
        with self._changed:
            return any((self._at_work, self._wish, self._task, self._ready))

    @property
    def is_asked(self) -> bool:
        """Whether an answer is on its way, newer than what was taken."""
        with self._changed:
            on_its_way = isinstance(self._at_work, _Wish) or self._wish is not None
            return on_its_way or any(isinstance(one, Answer) for one in self._ready)

    @property
    def fixed_configuration(self) -> str:
        """Why there are no other configurations to choose; empty if there are."""
        if isinstance(self.given.motion, ObjectMotion):
            return ""
        return "A table of joint motion fixes the configuration; only an object's motion leaves a choice."

    def edit(self, choices: Choices, gesture: str = "", *, draft: bool = False, speed: float | None = None) -> None:
        """Take other choices and ask for their answer.

        Args:
            choices: The choices.
            gesture: What is being moved: changes of one gesture are one step to undo. Empty is a step of its own.
            draft: Whether more of the gesture is to come: a timing then keeps its limits at the samples only.
            speed: To play at; None is the first choice.
        """
        if not gesture or gesture != self._gesture:
            self._past = [*self._past[1 - DEEPEST :], self.choices]
        self._gesture = gesture
        self._future.clear()
        self.choices = choices
        self.ask(speed, draft=draft)

    def end_gesture(self) -> None:
        """The next change is a step of its own."""
        self._gesture = ""

    def undo(self) -> None:
        """Go back to the choices before, if there are any."""
        if self._past:
            self._future.append(self.choices)
            self._go(self._past.pop())

    def redo(self) -> None:
        """Go forward to the choices that were undone, if there are any."""
        if self._future:
            self._past.append(self.choices)
            self._go(self._future.pop())

    def reset(self) -> None:
        """Choose what was given; one step to undo."""
        self.edit(Choices(shares=self.given.shares))

    def _go(self, choices: Choices) -> None:
        self._gesture, self.choices = "", choices
        self.ask(None)

    def ask(self, speed: float | None, *, draft: bool = False) -> None:
        """Ask for the answer to the choices as they are; what was asked before and is not begun is dropped.

        Args:
            speed: To play at; None is the first choice.
            draft: As in `edit`.
        """
        with self._changed:
            self._wish = _Wish(self.choices, speed, draft)
            self._start()

    def rank(self) -> None:
        """Ask for all configurations of the cell as it is; takes seconds."""
        given, choices = self.given, self.choices

        def ranked() -> ConfigurationStudy:
            motion = choices.motion(given)
            if not isinstance(motion, ObjectMotion):
                raise InputError("configuration", self.fixed_configuration)
            return rank_configurations(choices.cell(given), motion, sharing=choices.sharing())

        with self._changed:
            self._task = ranked
            self._start()

    def configuration_labels(self) -> list[str]:
        """One a ranked configuration, such as "1: left 1, right 1, c²⁺ = 26.35"; none before they are ranked."""
        labels = []
        for rank, configuration in enumerate(self.study.ranked if self.study else (), start=1):
            branches = ", ".join(f"{branch.robot} {branch.number}" for branch in configuration.branches)
            c2, status = configuration.c2_upper, configuration.range.status.value
            labels.append(f"{rank}: {branches}, " + (f"c²⁺ = {c2:.4g}" if isfinite(c2) else status))
        return labels

    def with_configuration(self, label: str) -> Choices:
        """The choices with a ranked configuration.

        Args:
            label: Of `configuration_labels`; empty takes the one of the cell file.

        Raises:
            InputError: If there is none of that label.
        """
        if not label:
            return replace(self.choices, postures=None, configuration="")
        labels = self.configuration_labels()
        if self.study is None or label not in labels:
            raise InputError("configuration", "is none of those that were ranked.", value=label)
        postures = self.study.ranked[labels.index(label)].postures()
        return replace(self.choices, postures=postures, configuration=label)

    def take(self) -> list[Answer | MrtsError]:
        """What became ready since the last call, oldest first; configurations are kept in `study`."""
        with self._changed:
            ready, self._ready = self._ready, []
        news: list[Answer | MrtsError] = []
        for one in ready:
            if isinstance(one, ConfigurationStudy):
                self.study = one
            elif not isinstance(one, Answer | MrtsError):
                raise one
            else:
                self._latest = one if isinstance(one, Answer) else self._latest
                news.append(one)
        return news

    def close(self) -> None:
        """Answer nothing more; what is being worked on ends by itself."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _start(self) -> None:
        """Wake the worker; holds the lock."""
        if self._worker is None and not self._closed:
            self._worker = Thread(target=self._work, name="mrts workbench", daemon=True)
            self._worker.start()
        self._changed.notify_all()

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or self._wish is not None or self._task is not None)
                if self._closed:
                    return
                wish, task = self._wish, self._task
                self._wish = None
                if wish is None:
                    self._task = None
                self._at_work = wish or task
            done: _News
            try:
                if wish is not None:
                    done = self._answered(wish)
                elif task is not None:
                    done = task()
            except Exception as error:  # noqa: BLE001 (raised again where the answers are taken)
                done = error
            with self._changed:
                self._ready.append(done)
                self._at_work = None

    def _answered(self, wish: _Wish) -> Answer:
        begin = perf_counter()
        found = self._found(wish)
        self._known = found if found.state is not None else None
        return replace(found, seconds=perf_counter() - begin)

    def _found(self, wish: _Wish) -> Answer:
        choices, given, known = wish.choices, self.given, self._known
        try:
            if known is not None and known.choices is choices and known.state is not None and not known.draft:
                speed = known.state.speeds.start if wish.speed is None else wish.speed
                return Answer(choices, known.state.at_speed(speed))
            cell, motion = choices.cell(given), choices.motion(given)
        except MrtsError as error:
            return Answer(choices, None, error=error)
        try:
            state = PlayerState(
                cell,
                motion,
                sharing=choices.sharing(),
                closure=given.closure,
                profile=choices.profile,
                rates=choices.torque_rate,
                between=None if wish.draft and choices.profile != "constant" else BETWEEN,
                progress=self._progress,
            )
            if wish.speed is not None:
                speeds = state.speeds
                state.choose_speed(min(max(wish.speed, speeds.lower), speeds.upper))
        except MotionError as error:
            if not isinstance(motion, ObjectMotion):
                return Answer(choices, None, error=error)
            return Answer(choices, None, unreached=find_unreached(cell, motion, str(error)))
        except MrtsError as error:
            return Answer(choices, None, error=error)
        return Answer(choices, state, draft=wish.draft and choices.profile != "constant")
