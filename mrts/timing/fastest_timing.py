# SPDX-License-Identifier: MIT
"""The fastest timing with limits kept at the samples of a path, piece by piece, and why there is none."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mrts.base.argument_types import Progress
from mrts.base.arrays import Array, median
from mrts.base.errors import InputError, SolverError
from mrts.base.load_box import LoadPoint
from mrts.cell.cell import Cell
from mrts.cell.cell_change import ChangeSteps
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import rows_text
from mrts.program.infeasibility import Conflict
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.sample_problem import SampleProblem, build_sample_problem
from mrts.scaling.loads import effective_parameters
from mrts.scaling.what_if import SpeedAnswer, WhatIf, ask_changes
from mrts.timing.fastest_profile import Obstacle, fastest_profile, rising_profile
from mrts.timing.path_pieces import NoPath, PathPiece, by_turns, closed_piece, path_pieces
from mrts.timing.result import ConstantFactor, RetimingResult, RetimingStatus
from mrts.timing.retimed_motion import FastestPiece, fastest_piece
from mrts.timing.speed_conflict import sample_conflict, segment_conflict
from mrts.timing.speed_regions import intersect_regions, speed_regions
from mrts.timing.successive_profiles import successive_profiles

UNBOUNDED_SHARE = 0.5
"""Speeds squared above this share of the bound of the regions are those that nothing limits."""

STUCK = 1e6
"""A segment that takes this many times as long as most others takes no finite time, but for rounding."""


def fastest_timing(
    compared: ConstantFactor,
    motion: CoordinatedMotion,
    end_speeds: tuple[float, float],
    progress: Progress,
    *,
    refined: bool = False,
) -> RetimingResult:
    """The fastest timing with limits kept at the samples of a motion.

    Args:
        compared: What is asked, of cell and load, at a constant factor.
        motion: The motion, with the samples that were added.
        end_speeds: ṙ at the start and at the end.
        progress: Told how many of how many loads are done.
        refined: Whether samples were added where limits were overstepped: the path is then timed by its arc length. A
            parameter by turns would be another one each round, uneven where samples were added.
    """
    cell = compared.cell
    points: tuple[LoadPoint | None, ...] = (None,)
    if compared.options.load == "guaranteed" and cell.load_box is not None:
        points = cell.load_box.corners(effective_parameters(cell, motion, cell.load_box, ("P", "Q", "S")))
    loads = tuple(cell.load if point is None else point.load for point in points)
    untimed = RetimingResult(cell, motion, RetimingStatus.OPTIMAL, "", compared, loads, end_speeds=end_speeds)
    pieces = path_pieces(motion)
    if isinstance(pieces, NoPath):
        status, why = _no_path(pieces, motion.object.time)
        return replace(untimed, status=status, explanation=why)
    rests = (pieces[0].rests[0], pieces[-1].rests[1])
    for name, speed, at_rest in zip(("start_speed", "end_speed"), end_speeds, rests, strict=True):
        if speed > 0 and at_rest:
            raise InputError(name, "the given motion is at rest there, so no other speed is possible.", value=speed)
    timed: list[FastestPiece] = []
    by_arc = [closed_piece(cell, part) for part in pieces]
    for number, piece in enumerate(by_arc if refined else map(by_turns, by_arc)):
        progress(number, len(pieces))
        search = _Search(untimed, piece, points)
        found = search.run(progress if len(pieces) == 1 else lambda _done, _total: None)
        if isinstance(found, RetimingResult):
            return found
        timed.append(found)
    return replace(untimed, pieces=tuple(timed))


def _no_path(found: NoPath, time: Array) -> tuple[RetimingStatus, str]:
    """Outcome and explanation."""
    if found.kind == "zero length":
        return RetimingStatus.ZERO_LENGTH, "neither the object nor a joint moves: the path has no length."
    where = f"from t = {time[found.sample]:.6g} to {time[found.sample + 1]:.6g} s"
    if found.kind == "wait":
        return RetimingStatus.STATIONARY, (
            f"the motion stands still {where}: a wait is no part of a path. Cut it out, or retime what is before and "
            "after it by themselves."
        )
    return RetimingStatus.STATIONARY, (
        f"the motion turns back on itself {where}, so it stops between two samples. Give a sample at the turning "
        "point, or retime what is before and after it by themselves."
    )


@dataclass(frozen=True)
class _Search:
    """The search for the profile of one piece, and for the reason if there is none."""

    untimed: RetimingResult
    piece: PathPiece
    points: tuple[LoadPoint | None, ...]

    @cached_property
    def ends(self) -> tuple[float, float]:
        """σ̇² at both ends."""
        start, end = (
            0.0 if rests else (speed * float(self.piece.given_rate[place])) ** 2
            for rests, speed, place in zip(self.piece.rests, self.untimed.end_speeds, (0, -1), strict=True)
        )
        return start, end

    @cached_property
    def rows(self) -> MotionRows:
        """The limits along the piece."""
        return motion_rows(self.untimed.cell, self.piece.path)

    def run(self, progress: Progress) -> FastestPiece | RetimingResult:
        """The fastest profile, or the outcome without one."""
        parts, with_root, step = [], [], self.piece.step
        length = float(np.sum(step))
        for number, load in enumerate(self.untimed.loads):
            progress(number, len(self.points))
            problem = self._problem(load)
            if problem.speed is None:
                parts.append(speed_regions(problem, length, self.ends))
            else:
                with_root.append(problem)
        progress(len(self.points), len(self.points))
        if with_root:
            steps = successive_profiles(with_root, step, self.ends)
            if isinstance(steps, Obstacle):
                return self._explained(steps)
            last = fastest_piece(self.piece, steps[-1])
            return self._unusual(last) or last
        regions = intersect_regions(parts)
        for sample in regions.undecided:
            conflict = self._conflict(sample)
            if conflict is None:
                raise SolverError(
                    f"the admissible speeds at {self._place(sample)} were not found, although its limits hold "
                    "together. This is a defect of mrts or of extremely scaled data: please report cell and motion."
                )
            return self._none(RetimingStatus.INFEASIBLE, f"{conflict}.", conflict)
        found = fastest_profile(step, regions, self.ends)
        if isinstance(found, Obstacle):
            return self._explained(found)
        timed = fastest_piece(self.piece, found)
        unusual = self._unusual(timed)
        if unusual is not None:
            return unusual
        faster = rising_profile(found, step, self.ends, timed.segment_times)
        return timed if faster is found else fastest_piece(self.piece, faster)

    def _none(self, status: RetimingStatus, why: str, conflict: Conflict | None = None) -> RetimingResult:
        return replace(self.untimed, status=status, explanation=why, conflict=conflict)

    def _unusual(self, timed: FastestPiece) -> RetimingResult | None:
        """The outcome of a profile that takes no time, or for ever."""
        fastest = int(np.argmax(timed.x))
        if timed.x[fastest] >= UNBOUNDED_SHARE * timed.profile.regions.bound:
            why = f"nothing limits the speed at {self._place(fastest)}. Give velocity limits."
            return self._none(RetimingStatus.UNBOUNDED, why)
        with np.errstate(divide="ignore"):
            times = timed.segment_times
        stuck = ~(times <= STUCK * median(times)) | np.isinf(times)
        if not np.any(stuck):
            return None
        why = f"the limits let the cell only hold still at {self._place(int(np.argmax(stuck)))}"
        upper = self.untimed.factor.range.upper
        why += "." if upper is None or upper.time is None else f"; c² is limited {upper.place()}."
        return self._none(RetimingStatus.STANDSTILL, why)

    def _explained(self, obstacle: Obstacle) -> RetimingResult:
        k, reach = obstacle.sample, obstacle.reach
        for sample in (k, k + 1) if obstacle.kind == "segment" else (k,):
            conflict = self._conflict(sample)
            if conflict is not None:
                return self._none(RetimingStatus.INFEASIBLE, f"{conflict}.", conflict)
        if obstacle.kind != "segment":
            return self._wrong_end(obstacle)
        conflict = self._conflict(k, reach)
        low, high = (np.sqrt(x) / self.piece.given_rate[k + 1] if self.piece.speed[k + 1] > 0 else 0.0 for x in reach)
        why = (
            f"no speed at {self._place(k)} leads on to where the end can still be reached, ṙ in [{low:.6g}, "
            f"{high:.6g}] at the next sample{_rows(conflict)}. Change the path or its end speeds, or raise a limit."
        )
        return self._none(RetimingStatus.NOT_CONTROLLABLE, why, conflict)

    def _wrong_end(self, obstacle: Obstacle) -> RetimingResult:
        start = obstacle.kind == "start"
        speed, given = self.piece.given_rate[obstacle.sample], self.ends[0 if start else 1]
        place, status = self._place(obstacle.sample), RetimingStatus.START_SPEED if start else RetimingStatus.END_SPEED
        conflict = self._conflict(obstacle.sample, obstacle.next_reach, given)
        if given == 0:
            why = f"the motion cannot {'start from' if start else 'come to'} rest at {place}{_rows(conflict)}."
            return self._none(status, why, conflict)
        low, high = (np.sqrt(x) / speed for x in obstacle.reach)
        why = (
            f"at {place} the motion may {obstacle.kind} with ṙ in [{low:.6g}, {high:.6g}], but "
            f"{np.sqrt(given) / speed:.6g} is asked for{_rows(conflict)}. Give another {obstacle.kind} speed, "
            "or a motion that is at rest there."
        )
        return self._none(status, why, conflict)

    def _place(self, sample: int) -> str:
        sample += self.piece.first
        return f"t = {self.untimed.motion.object.time[sample]:.6g} s (sample {sample})"

    def _problem(self, load: Array) -> SampleProblem:
        cell, sharing = self.untimed.cell, self.untimed.options.sharing
        return build_sample_problem(cell, self.piece.path, sharing=sharing, load=load, varying=True, rows=self.rows)

    def _conflict(
        self, sample: int, reach: tuple[float, float] | None = None, x: float | None = None
    ) -> Conflict | None:
        """The limits that conflict at a sample, or on the segment from it into the reach, with the worst load."""
        time = self.untimed.motion.object.time[self.piece.first :]
        worst: Conflict | None = None
        for point, load in zip(self.points, self.untimed.loads, strict=True):
            problem = self._problem(load)
            if reach is None:
                found = sample_conflict(problem, time, sample, x)
            else:
                found = segment_conflict(problem, time, sample, float(self.piece.step[sample]), reach, x)
            if found is not None and (worst is None or found.widening > worst.widening):
                worst = replace(found, sample=self.piece.first + sample, load=point)
        return worst


def _rows(conflict: Conflict | None) -> str:
    """The limits that conflict, as the end of a sentence."""
    if conflict is None:
        return ""
    load = "" if conflict.load is None else f" with {conflict.load}"
    return f"; these conflict{load}: {rows_text(conflict.rows, '; ')}"


def timing_what_if(found: RetimingResult, steps: ChangeSteps, progress: Progress) -> WhatIf:
    """What changes would do to the duration of the fastest timing, at its samples.

    Raises:
        InputError: If rates were limited: such a timing takes seconds.
        SolverError: If no solver answers for the cell as it is.
    """
    if found.smooth is not None:
        rule = "within limits of rates it would be timed again for every change, seconds each. Ask without rates."
        raise InputError("what if", rule)
    asked = found.compared
    refined = found.motion.samples > asked.motion.samples
    asked = replace(asked, options=replace(asked.options, rates=None, between=None))

    def answer(changed: Cell, motion: CoordinatedMotion, _before: SpeedAnswer | None) -> SpeedAnswer:
        compared = replace(asked, cell=changed, motion=motion)
        again = fastest_timing(compared, motion, found.end_speeds, lambda _done, _total: None, refined=refined)
        return _of_timing(again)

    return ask_changes(found.cell, found.motion, steps, answer, progress)


def _of_timing(timed: RetimingResult) -> SpeedAnswer:
    """The answer of a timing: what limits it for the longest time binds."""
    if not timed.status.admits_motion:
        return SpeedAnswer(status=timed.status.value, reason=timed.explanation)
    limits = tuple(dict.fromkeys((name.rpartition(" (")[0] or name).partition(":")[0] for name, _ in timed.limits))
    return SpeedAnswer(status="feasible", duration=timed.duration, limits=limits)
