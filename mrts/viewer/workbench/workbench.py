# SPDX-License-Identifier: MIT
"""The workbench: choices with undo, and answers to the newest of them, found beside the caller's work.

One thread finds them, one at a time. An answer that takes long comes twice, coarse and then whole; a newer question
ends work on the whole one, and is answered between two configurations that are being ranked.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from threading import Condition, Thread
from time import perf_counter

from mrts.base.argument_types import Progress
from mrts.base.errors import InputError, MrtsError
from mrts.motion.object_motion import ObjectMotion
from mrts.studies.configurations import ConfigurationStudy, rank_configurations
from mrts.viewer.player_state import Profile
from mrts.viewer.workbench.answer import Answer, at_another_speed, find_answer
from mrts.viewer.workbench.choices import Choices, Given

DEEPEST = 200
"""Choices that undo goes back."""

QUICK = 0.15
"""Where the whole answer took longer, a coarse one comes first the next time [s]: a hand on a slider waits for it."""


_News = Answer | ConfigurationStudy | Exception


@dataclass(frozen=True, eq=False)
class _Wish:
    choices: Choices
    speed: float | None
    has_coarse: bool = False


class _Superseded(Exception):  # noqa: N818 (no error: nobody waits for it any more)
    """Work that something newer ends."""


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
        self._ranking: Choices | None = None
        self._ranked = (0, 0)
        self._whole_took: dict[Profile, float] = {}
        self._closed = False
        self._changed = Condition()
        self._worker: Thread | None = None
        self._latest = self._answered(_Wish(self.choices, None), progress, coarse=False)
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
            return any((self._wish, self._ranking, self._ready))

    @property
    def is_asked(self) -> bool:
        """Whether an answer to something newer is on its way than what was taken."""
        with self._changed:
            on_its_way = self._wish is not None and not self._wish.has_coarse
            return on_its_way or any(isinstance(one, Answer) for one in self._ready)

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

    def ask(self, speed: float | None) -> None:
        """Ask for the answer to the choices as they are; what was asked before and is not begun is dropped.

        Args:
            speed: To play at; None is the first choice.
        """
        with self._changed:
            self._wish = _Wish(self.choices, speed)
            self._start()

    def rank(self) -> None:
        """Ask for all configurations of the cell as it is; takes seconds, and answers come meanwhile."""
        with self._changed:
            self._ranking, self._ranked = self.choices, (0, 0)
            self._start()

    def stop_ranking(self) -> None:
        """Rank no further; what was ranked before stays."""
        with self._changed:
            self._ranking = None

    @property
    def ranked(self) -> tuple[int, int] | None:
        """How many of how many configurations are looked at; None where none are being ranked."""
        with self._changed:
            return None if self._ranking is None else self._ranked

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
                self._changed.wait_for(lambda: self._closed or self._wish is not None or self._ranking is not None)
                if self._closed:
                    return
                choices = self._ranking
            self._answer_wishes()
            if choices is not None:
                self._rank(choices)

    def _answer_wishes(self) -> None:
        while True:
            with self._changed:
                wish = self._wish
                if wish is None or self._closed:
                    return
            coarse = not wish.has_coarse and self._whole_took.get(wish.choices.profile, QUICK) >= QUICK
            done = self._tried(partial(self._answered, wish, self._giving_way(wish), coarse=coarse))
            with self._changed:
                if done is not None:
                    self._ready.append(done)
                if self._wish is wish:
                    follows = isinstance(done, Answer) and done.coarse
                    self._wish = replace(wish, has_coarse=True) if follows else None

    def _giving_way(self, wish: _Wish) -> Progress:
        """What ends work on a whole answer once something newer is asked; a first one is always found."""

        def progress(_done: int, _total: int) -> None:
            if wish.has_coarse and (self._wish is not wish or self._closed):
                raise _Superseded

        return progress

    def _rank(self, choices: Choices) -> None:
        given = self.given

        def progress(done: int, total: int) -> None:
            self._answer_wishes()
            if self._ranking is not choices or self._closed:
                raise _Superseded
            self._ranked = done, total

        def ranked() -> ConfigurationStudy:
            motion = choices.motion(given)
            if not isinstance(motion, ObjectMotion):
                raise InputError("configuration", self.fixed_configuration)
            return rank_configurations(choices.cell(given), motion, sharing=choices.sharing(), progress=progress)

        done = self._tried(ranked)
        with self._changed:
            if self._ranking is choices:
                self._ranking = None
            if done is not None:
                self._ready.append(done)

    def _tried(self, work: Callable[[], _News]) -> _News | None:
        """What some work comes to: its defects too, which are raised where answers are taken; None if it was ended."""
        try:
            return work()
        except _Superseded:
            return None
        except Exception as error:  # noqa: BLE001 (raised again by `take`)
            return error

    def _answered(self, wish: _Wish, progress: Progress, *, coarse: bool) -> Answer:
        begin, known = perf_counter(), self._known
        if known is not None and known.choices is wish.choices and (coarse or not known.coarse):
            found = at_another_speed(known, wish.speed)
        else:
            found = find_answer(self.given, wish.choices, wish.speed, progress, coarse=coarse)
            if found.state is not None and not coarse:
                self._whole_took[wish.choices.profile] = perf_counter() - begin
        self._known = found if found.state is not None else None
        return replace(found, seconds=perf_counter() - begin)
