# SPDX-License-Identifier: MIT
"""Some speed along a path within rows with terms in ṡ = √x, searched for among all speeds, interval by interval."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from mrts.base.arrays import Array
from mrts.kernel.programs import Programs, default_programs
from mrts.program.sample_problem import SampleProblem
from mrts.timing.fastest_profile import Obstacle, SpeedProfile, fastest_profile
from mrts.timing.speed_regions import FARTHEST, SpeedRegions, intersect_regions, speed_regions
from mrts.timing.speed_terms import Ends, RootLines, chords, tangents, without_root

FINENESS = (2.0, 2.0**0.25)
"""Ratios of the ends of an interval of x, coarse first: a tangent in its middle misses √x by 1.8 % and 0.1 % of it."""

SPAN = (2.0**-12, 2.0**4)
"""Least and largest end of an interval but the first, as a multiple of an x that the path makes likely."""


@dataclass(frozen=True)
class _Reach:
    """An interval of x at a sample from which the end is reached, and where it leads: the place of the next one."""

    low: float
    high: float
    cell: int
    next: int


def profile_through_cells(
    problems: Sequence[SampleProblem], step: Array, ends: tuple[float, float]
) -> tuple[SpeedRegions, SpeedProfile] | Obstacle:
    """A profile within limits and the regions that it takes, or where none leads on.

    The range of x is cut into intervals; on each of them the rows are replaced by stricter ones, which miss them by a
    small share of their terms in √x. Backward, the x of each interval from which the end is reached are found; they are
    exact for the stricter rows. So a profile is found if there is one that keeps limits with that share to spare.

    Args:
        problems: Rows of [F, u, x] with terms in √x, one a load.
        step: Length of each segment, Shape (n - 1,).
        ends: x at the first and the last sample.
    """
    length = float(np.sum(step))
    bare = [speed_regions(replace(one, speed=None, torque_speed=None), length, ends) for one in problems]
    likely = max(*ends, min(regions.bound for regions in bare) / FARTHEST)

    def cells(ratio: float, given: Ends) -> list[SpeedRegions]:
        steps = int(np.ceil(np.log(SPAN[1] / SPAN[0]) / np.log(ratio)))
        edges = likely * np.append(0.0, SPAN[0] * ratio ** np.arange(steps + 1))
        return [_cell(problems, length, given, *edge) for edge in pairwise(edges.tolist())]

    for ratio in FINENESS:
        tried = cells(ratio, ends)
        reaches = _reaches(tried, step)
        if reaches[0]:
            regions = _along(tried, reaches)
            found = fastest_profile(step, regions, ends)
            if isinstance(found, SpeedProfile):
                return regions, found
        if ratio == FINENESS[0] and _excluded(problems, step, ends, likely):
            break
    return _obstacle(reaches, lambda given: _reaches(cells(FINENESS[0], given), step), ends)


def _excluded(problems: Sequence[SampleProblem], step: Array, ends: tuple[float, float], likely: float) -> bool:
    """Whether rows that are weaker than the given ones leave no profile."""
    count, length = problems[0].samples, float(np.sum(step))
    nothing = RootLines(np.zeros(count), np.zeros(count)).pinned(ends)
    above = tangents(np.full(count, likely)).pinned(ends)
    regions = intersect_regions([speed_regions(without_root(one, nothing, above), length, ends) for one in problems])
    return bool(regions.undecided) or isinstance(fastest_profile(step, regions, ends), Obstacle)


def _cell(problems: Sequence[SampleProblem], length: float, ends: Ends, least: float, most: float) -> SpeedRegions:
    """Regions of stricter rows in one interval of x."""
    count = problems[0].samples
    low, high = np.full(count, least), np.full(count, most)
    middle = np.square((np.sqrt(low) + np.sqrt(high)) / 2)
    above, below = (lines.pinned(ends) for lines in (tangents(middle), chords(low, high)))
    known = tuple(0.0 if x is None else x for x in ends)
    parts = [speed_regions(without_root(one, above, below), length, (known[0], known[1])) for one in problems]
    regions = intersect_regions(parts)
    for place, x in ((0, ends[0]), (-1, ends[1])):
        if x is not None:
            low[place] = high[place] = x
    low, high = np.maximum(regions.lower, low), np.minimum(regions.upper, high)
    high[list(regions.undecided)] = -np.inf
    return replace(regions, lower=low, upper=high)


def _reaches(cells: Sequence[SpeedRegions], step: Array) -> list[list[_Reach]]:
    """At every sample the x from which the end is reached, the fastest cells first."""
    kernel, last = default_programs(), len(step)
    reaches: list[list[_Reach]] = [[] for _ in range(last + 1)]
    for number, cell in reversed(list(enumerate(cells))):
        low, high = float(cell.lower[last]), float(cell.upper[last])
        if low <= high and not any(one.low <= low and high <= one.high for one in reaches[last]):
            reaches[last].append(_Reach(low, high, number, 0))
    for i in range(last - 1, -1, -1):
        for number, cell in reversed(list(enumerate(cells))):
            found = []
            for place, ahead in enumerate(reaches[i + 1]):
                x = _backward(kernel, (cell, cells[ahead.cell]), i, float(step[i]), (ahead.low, ahead.high))
                if x is not None:
                    found.append(_Reach(*x, number, place))
            reaches[i] += _covering(found)
    return reaches


def _along(cells: Sequence[SpeedRegions], reaches: list[list[_Reach]]) -> SpeedRegions:
    """The regions of the cells that lead from the first reach to the end."""
    chosen = [reaches[0][0]]
    for ahead in reaches[1:]:
        chosen.append(ahead[chosen[-1].next])
    parts = [_planes(cells[one.cell], i) for i, one in enumerate(chosen)]
    return SpeedRegions(
        np.concatenate([[0], np.cumsum([len(part) for part in parts])]).astype(np.int64),
        np.concatenate(parts),
        np.array([cells[one.cell].lower[i] for i, one in enumerate(chosen)]),
        np.array([cells[one.cell].upper[i] for i, one in enumerate(chosen)]),
        max(cell.bound for cell in cells),
        (),
    )


def _obstacle(
    reaches: list[list[_Reach]], reached: Callable[[Ends], list[list[_Reach]]], ends: tuple[float, float]
) -> Obstacle:
    """Where no speed leads on, and at an end those that do.

    Args:
        reaches: Of all samples.
        reached: The same where another x is given at the ends.
        ends: x at the first and the last sample.
    """
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


def _backward(
    kernel: Programs, cells: tuple[SpeedRegions, SpeedRegions], i: int, step: float, reach: tuple[float, float]
) -> tuple[float, float] | None:
    """The x of one cell at sample i from which an interval of another is reached at the next sample."""
    if not cells[0].lower[i] <= cells[0].upper[i]:
        return None
    here, there = (_planes(cell, i + place) for place, cell in enumerate(cells))
    lower = np.array([cells[0].lower[i], reach[0]])
    upper = np.array([cells[0].upper[i], reach[1]])
    start = np.array([0, len(here), len(here) + len(there)], dtype=np.int64)
    failed = kernel.backward(np.array([step]), np.zeros(1), start, np.concatenate([here, there]), lower, upper)
    return None if failed >= 0 else (float(lower[0]), float(upper[0]))


def _planes(regions: SpeedRegions, i: int) -> Array:
    return np.ascontiguousarray(regions.planes[regions.start[i] : regions.start[i + 1]])


def _covering(found: list[_Reach]) -> list[_Reach]:
    """As few of some intervals as cover what all of them cover."""
    chosen: list[_Reach] = []
    left = found
    while left:
        end = chosen[-1].high if chosen else min(one.low for one in left)
        near = [one for one in left if one.low <= end]
        chosen.append(max(near, key=lambda one: one.high) if near else min(left, key=lambda one: one.low))
        left = [one for one in left if one.high > chosen[-1].high]
    return chosen
