# SPDX-License-Identifier: MIT
"""The fastest speed along a path where rows have terms in ṡ = √x: programs without it, one after the other.

Terms in √x are those of viscous friction and torque-speed curves. In each program a line stands for √x at every sample,
start + slope x, as the two arrays of `Lines`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.programs import fastest_speeds
from mrts.program.sample_problem import SampleProblem
from mrts.program.smooth_program import segment_times
from mrts.timing.fastest_profile import (
    FARTHEST,
    Obstacle,
    SpeedProfile,
    SpeedRegions,
    fastest_profile,
    intersect_regions,
    speed_regions,
)

CONVERGED = 1e-6
"""Share of the duration by which a step with the narrowest chords must shorten it, or it was the last."""

STARTS = tuple(0.25**power for power in range(8))
"""Shares of the fastest x without terms in ṡ at which the first tangents are laid."""

WIDTHS = (2.0, 1.1, 1.01, 1.001)
"""x stays within this factor of the last profile, step after step; the last chords miss √x by 2e-7 of it."""

FIRST_REACH = 4.0
"""The first chords are from 0 to this multiple of x where the first tangents are laid."""

MOST_STEPS = 50
"""Steps after which the profile is taken as it is: every one keeps all limits."""

AT_BORDER = 1e-9
"""Share of x from which it lies on the border of its interval: rounding."""

LEAST_SHARE = 1e-12
"""Tangents are laid at no less than this share of the largest x: at 0 they are upright."""

FINENESS = (2.0, 2.0**0.25)
"""Ratios of the ends of an interval of x, coarse first: a tangent in its middle misses √x by 1.8 % and 0.1 % of it."""

SPAN = (2.0**-12, 2.0**4)
"""Least and largest end of an interval but the first, as a multiple of an x that the path makes likely."""

Ends = tuple[float | None, float | None]
"""x at the first and the last sample of a path, None where it is not given."""

Lines = tuple[Array, Array]
"""Start and slope at every sample, each Shape (N,)."""


def successive_profiles(
    problems: Sequence[SampleProblem], step: Array, ends: tuple[float, float]
) -> list[SpeedProfile] | Obstacle:
    """Profiles within limits, each faster than the one before, or where there is none.

    Where √x presses towards a limit it is replaced by its tangent at the last profile, where it helps to keep one by
    its chord over an interval around that profile, which only narrows: rows are stricter than the given ones, and the
    last profile keeps them, so the next one is no slower. Where a profile ends at the border of such an interval, all
    are opened again.

    Args:
        problems: Rows of [F, u, x] with terms in √x, one a load.
        step: Length of each segment, Shape (n - 1,).
    """
    search = _Search(problems, step, ends)
    first = search.first()
    if isinstance(first, Obstacle):
        return first
    done, before = [first], np.inf
    while search.duration(done[-1]) < before * (1 - CONVERGED) and len(done) < MOST_STEPS:
        before = search.duration(done[-1])
        if not search.narrow(done):
            break
    done[-1] = search.linear_at(done[-1])
    return done


@dataclass(frozen=True)
class _Search:
    problems: Sequence[SampleProblem]
    step: Array
    ends: tuple[float, float]

    def first(self) -> SpeedProfile | Obstacle:
        """A profile within limits, if there is one.

        Where the cell can hold still at every sample with something to spare, a slow enough one is; else it is searched
        for among all speeds.
        """
        bare = self.fastest(self.regions(None, None))
        for at in () if bare is None else [share * bare.x for share in STARTS]:
            found = self.near(at, np.zeros_like(at), FIRST_REACH * at)
            if found is not None:
                return found
        return self.through_cells()

    def narrow(self, done: list[SpeedProfile]) -> bool:
        """Add faster profiles while chords grow narrower; whether the last touches the border of its interval."""
        least, most = np.zeros_like(done[-1].x), np.full_like(done[-1].x, np.inf)
        stage = 0
        while len(done) < MOST_STEPS:
            x, before = done[-1].x, self.duration(done[-1])
            least, most = np.maximum(least, x / WIDTHS[stage]), np.minimum(most, x * WIDTHS[stage])
            found = self.near(x, least, most)
            after = np.inf if found is None else self.duration(found)
            if found is not None and after < before:
                done.append(found)
            if stage == len(WIDTHS) - 1 and not after < before * (1 - CONVERGED):
                break
            stage = min(stage + 1, len(WIDTHS) - 1)
        x = done[-1].x
        at_border = (x <= least * (1 + AT_BORDER)) | (x >= most * (1 - AT_BORDER))
        return bool(np.any(at_border[1:-1]))

    def near(self, at: Array, least: Array, most: Array) -> SpeedProfile | None:
        """The fastest profile between two others, of x at least and at most, in rows made stricter by tangents at x."""
        at = np.maximum(at, LEAST_SHARE * np.max(at))
        regions = self.regions(_tangents(at), _chords(least, np.maximum(most, at)))
        lower, upper, inside = regions.lower.copy(), regions.upper.copy(), slice(1, -1)
        lower[inside] = np.maximum(lower, least)[inside]
        upper[inside] = np.minimum(upper, most)[inside]
        return self.fastest(replace(regions, lower=lower, upper=upper))

    def linear_at(self, last: SpeedProfile) -> SpeedProfile:
        """The same profile with all speeds that rows linear at it admit: what else could have been.

        There √x is its tangent in every row, which is exact at the profile and near it.
        """
        x = last.x
        lines = _tangents(np.maximum(x, LEAST_SHARE * np.max(x)))
        around = self.fastest(self.regions(lines, lines))
        if around is None:
            return last
        lower, upper = np.minimum(around.lower, x), np.maximum(around.upper, x)
        return replace(last, regions=around.regions, lower=lower, upper=upper)

    def regions(self, pressing: Lines | None, helping: Lines | None, ends: Ends | None = None) -> SpeedRegions:
        """Regions with lines in the place of √x, and √x itself where x is given; without these terms for None."""
        length, given = float(np.sum(self.step)), self.ends if ends is None else ends
        if pressing is None or helping is None:
            rows = [replace(one, speed=None, torque_speed=None) for one in self.problems]
        else:
            rows = [_without_root(one, _pinned(pressing, given), _pinned(helping, given)) for one in self.problems]
        return intersect_regions([speed_regions(one, length, (given[0] or 0.0, given[1] or 0.0)) for one in rows])

    def fastest(self, regions: SpeedRegions) -> SpeedProfile | None:
        found = fastest_profile(self.step, regions, self.ends)
        return found if isinstance(found, SpeedProfile) else None

    def duration(self, profile: SpeedProfile) -> float:
        """Of a profile [s]; infinity where it stands still."""
        return float(np.sum(segment_times(self.step, profile.x)))

    def through_cells(self) -> SpeedProfile | Obstacle:
        """A profile within limits, or where none leads on.

        The range of x is cut into intervals; on each of them the rows are replaced by stricter ones, which miss them by
        a small share of their terms in √x. Backward, the x of each interval from which the end is reached are found;
        they are exact for the stricter rows. So a profile is found if there is one that keeps limits with that share to
        spare.
        """
        likely = max(*self.ends, self.regions(None, None).bound / FARTHEST)

        def cells(ratio: float, given: Ends) -> list[SpeedRegions]:
            steps = int(np.ceil(np.log(SPAN[1] / SPAN[0]) / np.log(ratio)))
            edges = likely * np.append(0.0, SPAN[0] * ratio ** np.arange(steps + 1))
            return [self.cell(given, *edge) for edge in pairwise(edges.tolist())]

        for ratio in FINENESS:
            tried = cells(ratio, self.ends)
            reaches = _reaches(tried, self.step)
            if reaches[0]:
                found = fastest_profile(self.step, _along(tried, reaches), self.ends)
                if isinstance(found, SpeedProfile):
                    return found
            if ratio == FINENESS[0] and self.fastest(self.weaker(likely)) is None:
                break
        return _obstacle(reaches, lambda given: _reaches(cells(FINENESS[0], given), self.step), self.ends)

    def weaker(self, likely: float) -> SpeedRegions:
        """Regions of rows that are weaker than the given ones at every speed."""
        nothing = np.zeros(self.problems[0].samples)
        return self.regions((nothing, nothing), _tangents(nothing + likely))

    def cell(self, ends: Ends, least: float, most: float) -> SpeedRegions:
        """Regions of stricter rows in one interval of x."""
        count = self.problems[0].samples
        low, high = np.full(count, least), np.full(count, most)
        middle = np.square((np.sqrt(low) + np.sqrt(high)) / 2)
        regions = self.regions(_tangents(middle), _chords(low, high), ends)
        for place, x in ((0, ends[0]), (-1, ends[1])):
            if x is not None:
                low[place] = high[place] = x
        low, high = np.maximum(regions.lower, low), np.minimum(regions.upper, high)
        high[regions.undecided] = -np.inf
        return replace(regions, lower=low, upper=high)


@dataclass(frozen=True)
class _Reach:
    """An interval of x at a sample from which the end is reached, and where it leads: the place of the next one."""

    low: float
    high: float
    cell: int
    next: int


def _reaches(cells: Sequence[SpeedRegions], step: Array) -> list[list[_Reach]]:
    """At every sample the x from which the end is reached, the fastest cells first."""
    last, fastest_first = len(step), [*enumerate(cells)][::-1]
    reaches: list[list[_Reach]] = [[] for _ in range(last + 1)]
    at_end = (_Reach(float(cell.lower[last]), float(cell.upper[last]), number, 0) for number, cell in fastest_first)
    reaches[last] = _covering([one for one in at_end if one.low <= one.high])
    for i in range(last - 1, -1, -1):
        for number, cell in fastest_first:
            found = []
            for place, ahead in enumerate(reaches[i + 1]):
                x = _backward(cell, cells[ahead.cell], i, float(step[i]), ahead)
                if x is not None:
                    found.append(_Reach(*x, number, place))
            reaches[i] += _covering(found)
    return reaches


def _backward(
    cell: SpeedRegions, next_cell: SpeedRegions, i: int, step: float, to: _Reach
) -> tuple[float, float] | None:
    if not cell.lower[i] <= cell.upper[i]:
        return None
    lower, upper = np.array([cell.lower[i], to.low]), np.array([cell.upper[i], to.high])
    start, planes = _joined([(cell, i), (next_cell, i + 1)])
    failed, _ = fastest_speeds(np.array([step]), np.zeros(1), start, planes, lower, upper, 0.0)
    return None if failed >= 0 else (float(lower[0]), float(upper[0]))


def _joined(samples: Sequence[tuple[SpeedRegions, int]]) -> tuple[NDArray[np.int64], Array]:
    parts = [cell.planes[cell.start[i] : cell.start[i + 1]] for cell, i in samples]
    return np.cumsum([0, *map(len, parts)], dtype=np.int64), np.concatenate(parts)


def _along(cells: Sequence[SpeedRegions], reaches: list[list[_Reach]]) -> SpeedRegions:
    chosen = [reaches[0][0]]
    for ahead in reaches[1:]:
        chosen.append(ahead[chosen[-1].next])
    at = [(cells[one.cell], i) for i, one in enumerate(chosen)]
    lower, upper = np.array([(cell.lower[i], cell.upper[i]) for cell, i in at]).T
    return SpeedRegions(*_joined(at), lower, upper, max(cell.bound for cell in cells), lower > upper)


def _obstacle(
    reaches: list[list[_Reach]], reached: Callable[[Ends], list[list[_Reach]]], ends: tuple[float, float]
) -> Obstacle:
    last = len(reaches) - 1
    blocked = max((i for i, some in enumerate(reaches) if not some), default=0)
    if blocked == last:
        return Obstacle("end", last, _hull(reached((ends[0], None))[last]))
    ahead = _hull(reaches[blocked + 1])
    if blocked == 0:
        admitted = reached((None, ends[1]))[0] if ends[0] > 0 else []
        if admitted or ends[0] == 0:
            return Obstacle("start", 0, _hull(admitted), ahead)
    return Obstacle("segment", blocked, ahead)


def _hull(reaches: Sequence[_Reach]) -> tuple[float, float]:
    return min((one.low for one in reaches), default=0.0), max((one.high for one in reaches), default=0.0)


def _covering(found: list[_Reach]) -> list[_Reach]:
    chosen: list[_Reach] = []
    left = found
    while left:
        end = chosen[-1].high if chosen else min(one.low for one in left)
        near = [one for one in left if one.low <= end]
        chosen.append(max(near, key=lambda one: one.high) if near else min(left, key=lambda one: one.low))
        left = [one for one in left if one.high > chosen[-1].high]
    return chosen


def _pinned(lines: Lines, ends: Ends) -> Lines:
    """The same lines; at the first and the last sample, where x is given, √x itself."""
    start, slope = lines[0].copy(), lines[1].copy()
    for place, x in ((0, ends[0]), (-1, ends[1])):
        if x is not None:
            start[place], slope[place] = np.sqrt(x), 0.0
    return start, slope


def _tangents(at: Array) -> Lines:
    """Lines that touch √x at some x > 0, Shape (N,), and lie above it."""
    root = np.sqrt(at)
    return root / 2, 0.5 / root


def _chords(least: Array, most: Array) -> Lines:
    """Lines below √x between two of its points, of x >= 0 and > 0, each Shape (N,)."""
    low, high = np.sqrt(least), np.sqrt(most)
    return low * high / (low + high), 1 / (low + high)


def _without_root(problem: SampleProblem, pressing: Lines, helping: Lines) -> SampleProblem:
    """Rows that are linear in x in place of rows with terms in √x.

    Each row with such a term becomes two, one a side. Where the term presses towards that side one line is put in the
    place of √x, where it helps the other. With lines above √x for what presses and below it for what helps the rows are
    stricter than the given ones; the other way round, weaker.
    """
    root = problem.speed
    if root is None:
        return problem
    both = np.any(root, axis=0)
    plain, split = np.flatnonzero(~both), np.flatnonzero(both)
    twice = replace(problem, speed=None, torque_speed=None).only(np.concatenate([plain, split, split]))
    A, lower, upper = twice.A, twice.lower, twice.upper
    above, below = np.split(np.arange(len(plain), len(twice.names)), 2)
    lower[:, above], upper[:, below] = -np.inf, np.inf
    for rows, sign, limit in ((above, 1.0, upper), (below, -1.0, lower)):
        term = root[:, split]
        presses = sign * term > 0
        A[:, rows, -1] += term * np.where(presses, pressing[1][:, None], helping[1][:, None])
        limit[:, rows] -= term * np.where(presses, pressing[0][:, None], helping[0][:, None])
    return twice
