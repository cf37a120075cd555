# SPDX-License-Identifier: MIT
"""The fastest timing with limits kept at the samples of a path, piece by piece, and why there is none."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, median
from mrts.base.errors import InputError, SolverError
from mrts.base.load_box import LoadPoint
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import RowName, rows_text
from mrts.program.infeasibility import Conflict, conflicts_at
from mrts.program.motion_rows import MotionRows, motion_rows
from mrts.program.sample_problem import OF_ROWS, SampleProblem, build_sample_problem
from mrts.program.sample_ranges import find_conflicts
from mrts.program.smooth_program import segment_times
from mrts.scaling.range import effective_parameters
from mrts.timing.fastest_profile import (
    Obstacle,
    SpeedProfile,
    SpeedRegions,
    fastest_profile,
    intersect_regions,
    rising_profile,
    speed_regions,
)
from mrts.timing.path_pieces import PathError, PathPiece, path_pieces
from mrts.timing.result import RetimingResult, RetimingStatus, TimedPiece
from mrts.timing.successive_profiles import successive_profiles

UNBOUNDED_SHARE = 0.5
"""Speeds squared above this share of the bound of the regions are those that nothing limits."""

STUCK = 1e6
"""A segment that takes this many times as long as most others takes no finite time, but for rounding."""

REACHED = 3
"""Speeds at the next sample, from the least to the largest, that are looked at where rows have terms in √x."""


def fastest_timing(
    asked: RetimingResult, motion: CoordinatedMotion, before: RetimingResult | None = None
) -> RetimingResult:
    """The fastest timing with limits kept at the samples of a motion.

    Args:
        asked: Cell, options, given motion and speeds at its ends.
        motion: With the samples at which limits are kept.
        before: The timing before samples were added: where its path is the same, so are the admissible speeds.
    """
    cell, end_speeds = asked.cell, asked.end_speeds
    points: tuple[LoadPoint | None, ...] = (None,)
    if asked.options.load == "guaranteed" and cell.load_box is not None:
        points = cell.load_box.corners(effective_parameters(cell, motion, cell.load_box, ("P", "Q", "S")))
    loads = tuple(cell.load if point is None else point.load for point in points)
    outcome = partial(RetimingResult, cell, motion, asked.given, asked.options, loads=loads, end_speeds=end_speeds)
    try:
        pieces = path_pieces(cell, motion)
    except PathError as error:
        return outcome(RetimingStatus(error.kind), str(error))
    rests = (pieces[0].rests[0], pieces[-1].rests[1])
    for name, speed, at_rest in zip(("start_speed", "end_speed"), end_speeds, rests, strict=True):
        if speed > 0 and at_rest:
            raise InputError(name, "the given motion is at rest there, so no other speed is possible.", value=speed)
    timed: list[TimedPiece] = []
    for part in pieces:
        found = _Search(asked, motion, part, points, loads, before).run()
        if not isinstance(found, TimedPiece):
            return outcome(*found)
        timed.append(found)
    return outcome(pieces=tuple(timed))


_Reason = tuple[RetimingStatus, str, Conflict | None]
"""Why there is no timing."""


@dataclass(frozen=True)
class _Search:
    asked: RetimingResult
    motion: CoordinatedMotion
    piece: PathPiece
    points: tuple[LoadPoint | None, ...]
    loads: tuple[Array, ...]
    before: RetimingResult | None

    @cached_property
    def ends(self) -> tuple[float, float]:
        """σ̇² at both ends."""
        given = np.array(self.asked.end_speeds) * self.piece.speed[[0, -1]]
        start, end = np.where(self.piece.rests, 0.0, given**2).tolist()
        return start, end

    @cached_property
    def rows(self) -> MotionRows:
        """The limits along the piece."""
        return motion_rows(self.asked.cell, self.piece.path, self.asked.options.sharing)

    def run(self) -> TimedPiece | _Reason:
        """The fastest profile, or the outcome without one."""
        if self.rows.has_speed_terms:
            steps = successive_profiles([*self._problems()], self.piece.step, self.ends)
            return self._outcome(steps if isinstance(steps, Obstacle) else steps[-1])
        return self._outcome(fastest_profile(self.piece.step, self._regions(), self.ends))

    def _problems(self, samples: NDArray[np.intp] | None = None) -> Iterator[SampleProblem]:
        """The rows of some samples, or all, for each load."""
        for load in self.loads:
            yield build_sample_problem(self.rows, load=load, samples=samples, varying=True)

    def _regions(self) -> SpeedRegions:
        """The admissible speeds at all samples; where the path is that of the timing before, they are known."""
        length, before = float(self.piece.step.sum()), self.before
        known = before and before.part_along(self.piece, self.motion)
        profile = before.pieces[known[0]].profile if before and known else None
        if not known or profile is None:
            return intersect_regions([speed_regions(one, length, self.ends) for one in self._problems()])
        own, regions = known[1], profile.regions
        new = np.delete(np.arange(len(self.piece.arc)), own)
        more = [speed_regions(one, length, self.ends, regions.bound) for one in self._problems(new) if new.size]
        return intersect_regions([regions, *more], [own, *[new] * len(more)])

    def _outcome(self, found: SpeedProfile | Obstacle) -> TimedPiece | _Reason:
        if isinstance(found, Obstacle):
            return self._explained(found)
        fastest = int(found.x.argmax())
        if found.x[fastest] >= UNBOUNDED_SHARE * found.regions.bound:
            why = f"nothing limits the speed at {self._place(fastest)}. Give velocity limits."
            return RetimingStatus.UNBOUNDED, why, None
        times = segment_times(self.piece.step, found.x, found.rise)
        stuck = ~(times < STUCK * median(times))
        if not stuck.any():
            rises = not self.rows.has_speed_terms
            profile = rising_profile(found, self.piece.step, self.ends, times) if rises else found
            mean, half = (profile.x[1:] - profile.x[:-1]) / (2 * self.piece.step), profile.rise / 2
            rates = np.array([mean - half, mean + half]).T
            return TimedPiece(piece=self.piece, x=profile.x, rates=rates, profile=profile)
        why = f"the limits let the cell only hold still at {self._place(int(np.argmax(stuck)))}"
        upper = self.asked.factor.range.upper
        why += "." if upper.time is None else f"; c² is limited {upper.place()}."
        return RetimingStatus.STANDSTILL, why, None

    def _explained(self, obstacle: Obstacle) -> _Reason:
        k, kind, on_way = obstacle.sample, obstacle.kind, obstacle.kind == "segment"
        for sample in range(k, k + 1 + on_way):
            conflict = self._conflict(sample)
            if conflict is not None:
                return RetimingStatus.INFEASIBLE, f"{conflict}.", conflict
        if kind == "undecided":
            raise SolverError(
                f"the admissible speeds at {self._place(k)} were not found, although its limits hold together. This is "
                "a defect of mrts or of extremely scaled data: please report cell and motion."
            )
        given = None if on_way else self.ends[kind == "end"]
        conflict = self._conflict(k, obstacle.reach if on_way else obstacle.next_reach, given)
        rows = "" if conflict is None else f"; these conflict{conflict.with_load}: {rows_text(conflict.rows, '; ')}"
        place, speed = self._place(k), self.piece.speed[k + on_way]
        low, high = (np.sqrt(x) / speed if speed > 0 else 0.0 for x in obstacle.reach)
        if given is None:
            why = (
                f"no speed at {place} leads on to where the end can still be reached, ṙ in [{low:.6g}, {high:.6g}] at "
                f"the next sample{rows}. Change the path or its end speeds, or raise a limit."
            )
            return RetimingStatus.NOT_CONTROLLABLE, why, conflict
        why = f"the motion cannot {'start from' if kind == 'start' else 'come to'} rest at {place}{rows}."
        if given > 0:
            why = (
                f"at {place} the motion may {kind} with ṙ in [{low:.6g}, {high:.6g}], but {np.sqrt(given) / speed:.6g} "
                f"is asked for{rows}. Give another {kind} speed, or a motion that is at rest there."
            )
        return RetimingStatus(f"{kind} speed not admissible"), why, conflict

    def _place(self, sample: int) -> str:
        sample += self.piece.first
        return f"t = {self.motion.object.time[sample]:.6g} s (sample {sample})"

    def _conflict(
        self, sample: int, reach: tuple[float, float] | None = None, x: float | None = None
    ) -> Conflict | None:
        time = float(self.motion.object.time[self.piece.first + sample])
        worst: Conflict | None = None
        for point, problem in zip(self.points, self._problems(), strict=True):
            if reach is None:
                found = _least(problem.at(np.array([sample])), time, x)
            else:
                found = segment_conflict(problem, time, sample, float(self.piece.step[sample]), reach, x)
            if found is not None and (worst is None or found.widening > worst.widening):
                worst = replace(found, sample=self.piece.first + sample, load=point)
        return worst


def segment_conflict(
    problem: SampleProblem,
    time: float,
    sample: int,
    step: float,
    reach: tuple[float, float],
    x: float | None = None,
) -> Conflict | None:
    """The limits of both ends of a segment that no u and x keep, if x at its end is to be in the reach.

    Rows are of [F, u, x] at N samples; x at the start may be given. Unknowns are F here, F there, x there and x here,
    and 2 step u is what x rises by. Where rows have terms in √x, x there is looked at by itself.
    """
    here, there = problem.at(np.array([sample])), problem.at(np.array([sample + 1]))
    free, by_rise = problem.unknowns - 2, 1 / (2 * step)
    none = np.zeros((1, problem.A.shape[1], free))
    at_start = np.stack([by_rise * here.rate, here.square - by_rise * here.rate], axis=2)
    at_end = np.stack([there.square + by_rise * there.rate, -by_rise * there.rate], axis=2)
    both = replace(here, A=np.concatenate([here.A[:, :, :free], none, at_start], axis=2)).with_rows(
        problem.names,
        A=np.concatenate([none, there.A[:, :, :free], at_end], axis=2),
        **{name: getattr(there, name) for name in (*OF_ROWS, "lower", "upper")},
    )
    if here.speed is None or there.speed is None:
        return _least(_with_law(both, RowName("speed", element="at the next sample"), *reach), time, x)
    ends = np.linspace(*reach, REACHED)[:, None]
    given = both.A[:, :, -2] * ends + np.concatenate([0 * here.speed, there.speed], axis=1) * np.sqrt(ends)
    each = both.at(np.zeros(REACHED, dtype=int))
    A, lower, upper = np.delete(each.A, -2, axis=2), each.lower - given, each.upper - given
    return _least(replace(each, A=A, lower=lower, upper=upper), time, x)


def _least(problem: SampleProblem, time: float, x: float | None) -> Conflict | None:
    """What conflicts where limits pass each other least; None where some hold together. x may be given."""
    count = problem.samples
    if x is None:
        found = find_conflicts(problem, np.full(count, time))
    else:
        found = conflicts_at(problem, np.full(count, x), np.full(count, time))
    conflicts = [replace(one, c2=None) for one in found if one is not None]  # x is none of the given motion's c²
    return None if len(conflicts) < len(found) else min(conflicts, key=attrgetter("widening"))


def _with_law(problem: SampleProblem, name: RowName, lower: float, upper: float) -> SampleProblem:
    """One sample's rows with one more of the last unknown but one, which is no limit that could move outward."""
    size, no = max(abs(lower), abs(upper)) or 1.0, np.zeros(1, dtype=bool)
    return problem.with_rows(
        [name],
        unit=np.array([size]),
        is_limit=no,
        is_cap=no,
        A=np.eye(problem.unknowns)[None, -2:-1] / size,
        lower=np.array([[lower / size]]),
        upper=np.array([[upper / size]]),
        limit_lower=np.array([lower]),
        limit_upper=np.array([upper]),
    )
