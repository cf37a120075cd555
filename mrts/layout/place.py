# SPDX-License-Identifier: MIT
"""The best layout of a study: a small sweep for starts, IPOPT from the best of them, `scale` for the last word."""

from pathlib import Path
from time import monotonic

from mrts.base.argument_types import Progress, check_callable, check_type, is_number
from mrts.base.arrays import Array
from mrts.base.errors import InputError, MrtsError
from mrts.cell.cell import Cell
from mrts.layout.layout_numbers import LayoutNumbers
from mrts.layout.layout_search import LayoutSearch, Playable
from mrts.layout.placement import Placement, PlayedLayout
from mrts.layout.stop_request import stop_request
from mrts.motion.motion_file import MotionDescription, sample_motion
from mrts.motion.object_motion import ObjectMotion
from mrts.program.excess import BETWEEN, checked_tolerance
from mrts.scaling.scale import scale
from mrts.studies.sampling import sample_points
from mrts.studies.spreads import Range
from mrts.studies.study import Study
from mrts.studies.study_file import read_study
from mrts.timing.retime import retime

STARTS = 3
"""Layouts from which IPOPT searches, the best of those that were looked at."""

LOOKED_AT = 64
"""Layouts that are looked at for starts."""

MOST = 100_000
"""That may be: an hour of looking."""

SEED = 17


def place(
    study: Study | Path | str,
    *,
    starts: int = STARTS,
    looked_at: int = LOOKED_AT,
    seconds: float | None = None,
    between: float | None = BETWEEN,
    progress: Progress = lambda _done, _total: None,
) -> Placement:
    """Base poses, grasps and postures, within the bounds of a study, that give the largest c²⁺.

    The layouts looked at first are points of a Sobol sequence between the bounds, and the layout that the cell file
    gives. From the best of them IPOPT searches the nearest local optimum (`mrts.layout.layout_program.LayoutProgram`);
    what it finds counts only as `mrts.scale` confirms it, so the answer is never worse than the best start. Ctrl-C and
    the time limit keep the best so far.

    Args:
        study: The study, or its file; `vary` names numbers of base, grasp or posture, each `from` and `to`.
        starts: From how many layouts to search.
        looked_at: Of how many.
        seconds: Time after which no search begins, and those that run end; None is no limit.
        between: Share of a limit by which it may be overstepped between the samples, as in `mrts.scale`, before and
            after; the search itself looks at samples alone.
        progress: Told how many of how many pieces of work are done.

    Returns:
        The outcome. Where no layout within the bounds can be played, it has no answer.

    Raises:
        InputError: If the study varies what is no layout, or asks what does not fit.
        SolverError: If no solver answers.
    """
    if not isinstance(study, Study):
        study = read_study(study)
    for name, value in (("starts", starts), ("looked_at", looked_at)):
        check_type(name, value, int)
        if not 1 <= value <= MOST:
            raise InputError(name, f"must be at least 1, and at most {MOST}.", value=value)
    if seconds is not None and not is_number(seconds, 0):
        raise InputError("seconds", "must be a number of seconds, 0 or more, or None for no limit.", value=seconds)
    check_callable("progress", progress)
    tolerance = checked_tolerance(between)
    if study.question.load == "possible":
        rule = "the best layout is one for loads that are known, or for every load of a box: nominal or guaranteed."
        raise InputError(study.path, rule, key="load", value="possible")
    return _Placing(study, tolerance, seconds, progress).best(starts, looked_at)


class _Placing:
    """One search.

    Args:
        study: The study.
        between: As in `place`.
        seconds: Likewise.
        progress: Likewise.
    """

    def __init__(self, study: Study, between: float | None, seconds: float | None, progress: Progress) -> None:
        study = study.at_hand()
        self.study, self.between, self.progress = study, between, progress
        cell = Cell.from_description(study.cell, folder=study.folder).with_limits(*study.limits)
        self.numbers = LayoutNumbers.of(study, cell)
        self.motion = _object_motion(study)
        self.until = None if seconds is None else monotonic() + seconds
        self.asked: list[int] = []
        self.search = LayoutSearch(study, self.numbers, self.motion, cell, self._over)

    def best(self, starts: int, looked_at: int) -> Placement:
        """The best of some searches from the best of some layouts.

        Args:
            starts: From how many layouts to search.
            looked_at: Of how many.
        """
        nearest, same = self.numbers.nearest_given()
        given = self.search.of_keys(self.study.cell, nearest if same else None)
        found = [given] if not isinstance(given, str) and same else []
        failures = [given] if isinstance(given, str) else []
        unplayable = 0
        total, searches, looked = looked_at + starts, 0, 0
        with stop_request() as self.asked:
            for values in self._layouts(looked_at):
                if self._over():
                    break
                self.progress(looked, total)
                looked += 1
                tried = self.search.tried(values)
                if isinstance(tried, str):
                    failures.append(tried)
                    unplayable += 1
                else:
                    found.append(tried)
            for start in sorted(found, key=lambda one: -one.c2)[:starts]:
                if self._over():
                    break
                self.progress(looked_at + searches, total)
                searches += 1
                self.search.improve(start, found)
            stopped = "Ctrl-C" if self.asked else "the time limit" if self._over() else ""
        self.progress(total, total)
        before = given if isinstance(given, str) else self._played(given)
        return Placement(
            study=self.study,
            numbers=self.numbers,
            before=None if isinstance(before, str) else before,
            after=self._best_played(found, failures),
            reason=failures[-1] if failures else "",
            looked_at=looked,
            playable=looked - unplayable,
            searches=searches,
            stopped=stopped,
        )

    def _over(self) -> bool:
        """Whether Ctrl-C was pressed, or time is up."""
        return bool(self.asked) or (self.until is not None and monotonic() >= self.until)

    def _layouts(self, count: int) -> Array:
        """Layouts to look at, evenly between the bounds, Shape (count, P)."""
        bounds = zip(self.numbers.lower, self.numbers.upper, strict=True)
        points = sample_points([Range(*pair) for pair in bounds], "sobol", count, SEED, (0, count))
        return self.numbers.rounded(points)

    def _best_played(self, found: list[Playable], failures: list[str]) -> PlayedLayout | None:
        """The best, and the best start, which might be better between the samples, less what moved for nothing.

        Args:
            found: All that can be played at the samples.
            failures: Why others cannot; what cannot between the samples joins them.
        """
        checked: list[PlayedLayout] = []
        best_first = sorted(found, key=lambda one: -one.c2)
        for group in (best_first, [one for one in best_first if one.slope is None]):
            for one in group:
                played = self._played(self.search.settled(one))
                if not isinstance(played, str):
                    checked.append(played)
                    break
                failures.append(played)
        return max(checked, key=lambda layout: layout.c2, default=None)

    def _played(self, layout: Playable) -> PlayedLayout | str:
        """A layout between the samples too, or why it cannot be played there."""
        cell, load = layout.result.cell, self.study.question.load
        try:
            result = scale(cell, self.motion, load=load, between=self.between)
        except MrtsError as error:
            return str(error)
        if result.trajectory is None:
            return f"{result.status.value}: {result.explanation()}"
        try:
            fastest = retime(cell, self.motion, load=load, between=self.between).duration
        except MrtsError:
            fastest = None
        return PlayedLayout(layout.keys, layout.values, layout.slope, result, fastest)


def _object_motion(study: Study) -> ObjectMotion:
    if study.table is None:
        return sample_motion(MotionDescription(**study.motion))
    if isinstance(study.table, ObjectMotion):
        return study.table
    rule = "a table of joint motion fixes where the arms stand; give the object's motion."
    raise InputError(study.path, rule, key="motion")
